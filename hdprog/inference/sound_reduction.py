"""A record reduced to blocks, its spikes set aside and its modes found, until these agree."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.reduce import (
    ReducedLoop,
    enough_blocks,
    fewest_blocks,
    reduce_loop,
    whole_course,
)
from hdprog.inference.block_detail import bend, detail
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.measured_noise import (
    block_noise,
    local_slope,
    noise_floor,
    reading_noise,
    reading_sd,
    rounding_noise,
)
from hdprog.inference.noise import NoiseModel
from hdprog.inference.priors import Prior
from hdprog.inference.spikes import spikes
from hdprog.inference.starting_points import StartingPoint, starting_points
from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray

_ATTEMPTS = 5  # a fit shows spikes that were hidden in the residual of the one before
_UNSEEN = 0.1  # of a block's noise
# Times the noise that the drive model may leave of a record, to be said to describe it. Beyond,
# finer blocks show but more of what it lacks.
_DESCRIBED = 4.0


@dataclass(frozen=True)
class SoundRecord:
    """A record whose wrong torque readings are levelled.

    Attributes
    ----------
    loop : the readings
    wrong : (samples,) readings that are wrong beyond doubt
    points : indices of the first reading, reversals and the last reading
    drive, prior : of its fit
    """

    loop: Loop
    wrong: NDArray[np.bool_]
    points: NDArray[np.intp]
    drive: Drive
    prior: Prior

    @cached_property
    def noise(self) -> tuple[float, float]:
        """Standard deviation of a torque reading in Nm and of an angle reading in rad."""
        return reading_noise(self.loop, self.drive.noise)

    @cached_property
    def whole(self) -> Course:
        """Coordinates of every reading."""
        return whole_course(self.loop, self.points, self.noise[0])

    def reduced(
        self,
        kept: NDArray[np.bool_],
        most_blocks: int,
        wanted: FloatArray | None = None,
    ) -> ReducedLoop:
        """The kept readings in about so many blocks; see `reduce_loop`."""
        return reduce_loop(
            self.loop, self.points, self.noise[0], kept, most_blocks, self.whole, wanted
        )

    def white(self, reduced: ReducedLoop, course: FloatArray) -> LoopLikelihood:
        """Likelihood of blocks beside white noise, by the slope of an angle's course along them."""
        sd = block_noise(reduced, local_slope(reduced.path.torque, course), *self.noise)
        return LoopLikelihood(reduced, self.prior, self.drive.alpha, NoiseModel.white(sd))

    def residual(
        self, likelihood: LoopLikelihood, start: StartingPoint
    ) -> tuple[FloatArray, FloatArray]:
        """(samples,) what a mode leaves in rad, and dΔθ/dT in rad/Nm of the blocks about them."""
        reduced = likelihood.reduced
        slope = local_slope(reduced.path.torque, _best_angle(likelihood, start))
        slope = np.interp(np.arange(len(self.loop)), reduced.position, slope)
        return self.loop.angle - _best_angle(likelihood.at_course(self.whole), start), slope

    def out(self, residual: FloatArray, slope: FloatArray) -> NDArray[np.bool_]:
        """(samples,) readings to set aside: wrong ones, and spikes in what a mode leaves."""
        step = float(np.median(slope * np.abs(np.gradient(self.loop.torque))))
        sd = reading_sd(slope, *self.noise)
        return self.wrong | spikes(residual, sd, self.points, step, self.loop.torque)

    def noise_floor(
        self, residual: FloatArray, slope: FloatArray, kept: NDArray[np.bool_]
    ) -> float:
        """Scatter in rad of neighbouring residuals; see `measured_noise.noise_floor`."""
        time = None if self.loop.time is None else self.loop.time[kept]
        rounding = rounding_noise(self.loop, self.drive.noise)
        return noise_floor(residual[kept], time, slope[kept], self.noise, rounding)


@dataclass(frozen=True)
class SoundReduction:
    """What is fitted of a record.

    Attributes
    ----------
    likelihood : of the drive model alone, noise white
    starts : its modes, best first
    out : (samples,) readings that were set aside
    noise_floor : scatter of neighbouring residuals about a smooth course, in rad
    """

    likelihood: LoopLikelihood
    starts: list[StartingPoint]
    out: NDArray[np.bool_]
    noise_floor: float


def sound_reduction(record: SoundRecord, rng: np.random.Generator) -> SoundReduction:
    """Reduce a record, set spikes aside and find the modes of the drive model on it.

    Parameters
    ----------
    record : to reduce
    rng : for the starts of the search
    """
    blocks = fewest_blocks(record.points)
    reduced = record.reduced(~record.wrong, blocks)
    likelihood = record.white(reduced, reduced.angle)
    starts = starting_points(likelihood, rng)
    out = record.out(*record.residual(likelihood, starts[0]))
    described = _misfit(likelihood, starts[0]) < _DESCRIBED
    blocks = enough_blocks(record.loop.torque, record.points) if described else blocks
    averaged = reduced.path.variance is not None
    wanted = detail(likelihood, starts[0]) if described and averaged else None
    for attempt in range(_ATTEMPTS):
        reduced = record.reduced(~out, blocks, wanted)
        before = replace(likelihood, reduced=reduced)
        fitted, bent = _best_angle(before, starts[0]), bend(before, starts[0])
        likelihood = record.white(replace(reduced, angle=reduced.angle - bent), fitted)
        known = [start.point for start in starts]
        starts = starting_points(likelihood, rng, starts=3, known=known)
        residual, slope = record.residual(likelihood, starts[0])
        found = record.out(residual, slope)
        settled = (found == out).all() and _settled(likelihood, starts[0], bent)
        if settled or attempt == _ATTEMPTS - 1:
            break
        out = found
    floor = record.noise_floor(residual, slope, ~out)
    return SoundReduction(likelihood, starts, out, floor)


def _misfit(likelihood: LoopLikelihood, start: StartingPoint) -> float:
    """What a mode leaves, in units of the noise that was measured."""
    return float(np.sqrt(np.mean(likelihood.residual(start.point[None, :]) ** 2)))


def _settled(likelihood: LoopLikelihood, start: StartingPoint, bent: FloatArray) -> bool:
    """Whether the bend that was taken out of the blocks' angles is that of the mode found."""
    change = np.abs(bend(likelihood, start) - bent)
    return bool((change < _UNSEEN * likelihood.noise.sd).all())


def _best_angle(likelihood: LoopLikelihood, start: StartingPoint) -> FloatArray:
    return np.asarray(likelihood.angle(start.point[None, :])[0])
