"""Make a record ready for its fit: reduce it, set spikes aside, find modes and noise."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hdprog.config import Drive
from hdprog.data.first_stretches import first_stretches
from hdprog.data.gross_errors import levelled
from hdprog.data.loop import Loop
from hdprog.data.turning_points import turning_points
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.noise import NoiseModel
from hdprog.inference.noise_shape import fit_noise
from hdprog.inference.prior_file import prior_of_drive
from hdprog.inference.priors import Prior, RecordScales
from hdprog.inference.sound_reduction import SoundRecord, sound_reduction
from hdprog.inference.spikes import remark_on_spikes
from hdprog.inference.starting_points import StartingPoint, starting_points
from hdprog.physics.course import Course
from hdprog.physics.figures import Operation
from hdprog.physics.parameters import FloatArray


@dataclass(frozen=True)
class Prepared:
    """A record ready for its fit.

    Attributes
    ----------
    loop, drive, operation : what is fitted, and what its figures refer to
    likelihood : of the drive model alone, noise white
    starts : its modes, best first
    turning_points : indices of the record's first reading, reversals and last reading
    kept : (samples,) False for readings set aside as spikes
    record_course : coordinates of the whole record
    noise_floor : scatter of neighbouring residuals about a smooth course, in rad
    warnings : in words
    """

    loop: Loop
    drive: Drive
    operation: Operation
    likelihood: LoopLikelihood
    starts: list[StartingPoint]
    turning_points: NDArray[np.intp]
    kept: NDArray[np.bool_]
    record_course: Course
    noise_floor: float
    warnings: tuple[str, ...]


def scales_of(loop: Loop) -> RecordScales:
    """Scales of a record for a generic prior, readings that are wrong beyond doubt left out."""
    sound, _ = levelled(loop)
    return RecordScales.of(sound.torque, sound.angle)


def prepare(
    loop: Loop,
    drive: Drive,
    rng: np.random.Generator,
    *,
    prior: Prior | None = None,
) -> Prepared:
    """Reduce a record, set spikes aside and find the modes of the drive model on it.

    Parameters
    ----------
    loop : the record
    drive : its declared constants, prior and noise
    rng : for the starts of the search
    prior : overrides the drive's own

    Raises
    ------
    BadInputError
        if the drive names a prior that does not exist
    """
    warnings = list(loop.warnings)
    record = loop
    sound, wrong = levelled(record)
    points = turning_points(sound.torque, time=sound.time)
    loop, points, remark = first_stretches(record, points)
    warnings += [remark] if remark else []
    if loop is not record:
        sound, wrong = levelled(loop)
    if prior is None:
        prior, remark = prior_of_drive(drive, RecordScales.of(sound.torque, sound.angle))
        warnings += [remark] if remark else []
    operation, remark = operation_of(drive, prior, sound)
    warnings += [remark] if remark else []
    if not drive.alpha_declared:
        warnings.append(
            f"The gear-tooth angle is not declared: {math.degrees(drive.alpha):.0f}° is assumed. "
            "K_W, mu, c and the preload depend on it; stiffness and hysteresis hardly do where the "
            "teeth slip within the record."
        )
    levelled_record = SoundRecord(sound, wrong, points, drive, prior)
    found = sound_reduction(levelled_record, rng)
    remark = remark_on_spikes(found.out)
    warnings += [remark] if remark else []
    return Prepared(
        loop=loop,
        drive=drive,
        operation=operation,
        likelihood=found.likelihood,
        starts=found.starts,
        turning_points=points,
        kept=~found.out,
        record_course=levelled_record.whole,
        noise_floor=found.noise_floor,
        warnings=tuple(warnings),
    )


def operation_of(drive: Drive, prior: Prior, loop: Loop) -> tuple[Operation, str | None]:
    """The torques that a drive's figures refer to, and a remark where the record must stand in."""
    largest = float(np.max(np.abs(loop.torque)))
    rated, remark = drive.rated_torque, None
    if rated is None:
        rated = float(f"{largest:.3g}")
        remark = (
            f"The drive's rated torque is not given: figures of merit refer to {rated:g} Nm, "
            "the record's largest torque. Set rated_torque_Nm in drive.toml to compare tests."
        )
    reference = drive.reference_torque if drive.reference_torque is not None else rated
    return Operation(drive.alpha, reference, rated, prior.catalogue_torques), remark


def settle_noise(
    likelihood: LoopLikelihood, starts: list[StartingPoint], rng: np.random.Generator
) -> tuple[LoopLikelihood, list[StartingPoint]]:
    """Find the shape of the noise about the best mode; where it is not white, the modes again.

    Returns
    -------
    the likelihood with its noise, and its modes, best first
    """
    noise = noise_about(likelihood, starts[0])
    if noise.whitening is None:
        return likelihood, starts
    correlated = replace(likelihood, noise=noise)
    return correlated, starting_points(correlated, rng, known=[start.point for start in starts])


def noise_about(likelihood: LoopLikelihood, start: StartingPoint) -> NoiseModel:
    """Noise from what a mode and its empirical term leave, the sensitivities projected out."""
    sd, reduced = likelihood.noise.white_sd, likelihood.reduced
    white = replace(likelihood, noise=likelihood.noise.as_white)
    residual, sensitivities = left_by_fit(white, start)
    if likelihood.noise.term is not None:
        left = reduced.angle - likelihood.angle(start.point[None, :])[0]
        left = left - likelihood.offset(left)
        residual = left - likelihood.noise.smooth_part(left)
    return fit_noise(residual, sensitivities, sd, reduced.moment)


def left_by_fit(white: LoopLikelihood, start: StartingPoint) -> tuple[FloatArray, FloatArray]:
    """What a mode leaves under white noise, (blocks,) in rad, and what it was fitted with.

    The latter are the derivatives of the angle (blocks, size + 1) by the point and the offset.
    """
    residual, derivative = white.jacobian(start.point)
    sd = white.noise.white_sd
    return residual * sd, np.hstack([derivative * sd[:, None], np.ones((sd.size, 1))])
