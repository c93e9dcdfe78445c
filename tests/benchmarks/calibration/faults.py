"""Faults planted into the posterior, to see whether the ranks give them away.

Most are a wrong density. The right draws with weights then show what sampling it had given:

* `SD x 0.9`: the posterior to the power 1/0.81. A Gaussian one gets 0.9 of its standard deviations;
  a bent one narrows along its bend.
* `prior used twice`: times the prior of the eight parameters.
* `ridge Jacobian dropped`: over the Jacobian of the coordinates that are sampled in.
* `softplus Jacobian dropped`, `log Jacobian dropped`: times dT_T/dx, and times da/dx, as if the
  prior of the coordinate were one of T_T, and of a.

In `intervals x 0.9` only what is reported is wrong: every quantity but the log-likelihood is drawn
towards its own mean. `slip fixed` is a refit with the slip before the first reading half way
between its envelopes.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from hdprog.inference.fit_loop import sample_posterior
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import Prepared, settle_noise
from hdprog.inference.ridge_coordinates import from_unconstrained, to_unconstrained
from hdprog.inference.sampling_plan import SamplingPlan
from hdprog.inference.starting_points import starting_points
from hdprog.physics.parameters import NAMES, FloatArray
from tests.benchmarks.calibration.ranks import LOG_LIKELIHOOD, Located

NARROW, INTERVALS, TWICE = "SD x 0.9", "intervals x 0.9", "prior used twice"
RIDGE, SOFTPLUS, LOG = (f"{name} Jacobian dropped" for name in ("ridge", "softplus", "log"))
SLIP = "slip fixed"
WEIGHTED = (NARROW, TWICE, RIDGE, SOFTPLUS, LOG)
FAULTS = (NARROW, INTERVALS, TWICE, RIDGE, SOFTPLUS, LOG, SLIP)
FACTOR = 0.9


def shares_with(fault: str, found: Located, likelihood: LoopLikelihood) -> list[float]:
    """Share of a faulty posterior below the truth, in the order of `QUANTITIES`."""
    if fault == INTERVALS:
        return narrowed(found).shares()
    return found.shares(log_weights(fault, found.points, likelihood))


def narrowed(found: Located, factor: float = FACTOR) -> Located:
    """All draws but those of the log-likelihood moved towards their mean."""
    moved = {name: v.mean() + factor * (v - v.mean()) for name, v in found.draws.items()}
    moved[LOG_LIKELIHOOD] = found.draws[LOG_LIKELIHOOD]
    return replace(found, draws=moved)


def log_weights(fault: str, points: FloatArray, likelihood: LoopLikelihood) -> FloatArray:
    """Log weights (draws,) that turn draws of the posterior into those of a faulty one."""
    if fault == TWICE:
        return likelihood.prior.log_density(points[:, :COUNT])
    if fault == SOFTPLUS:
        return np.asarray(-np.logaddexp(0.0, -points[:, NAMES.index("T_T")]))
    if fault == LOG:
        return np.asarray(points[:, NAMES.index("a")])
    log_jacobian = _log_jacobian(points, likelihood)
    if fault == RIDGE:
        return -log_jacobian
    if fault == NARROW:
        density = log_jacobian + likelihood.log_prior(points) + likelihood.log_likelihood(points)
        return np.asarray((1 / FACTOR**2 - 1) * density)
    raise ValueError(f"{fault} is no fault with weights")


def _log_jacobian(points: FloatArray, likelihood: LoopLikelihood) -> FloatArray:
    frame = likelihood.ridge_frame
    return to_unconstrained(from_unconstrained(points[:, :COUNT], *frame), *frame)[1]


@dataclass(frozen=True)
class FixedSlip(LoopLikelihood):
    """A likelihood that takes the slip before the first reading for known: half way."""

    def angle(self, points: FloatArray) -> FloatArray:
        halved = points.copy()
        halved[:, COUNT] = 0.0
        return super().angle(halved)


def with_fixed_slip(prepared: Prepared, rng: np.random.Generator, plan: SamplingPlan) -> Posterior:
    """Fit a prepared record with the slip before its first reading taken for known."""
    right = prepared.likelihood
    wrong = FixedSlip(**{field.name: getattr(right, field.name) for field in fields(right)})
    known = [start.point for start in prepared.starts]
    likelihood, starts = settle_noise(wrong, starting_points(wrong, rng, known=known), rng)
    return sample_posterior(prepared, likelihood, starts, rng, plan=plan)
