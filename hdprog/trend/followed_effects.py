"""Effects that wear brought beside the drive model, or that came at once, over service time.

Their amplitudes are part of the drive's state, in units of the largest that any test showed, so
that they may begin at zero. Their other numbers (where a bump lies, how soon a contact slips) are
each test's own; figures of merit take them as the last test that shows the effect has them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hdprog.physics.course import Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values
from hdprog.physics.effects.model import EffectSet
from hdprog.physics.parameters import FloatArray
from hdprog.physics.steady_cycle import LastingEffects

Name = tuple[str, str]
"""Ids of an effect and of one of its parameters."""
SMALLEST = 1e-3
"""Units below which a positive amplitude is evaluated here and continued as a straight line."""
_OF_FRICTION = ("coulomb_friction", "microslip")
_STEP = 1e-4  # units, of the slope


@dataclass(frozen=True)
class FollowedEffects:
    """Effects whose amplitudes are part of a drive's state.

    Attributes
    ----------
    effects : all lasting and static
    scales : of the record that `values` belong to
    units : amplitude → its size that counts as one, in its own unit
    values : every parameter → its value where the effect was last seen
    """

    effects: tuple[Effect, ...]
    scales: Scales
    units: Mapping[Name, float]
    values: Mapping[Name, float]

    @staticmethod
    def of(
        effects: Sequence[Effect], found: Sequence[tuple[Scales, Mapping[str, Values]]]
    ) -> FollowedEffects:
        """From what the tests found.

        Parameters
        ----------
        effects : to follow, each found in one test at least
        found : scales and physical values by effect and name, (draws, 1) each, of every test in
            order of service; a test may lack an effect
        """
        units: dict[Name, float] = {}
        values: dict[Name, float] = {}
        scales = found[-1][0]
        for own_scales, tests in found:
            for effect in effects:
                if effect.id not in tests:
                    continue
                scales = own_scales
                for parameter in effect.parameters(own_scales):
                    name = (effect.id, parameter.name)
                    values[name] = float(np.median(tests[effect.id][parameter.name]))
                    if parameter.amplitude:
                        units[name] = max(units.get(name, 0.0), abs(values[name]))
        return FollowedEffects(tuple(effects), scales, units, values)

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of the effects."""
        return tuple(effect.id for effect in self.effects)

    @property
    def owners(self) -> tuple[str, ...]:
        """(size) id of the effect that each amplitude belongs to."""
        return tuple(effect for effect, _ in self.units)

    @property
    def greased(self) -> tuple[bool, ...]:
        """(size) whether each amplitude is of friction, which new grease may change at once."""
        return tuple(effect in _OF_FRICTION for effect in self.owners)

    @property
    def size(self) -> int:
        """How many amplitudes the state has."""
        return len(self.units)

    @cached_property
    def _amplitudes(self) -> dict[Name, EffectParameter]:
        every = EffectSet(self.effects, self.scales).parameters
        return {(one.id, p.name): p for one, p in every if p.amplitude}

    def amplitudes(self, values: Mapping[str, Values], draws: int) -> FloatArray:
        """(draws, size) of a test's physical values; zero for an effect that it lacks."""
        columns = [
            values[effect][name][:, 0] / unit if effect in values else np.zeros(draws)
            for (effect, name), unit in self.units.items()
        ]
        return np.stack(columns, axis=1)

    def amplitude_values(self, amplitudes: FloatArray) -> dict[Name, FloatArray]:
        """Physical values (draws, 1) of amplitudes (draws, size), also of negative ones."""
        each = zip(self.units.items(), amplitudes.T, strict=True)
        return {name: unit * column[:, None] for (name, unit), column in each}

    def lasting(self, amplitudes: FloatArray) -> LastingEffects:
        """The effects of the steady cycle for amplitudes (draws, size); none is below absent."""
        draws = amplitudes.shape[0]
        values: dict[str, dict[str, FloatArray]] = {effect.id: {} for effect in self.effects}
        for (effect, name), value in self.values.items():
            values[effect][name] = np.full((draws, 1), value)
        for index, (key, unit) in enumerate(self.units.items()):
            one_sided = self._amplitudes[key].transform == "log"
            column = np.maximum(amplitudes[:, index], 0.0) if one_sided else amplitudes[:, index]
            values[key[0]][key[1]] = unit * column[:, None]
        return LastingEffects(EffectSet(self.effects, self.scales), dict(values))

    def located(self, name: Name, parameter: EffectParameter, amplitudes: FloatArray) -> Located:
        """Where amplitudes (draws,) of the state lie in an effect's own coordinate."""
        unit = self.units[name]
        values = amplitudes * unit
        if parameter.transform == "log":
            values = np.maximum(values, SMALLEST * unit)
        return Located(parameter, unit, values, amplitudes - values / unit)


@dataclass(frozen=True)
class Located:
    """Amplitudes in an effect's coordinate.

    Attributes
    ----------
    parameter : of the effect
    unit : size that counts as one
    values : (draws,) physical, where the effect is evaluated
    beyond : (draws,) part of the amplitude that a straight line has to continue
    """

    parameter: EffectParameter
    unit: float
    values: FloatArray
    beyond: FloatArray

    @property
    def coordinate(self) -> FloatArray:
        """(draws,) where the effect is evaluated."""
        return self.parameter.coordinates(self.values)

    @property
    def slope(self) -> FloatArray:
        """(draws,) of the coordinate by the amplitude."""
        ahead = self.parameter.coordinates(self.values + _STEP * self.unit)
        return (ahead - self.coordinate) / _STEP
