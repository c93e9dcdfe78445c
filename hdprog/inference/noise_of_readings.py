"""The noise of blocks as the readings inside them tell it, where it has a memory.

A few hundred blocks tell badly how long noise remembers and what share of it does; the readings
that they are means of tell more, and more of its scale. So the shapes are weighed by what the best
fit leaves of finer blocks, and averaged over the readings of each block. The fit itself rests on
the blocks: where these scatter by more or less than their readings say, or hang together still,
the noise is no Ornstein-Uhlenbeck process through and through, and what the blocks say of it stands
(tests/inference/test_noise_of_readings.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hdprog.data.reduce import ReducedLoop, reduce_loop
from hdprog.inference.effective_blocks import effective_degrees
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.measured_noise import reading_noise
from hdprog.inference.noise import NoiseModel
from hdprog.inference.noise_shape import Shapes, fit_shapes
from hdprog.inference.prepare import Prepared, left_by_fit
from hdprog.inference.starting_points import StartingPoint, modes_near
from hdprog.inference.within_blocks import WithinBlocks
from hdprog.physics.parameters import FloatArray

_FINE = 2000  # blocks: noise that they average away is white in the blocks of the fit
_FINER = 1.5  # times as many as those of the fit, or they tell nothing more


@dataclass(frozen=True)
class _Fine:
    """A record in finer blocks than those of its fit, and what the fit leaves of them.

    Attributes
    ----------
    reduced : the record
    residual : (fine,) in rad
    sensitivities : (fine, k) derivatives of the fit that absorbed part of it
    sd : (fine,) relative standard deviation of the white part in rad
    """

    reduced: ReducedLoop
    residual: FloatArray
    sensitivities: FloatArray
    sd: FloatArray

    @staticmethod
    def of(prepared: Prepared, likelihood: LoopLikelihood, start: StartingPoint) -> _Fine:
        loop, noise, blocks = prepared.loop, likelihood.noise, likelihood.reduced
        reduced = reduce_loop(
            loop,
            prepared.turning_points,
            reading_noise(loop, prepared.drive.noise)[0],
            prepared.kept,
            _FINE,
            prepared.record_course,
        )
        of_reading = noise.white_sd * np.sqrt(blocks.count)
        sd = np.interp(reduced.position, blocks.position, of_reading) / np.sqrt(reduced.count)
        white = replace(likelihood, reduced=reduced, noise=NoiseModel.white(sd))
        residual, sensitivities = left_by_fit(white, start)
        if noise.term is not None:
            missing = blocks.angle - likelihood.angle(start.point[None, :])[0]
            missing = missing - likelihood.offset(missing)
            features = noise.term.features(reduced.course)
            residual = residual - features @ noise.coefficients(missing)
        return _Fine(reduced, residual, sensitivities, sd)


def with_noise_of_readings(
    prepared: Prepared, likelihood: LoopLikelihood, starts: list[StartingPoint]
) -> tuple[LoopLikelihood, list[StartingPoint], WithinBlocks | None]:
    """A likelihood whose noise has a memory, with the noise that the readings tell.

    Parameters
    ----------
    prepared : the record
    likelihood : with the noise that its blocks tell
    starts : its modes, best first

    Returns
    -------
    the likelihood and its modes, and what the readings inside the blocks say of the noise scale;
    as they were, and None, where there is nothing more to tell or blocks and readings disagree
    """
    as_it_was = likelihood, starts, None
    if likelihood.noise.log_ratio is None or likelihood.reduced.path.variance is None:
        return as_it_was
    fine = _Fine.of(prepared, likelihood, starts[0])
    if fine.sd.size < _FINER * likelihood.blocks:
        return as_it_was
    shapes = fit_shapes(fine.residual, fine.sensitivities, fine.sd, fine.reduced.moment)
    if shapes is None:
        return as_it_was
    told = replace(likelihood, noise=_of_blocks(shapes, prepared, likelihood))
    again = modes_near(told, [start.point for start in starts])
    residual = told.residual(again[0].point[None, :])[0]
    squares, degrees = float(residual @ residual), told.block_degrees - told.size
    within = WithinBlocks(shapes.squares - squares, shapes.degrees - degrees)
    hang_together = effective_degrees(told, again[0]) < told.block_degrees
    if hang_together or not within.agrees(squares, degrees):
        return as_it_was
    return told, again, within


def _of_blocks(shapes: Shapes, prepared: Prepared, likelihood: LoopLikelihood) -> NoiseModel:
    """The noise of the blocks of a fit, from the shapes that finer ones leave possible."""
    loop, reduced, noise = prepared.loop, likelihood.reduced, likelihood.noise
    used = reduced.block_of >= 0
    index = np.arange(len(loop), dtype=np.float64)
    readings = index if reduced.time is None or loop.time is None else loop.time
    covariance = shapes.covariance_of_means(readings[used], reduced.block_of[used])
    told = noise.as_white.with_decaying(covariance, shapes.variance, shapes.length, reduced.moment)
    return told if noise.term is None else told.with_term(noise.term, reduced.course)
