"""Is the density that peers sample the one of hdprog?"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from hdprog.inference.likelihood import COUNT
from hdprog.inference.sampler import initial_states, sample_ensembles
from hdprog.physics.parameters import FloatArray
from tests.benchmarks.samplers.log_density import batched
from tests.benchmarks.samplers.posteriors import Target, check_rng, with_logit

TOLERANCE = 1e-9
_STEPS, _POSTERIOR, _PRIOR, _ROWS = 250, 240, 240, 48
_FURTHER = 3.0


@dataclass(frozen=True)
class Equality:
    """Largest deviation of a posterior's densities over all points.

    Attributes
    ----------
    index : of the posterior
    posterior_draws, prior_draws, outside : points compared; how many lie outside the support
    deviation : largest |difference| over the size of the value
    support : whether the two agree at every point on whether it lies inside
    """

    index: int
    posterior_draws: int
    prior_draws: int
    outside: int
    deviation: float
    support: bool

    @property
    def holds(self) -> bool:
        """Whether the densities are the same."""
        return self.support and self.deviation < TOLERANCE

    def as_dict(self) -> dict[str, float | bool]:
        """Ready for JSON."""
        return asdict(self)


def compare(target: Target) -> Equality:
    """Compare the JAX density, in both coordinates, and its likelihood with hdprog's."""
    rng = check_rng(target.index)
    posterior, likelihood, density = target.posterior, target.likelihood, target.density
    state = initial_states(posterior, target.starts, rng)[0]
    chains = sample_ensembles(posterior, state, _STEPS).chains
    late = chains[:, _STEPS // 2 :].reshape(-1, likelihood.size)
    drawn = np.hstack([likelihood.prior.sample(_PRIOR, rng), rng.logistic(size=(_PRIOR, 1))])
    # Every other one so far out that some lie outside the hard support.
    drawn[::2, :COUNT] += _FURTHER * (drawn[::2, :COUNT] - likelihood.prior.mean)
    position = np.vstack(
        [
            late[rng.choice(len(late), size=_POSTERIOR, replace=False)],
            np.array([posterior.position(point) for point in drawn]),
        ]
    )
    ridge, fraction = with_logit(position), position[:, COUNT]
    points, log_jacobian = posterior.points(position), _log_jacobian(target, ridge)
    wanted = posterior(position) + np.log(fraction * (1 - fraction))
    plain = np.where(np.isfinite(wanted), wanted - log_jacobian, -np.inf)
    curve = np.where(likelihood.supported(points), likelihood.log_likelihood(points), -np.inf)
    pairs = [
        (batched(density.ridge, _ROWS)(ridge), wanted),
        (batched(density.unconstrained, _ROWS)(points), plain),
        (batched(density.log_likelihood, _ROWS)(points), curve),
    ]
    return Equality(
        index=target.index,
        posterior_draws=_POSTERIOR,
        prior_draws=_PRIOR,
        outside=int((~np.isfinite(wanted)).sum()),
        deviation=max(_deviation(found, right) for found, right in pairs),
        support=all(
            bool((np.isfinite(found) == np.isfinite(right)).all()) for found, right in pairs
        ),
    )


def _log_jacobian(target: Target, ridge: FloatArray) -> FloatArray:
    from hdprog.inference.ridge_coordinates import to_unconstrained

    return to_unconstrained(ridge[:, :COUNT], *target.likelihood.ridge_frame)[1]


def _deviation(found: FloatArray, right: FloatArray) -> float:
    inside = np.isfinite(found) & np.isfinite(right)
    size = np.maximum(np.abs(right[inside]), 1.0)
    return float(np.max(np.abs(found[inside] - right[inside]) / size, initial=0.0))
