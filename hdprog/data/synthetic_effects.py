"""Effects put into a simulated drive, with parameters that are drawn once for all its tests."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hdprog.data.coordinates import record_course
from hdprog.data.loop import Loop
from hdprog.errors import UsageError
from hdprog.physics.course import Course
from hdprog.physics.drive_model import slip_envelope, torsion_angle
from hdprog.physics.effects import BY_ID
from hdprog.physics.effects.base import Effect, Values
from hdprog.physics.effects.model import EffectSet
from hdprog.physics.parameters import FloatArray, Parameters
from hdprog.physics.torque_path import TorquePath

RATES = (1.0, 4.0, 12.0)  # of loading, relative: one cycle each, in turn
_SWEEP = 0.3  # rad that the output creeps round over a record
_AMPLITUDE, _SHAPE = (0.5, 1.5), 0.7  # coordinates: large enough to see, shapes of no rare kind
_LEAST = 3e-3  # of half the angle's range, rms: a bump at a torque never reached adds less
_ATTEMPTS = 100


def chosen_effects(ids: Iterable[str], *, cycles: int, one_sided: bool) -> tuple[Effect, ...]:
    """Effects of these ids, each once, if the loop asked for can show them.

    Raises
    ------
    UsageError
        if an id is unknown, or the loop lacks what an effect needs
    """
    ids = tuple(dict.fromkeys(ids))
    unknown = [name for name in ids if name not in BY_ID]
    if unknown:
        raise UsageError(
            f"--effect: found {', '.join(unknown)}; expected one of {', '.join(BY_ID)}."
        )
    chosen = tuple(BY_ID[name] for name in ids)
    paced = [effect.id for effect in chosen if "several loading rates" in effect.needs]
    if paced and cycles < len(RATES):
        raise UsageError(
            f"--cycles: found {cycles}, expected {len(RATES)} or more: {' and '.join(paced)} shows "
            "at several loading rates only, and each cycle has one. Raise --cycles."
        )
    mirrored = [effect.id for effect in chosen if "both signs of torque" in effect.needs]
    if mirrored and one_sided:
        raise UsageError(
            f"--one-sided: found it with --effect {' and '.join(mirrored)}, expected a loop with "
            "torque of both signs, without which the effect does not show. Leave one of them out."
        )
    return chosen


def rates_of(effects: Iterable[Effect]) -> tuple[float, ...]:
    """Relative loading rates that the cycles take in turn."""
    return RATES if any("several loading rates" in effect.needs for effect in effects) else (1.0,)


@dataclass
class AddedEffects:
    """Effects with fixed parameters on one loading programme, and an account of what they add.

    Attributes
    ----------
    members : the effects, with priors that suit the programme
    values : physical values by effect and parameter, (1, 1) each
    torque, time : (samples,) the programme, which the torque sensor reads, in Nm and s
    output_angle : (samples,) absolute output position in rad; None where no effect needs it
    alpha : gear-tooth angle in rad
    squares : by effect, of each test so far: mean square of what it adds to the angle in rad²
    """

    members: EffectSet
    values: dict[str, Values]
    torque: FloatArray
    time: FloatArray
    output_angle: FloatArray | None
    alpha: float
    squares: dict[str, list[float]] = field(default_factory=dict)

    @classmethod
    def drawn(
        cls,
        effects: Sequence[Effect],
        parameters: Mapping[str, float],
        torque: FloatArray,
        time: FloatArray,
        alpha: float,
        seed: int,
    ) -> AddedEffects:
        """Draw parameters of visible size, for each effect the same whatever else is added.

        Parameters
        ----------
        effects : as chosen
        parameters : of the new drive, scalars by name
        torque, time : (samples,) in Nm and s
        alpha : gear-tooth angle in rad
        seed : of the whole drive; the effects draw from streams of their own
        """
        output_angle = None
        if any("output angle" in effect.needs for effect in effects):
            # Evenly over the readings, so that they resolve the lines equally well everywhere.
            output_angle = np.linspace(0.0, _SWEEP, torque.size)
        drive = _arrays(parameters)
        plain = torsion_angle(TorquePath.exact(torque), drive, alpha)[0]
        course = _course(torque, plain, time, output_angle)
        values: dict[str, Values] = {}
        for effect in effects:
            alone = EffectSet((effect,), course.scales)
            rng = np.random.default_rng([seed, *effect.id.encode()])
            for _ in range(_ATTEMPTS):
                drawn = alone.values(_coordinates(alone, rng))
                whole = alone.angle(course, drive, drawn, alpha, np.full(1, 0.5))
                if _rms(whole[0] - plain) > _LEAST * course.scales.angle:
                    break
            values |= drawn
        members = EffectSet(tuple(effects), course.scales)
        return cls(members, values, torque, time, output_angle, alpha)

    def added(self, parameters: Mapping[str, float], initial_slip: float) -> FloatArray:
        """What the effects add to the torsion angle of one test, entered in the account.

        Parameters
        ----------
        parameters : of the drive as mounted, scalars by name
        initial_slip : where the mesh stood before the first reading, in rad

        Returns
        -------
        (samples,) in rad
        """
        drive, path = _arrays(parameters), TorquePath.exact(self.torque)
        fraction = _fraction(path, drive, self.alpha, initial_slip)
        plain = torsion_angle(path, drive, self.alpha, initial_fraction=fraction)[0]
        course = _course(self.torque, plain, self.time, self.output_angle)

        def angle(effects: tuple[Effect, ...]) -> FloatArray:
            chosen = EffectSet(effects, self.members.scales)
            return np.asarray(chosen.angle(course, drive, self.values, self.alpha, fraction)[0])

        whole = angle(self.members.effects)
        for effect in self.members.effects:
            others = tuple(other for other in self.members.effects if other is not effect)
            share = _rms(whole - angle(others)) ** 2
            self.squares.setdefault(effect.id, []).append(share)
        return np.asarray(whole - plain)

    def truth(self) -> list[dict[str, Any]]:
        """Return what was added, effect by effect, as `truth.json` says it."""
        entries = []
        for effect in self.members.effects:
            described = effect.parameters(self.members.scales)
            values = self.values[effect.id]
            entries.append(
                {
                    "id": effect.id,
                    "parameters": {each.name: float(values[each.name][0, 0]) for each in described},
                    "units": {each.name: each.unit for each in described},
                    "rms_rad": math.sqrt(np.mean(self.squares[effect.id])),
                }
            )
        return entries


def _arrays(parameters: Mapping[str, float]) -> Parameters:
    return {name: np.asarray(value) for name, value in parameters.items()}


def _course(
    torque: FloatArray, angle: FloatArray, time: FloatArray, output_angle: FloatArray | None
) -> Course:
    loop = Loop(torque, angle, time, output_angle=output_angle)
    return record_course(loop, TorquePath.exact(torque), 0.0)


def _coordinates(effects: EffectSet, rng: np.random.Generator) -> FloatArray:
    """Coordinates (1, size): amplitudes well above their usual size, shapes near the usual."""
    coordinates = np.empty((1, effects.size))
    for index, (_, parameter) in enumerate(effects.parameters):
        if not parameter.amplitude:
            coordinates[0, index] = rng.uniform(-_SHAPE, _SHAPE)
            continue
        signed = parameter.transform in ("signed", "normal")
        sign = rng.choice([-1.0, 1.0]) if signed else 1.0
        coordinates[0, index] = sign * rng.uniform(*_AMPLITUDE)
    return coordinates


def _fraction(
    path: TorquePath, parameters: Parameters, alpha: float, initial_slip: float
) -> FloatArray:
    """Place (1,) of an initial slip on the way from the lower to the upper envelope."""
    first = path.torque[0] * np.array([1.0, -1.0])
    lower, above = slip_envelope(first, parameters, alpha)[0]
    width = -above - lower
    if width <= 0:
        return np.full(1, 0.5)
    return np.full(1, min(max((initial_slip - lower) / width, 0.0), 1.0))


def _rms(values: FloatArray) -> float:
    return math.sqrt(np.mean(values**2))
