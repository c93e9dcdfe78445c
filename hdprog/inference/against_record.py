"""Hold a fit against what the record itself shows of width, loss, lost motion and stiffness.

A model that lacks something may fit most of a loop well and miss a figure: its interval tells how
well the parameters are known, not whether the curve goes where the readings are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hdprog.data.read_off import Reading, readings
from hdprog.inference.posterior import Posterior
from hdprog.physics.figures import FigureRequest
from hdprog.physics.parameters import FloatArray
from hdprog.results import DEVIATIONS_IN_90, ReadOff, by_level

_DRAWS = 400
_MISSED = 3.5
"""Standard deviations of a gap by chance beyond which it is none."""
_LEAST_SPREAD = 0.7  # of a reading's noise: how much of it a fit shares is known roughly
_MATTERS = 0.03  # of the larger one of both


def against_record(posterior: Posterior, requests: Sequence[FigureRequest]) -> dict[str, ReadOff]:
    """Figures read off the record and off the fitted curves at the same torques, by key.

    Parameters
    ----------
    posterior : of the record
    requests : figures of merit; those that a record can show are read
    """
    likelihood, rated = posterior.likelihood, posterior.operation.rated_torque
    how = readings(likelihood.reduced.path, requests, rated)
    if not how:
        return {}
    reduced, noise = likelihood.reduced, likelihood.noise
    angle = _means(posterior)
    curves = likelihood.angle(posterior.points[posterior.thinned(_DRAWS)])
    # Blocks were freed of what the curve does inside them; here it belongs to both.
    curves = curves + (angle - reduced.angle)
    # An empirical curve is no noise: what it takes up is what the figures do not have.
    covariance = noise.covariance - noise.block_features @ noise.block_features.T
    covariance = covariance * float(np.median(posterior.noise_scale)) ** 2
    return {key: _read_off(reading, angle, curves, covariance) for key, reading in how.items()}


def _means(posterior: Posterior) -> FloatArray:
    """(blocks,) mean angle of each block's readings in rad."""
    reduced = posterior.likelihood.reduced
    block, used = reduced.block_of, reduced.block_of >= 0
    total = np.bincount(block[used], weights=posterior.loop.angle[used])
    return np.asarray(total / reduced.count)


def _read_off(
    reading: Reading, angle: FloatArray, curves: FloatArray, covariance: FloatArray
) -> ReadOff:
    record, sd = float(reading.of(angle)), reading.sd(angle, covariance)
    fit = by_level(reading.of(curves))
    gap = abs(record - fit[0.50])
    matters = gap > _MATTERS * max(abs(record), abs(fit[0.50]))
    outside = not fit[0.05] <= record <= fit[0.95]
    no_chance = gap > _MISSED * spread_of_gap(sd, fit)
    return ReadOff(record, sd, fit, bool(matters and outside and no_chance))


def spread_of_gap(record_sd: float, fit: Mapping[float, float]) -> float:
    """Standard deviation of a reading minus the fit's by chance, where the model is right.

    A fit that uses all of a record has a part of the reading's own noise in it: the variance of
    the difference is the difference of the variances (Hausman, Econometrica 46, 1978).
    """
    # By quantiles, for single draws of linearised effects may lie far away.
    fit_sd = (fit[0.95] - fit[0.05]) / DEVIATIONS_IN_90
    return float(np.sqrt(max(record_sd**2 - fit_sd**2, (_LEAST_SPREAD * record_sd) ** 2)))
