"""Draws of loops for the benchmark: clean, with one effect of wanted size, with two, off the list.

The size of an effect is what the base model cannot absorb of it, over the RMS of the noise: the
drive's parameters imitate most of some effects, and only the rest can be seen.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hdprog.data.loop import Loop
from tests.independent.effects import EFFECTS
from tests.independent.loops import KINDS, LoopKind, LoopRecord, random_loop, suitable_effects

SEED = 47
CLEAN = ("clean", "correlated", "stepped")
"""Cases without an effect: white noise, noise with memory, steps of the angle beside the noise."""
SIZES = (0.5, 1.0, 2.0, 4.0, 8.0)
PAIR_SIZE = 4.0
LARGEST = 4e-4
"""Largest change of the angle in rad (RMS); more would be no small deviation from the model."""
OFF = 0.15
"""Part by which a size may miss the wanted one."""
DECOYS = 0.5
"""Share of records that get a temperature, and of those that get an output angle, for nothing.

The simulator records them only with the effects that need them, which would give those away.
"""
LISTED = tuple(name for name, effect in EFFECTS.items() if effect.identifier != "unknown")
UNLISTED = tuple(name for name, effect in EFFECTS.items() if effect.identifier == "unknown")

ATTEMPTS = 4
"""Drives and programmes drawn for a loop before its size is given up."""

STEP = 6.0
"""Width of the angle's steps over the noise in a stepped loop."""

_FIRST_SIZE = 2e-5
_TRIES = 6
_AIM = 0.03
_LOOP, _CHOICE, _DECOY, _FIT = range(4)  # streams of random numbers of one loop


class NotDrawable(Exception):
    """The loop cannot carry its effects at the wanted size."""


@dataclass(frozen=True)
class Case:
    """A cell of the benchmark.

    Attributes
    ----------
    name : "clean", "correlated", "stepped", "pair", or an effect and its size: "creep@2"
    """

    name: str

    @property
    def effect(self) -> str | None:
        """Name of the one effect in the simulator."""
        return self.name.split("@")[0] if "@" in self.name else None

    @property
    def size(self) -> float:
        """Wanted size of each effect over the noise."""
        if "@" in self.name:
            return float(self.name.split("@")[1])
        return PAIR_SIZE if self.name == "pair" else 0.0

    def rng(self, index: int, stream: int, attempt: int = 0) -> np.random.Generator:
        """Random numbers of one loop of the case, always the same."""
        key = zlib.crc32(self.name.encode())
        return np.random.default_rng([SEED, key, index, stream, attempt])

    def fit_rng(self, index: int) -> np.random.Generator:
        """Random numbers of a loop's fit."""
        return self.rng(index, _FIT)


def cases(effects: Sequence[str]) -> list[Case]:
    """One case for every effect and size."""
    return [Case(f"{name}@{size:g}") for name in effects for size in SIZES]


@dataclass(frozen=True)
class Drawn:
    """A loop as the fit sees it, and what is in it.

    Attributes
    ----------
    loop : the record
    kind : of the torque programme
    sizes : effect → RMS change of the angle in rad
    reached : effect → what the base model cannot absorb of it, over the noise
    noise : RMS of the noise in rad, that of the torque converted by the local compliance
    decoys : columns that were recorded for nothing
    rejected : draws before it that could not carry the effects
    """

    loop: Loop
    kind: LoopKind
    sizes: dict[str, float]
    reached: dict[str, float]
    noise: float
    decoys: tuple[str, ...]
    rejected: int


def draw(case: Case, index: int) -> Drawn:
    """One loop of a case.

    Raises
    ------
    NotDrawable
        if the wanted size is out of reach of every attempt
    """
    reasons = []
    for attempt in range(ATTEMPTS):
        try:
            return _attempted(case, index, attempt)
        except NotDrawable as reason:
            reasons.append(str(reason))
    raise NotDrawable("; ".join(reasons))


def _attempted(case: Case, index: int, attempt: int) -> Drawn:
    choice = case.rng(index, _CHOICE, attempt)
    names = [case.effect] if case.effect else _pair(choice) if case.name == "pair" else []
    kinds = _kinds(names)
    kind = kinds[int(choice.integers(len(kinds)))]
    sizes: dict[str, float] = {}
    reached: dict[str, float] = {}
    for name in names:
        sizes[name], reached[name] = _sized(case, index, attempt, kind, name, names)
    record = random_loop(
        case.rng(index, _LOOP, attempt), kind, effects=sizes, correlated=case.name == "correlated"
    )
    loop, decoys = _loop(record, case.rng(index, _DECOY, attempt))
    noise = noise_rms(record)
    if case.name == "stepped":
        step = STEP * noise
        loop = replace(loop, angle=step * np.round(loop.angle / step))
    return Drawn(loop, kind, sizes, reached, noise, decoys, attempt)


def noise_rms(record: LoopRecord) -> float:
    """RMS of the noise on the angle in rad, the torque's converted by the local compliance."""
    chain = record.truth["noise"]
    assert isinstance(chain, dict)
    steps = np.gradient(record.true_torque)
    moving = np.abs(steps) > 1e-6
    compliance = np.gradient(record.base_angle)[moving] / steps[moving]
    middle = np.median(compliance)
    square = np.mean(np.clip(compliance, 0.3 * middle, 6.0 * middle) ** 2)
    angle = chain["angle_noise"] ** 2 + chain["angle_step"] ** 2 / 12
    torque = chain["torque_noise"] ** 2 + chain["torque_step"] ** 2 / 12
    return float(np.sqrt(angle + square * torque))


def _kinds(names: Sequence[str]) -> list[LoopKind]:
    """Kinds of loops that show all these effects."""
    return [kind for kind in KINDS if set(names) <= set(suitable_effects(kind))]


def _pair(rng: np.random.Generator) -> list[str]:
    """Two effects with different identifiers that one kind of loop shows."""
    while True:
        names = [str(name) for name in rng.choice(LISTED, 2, replace=False)]
        if len({EFFECTS[name].identifier for name in names}) == 2 and _kinds(names):
            return names


def _sized(
    case: Case, index: int, attempt: int, kind: LoopKind, name: str, names: Sequence[str]
) -> tuple[float, float]:
    """Size of one effect in rad, the others absent, and the size over the noise it comes to."""
    size = _FIRST_SIZE
    factor = 0.0
    for _ in range(_TRIES):
        # Those of size zero draw their constants all the same, so that the loop stays the same.
        effects = {one: size if one == name else 0.0 for one in names}
        try:
            rng = case.rng(index, _LOOP, attempt)
            record = random_loop(rng, kind, effects=effects, absorption=True)
        except ValueError as error:
            raise NotDrawable(str(error)) from error
        left = record.truth["unabsorbed_rmse_rad"]
        assert isinstance(left, float)
        wanted = case.size * noise_rms(record)
        factor = left / wanted
        if abs(factor - 1.0) < _AIM or (size == LARGEST and factor < 1.0):
            break
        size = min(size * float(np.clip(1.0 / max(factor, 1e-9), 0.1, 10.0)), LARGEST)
    if abs(factor - 1.0) > OFF:
        raise NotDrawable(f"{name}: {factor:.2g} of the wanted size with {size:.1e} rad")
    return size, factor * case.size


def _loop(record: LoopRecord, rng: np.random.Generator) -> tuple[Loop, tuple[str, ...]]:
    """The record as a rig hands it on, with columns that tell nothing, and their names."""
    columns = {"temperature": record.temperature, "output_angle": record.output_angle}
    makers = {"temperature": _room, "output_angle": _turning}
    decoys = []
    for name, maker in makers.items():
        wanted = bool(rng.random() < DECOYS)
        made = maker(record, rng)
        if wanted and columns[name] is None:
            columns[name] = made
            decoys.append(name)
    loop = Loop(
        torque=record.torque,
        angle=record.angle,
        time=record.time,
        temperature=columns["temperature"],
        output_angle=columns["output_angle"],
    )
    return loop, tuple(decoys)


def _room(record: LoopRecord, rng: np.random.Generator) -> NDArray[np.float64]:
    """Temperature of a drive that warms up without a mark on the angle, in °C."""
    clock = (record.time - record.time[0]) / np.ptp(record.time)
    warm = 1.0 - np.exp(-clock / rng.uniform(0.25, 0.8))
    course = rng.uniform(18.0, 26.0) + rng.uniform(0.0, 15.0) * warm
    return np.asarray(course + 0.05 * rng.standard_normal(clock.size))


def _turning(record: LoopRecord, rng: np.random.Generator) -> NDArray[np.float64]:
    """Position of an output that creeps round without a mark on the angle, in rad."""
    clock = (record.time - record.time[0]) / np.ptp(record.time)
    sweep = rng.uniform(0.15, 0.4) * rng.choice((-1.0, 1.0))
    return np.asarray(rng.uniform(0.0, 2.0 * np.pi) + sweep * clock + record.base_angle)
