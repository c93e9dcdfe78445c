"""A mixture that is fitted to a warm-up and then frozen, and local proposals by it.

In ridge coordinates a loop's posterior is bent so little that a handful of Gaussians follows it,
and most proposals are accepted: draws are then nearly independent. Since the mixture does not
change any more, the Metropolis-Hastings rule with its density leaves the posterior unchanged
(Tierney 1994, independence chains).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import gammaln

from hdprog.physics.parameters import FloatArray

_ITERATIONS = 40
_SETTLED = 1e-3  # of the mean log density: what another iteration adds counts for nothing
# Of a wide component: walkers stay where the target has more than the proposal, so its tails must
# reach further. Rarely and far (0.05 and 2) held walkers up twice as long.
_WIDE_WEIGHT = 0.15
_WIDE_SCALE = 1.5
_RIDGE = 1e-6
# Of local steps, in standard deviations of the component, even in their logarithm: half more than
# 2.4/3, the best of a Gaussian in nine dimensions, at most, and shorter where the posterior bends.
_SHORTEST, _LONGEST = 0.2, 1.2


@dataclass(frozen=True)
class Mixture:
    """A mixture of Gaussians, or of Student's t distributions.

    Attributes
    ----------
    log_weights : (components,)
    means : (components, dimensions)
    factors : (components, dimensions, dimensions) lower Cholesky factors of the covariances, or of
        the squared scales
    degrees : of freedom of Student's t; None for Gaussians
    """

    log_weights: FloatArray
    means: FloatArray
    factors: FloatArray
    degrees: float | None = None

    def log_components(self, points: FloatArray) -> FloatArray:
        """Log of weight times density of every component, (points, components)."""
        dimensions = self.means.shape[1]
        inverse, log_scale = self._inverse
        whitened = np.matmul(inverse, points.T)  # (components, dimensions, points)
        whitened -= np.matmul(inverse, self.means[:, :, None])
        squares = np.einsum("kij,kij->kj", whitened, whitened)
        constant = self.log_weights + log_scale
        if self.degrees is None:
            constant -= 0.5 * dimensions * np.log(2 * np.pi)
            return np.asarray((constant[:, None] - 0.5 * squares).T)
        both = 0.5 * (self.degrees + dimensions)
        constant += gammaln(both) - gammaln(0.5 * self.degrees)
        constant -= 0.5 * dimensions * np.log(np.pi * self.degrees)
        return np.asarray((constant[:, None] - both * np.log1p(squares / self.degrees)).T)

    @property
    def log_polynomials(self) -> FloatArray:
        """Log of weight times density of each Gaussian by `monomials`, (components, monomials)."""
        inverse, log_scale = self._inverse
        rows, columns = np.triu_indices(self.means.shape[1])
        precision = inverse.transpose(0, 2, 1) @ inverse
        linear = np.einsum("kij,kj->ki", precision, self.means)
        constant = self.log_weights + log_scale - 0.5 * np.einsum("ki,ki->k", linear, self.means)
        constant -= 0.5 * self.means.shape[1] * np.log(2 * np.pi)
        squares = np.where(rows == columns, -0.5, -1.0) * precision[:, rows, columns]
        return np.hstack([constant[:, None], linear, squares])

    @cached_property
    def _inverse(self) -> tuple[FloatArray, FloatArray]:
        """Inverse factors, and the log determinants of these, (components,)."""
        diagonal = np.diagonal(self.factors, axis1=1, axis2=2)
        inverse = np.asarray(np.linalg.inv(self.factors), dtype=np.float64)
        return inverse, np.asarray(-np.log(diagonal).sum(axis=1))

    def log_density(self, points: FloatArray) -> FloatArray:
        """Log density (points,) at points (points, dimensions)."""
        return _log_sum(self.log_components(points))[:, 0]

    def draw(self, size: int, random: np.random.RandomState) -> FloatArray:
        """Draws (size, dimensions)."""
        chosen = random.choice(self.log_weights.size, size=size, p=np.exp(self.log_weights))
        noise = random.standard_normal((size, self.means.shape[1]))
        if self.degrees is not None:
            noise /= np.sqrt(random.chisquare(self.degrees, size) / self.degrees)[:, None]
        return np.asarray(self.means[chosen] + np.einsum("nij,nj->ni", self.factors[chosen], noise))


def _log_sum(log_terms: FloatArray) -> FloatArray:
    """Log of sums of exponentials over the last axis, which stays, of finite (points, terms)."""
    return _shares(log_terms)[1]


def _shares(log_terms: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Share of each term in the sum of exponentials over the last axis, and the log of that sum.

    (points, terms) and (points, 1), of finite (points, terms).
    """
    largest = log_terms.max(axis=1, keepdims=True)
    share = np.exp(log_terms - largest)
    total = share.sum(axis=1, keepdims=True)
    share /= total
    return share, np.asarray(largest + np.log(total))


def monomials(points: FloatArray) -> FloatArray:
    """1, the coordinates and the products of their pairs, of points (points, dimensions).

    (monomials, points), each pair once, in the order of `numpy.triu_indices`.
    """
    rows, columns = np.triu_indices(points.shape[1])
    return np.vstack([np.ones(len(points)), points.T, points.T[rows] * points.T[columns]])


def fit_mixture(samples: FloatArray, components: int, rng: np.random.Generator) -> Mixture:
    """Fit a Gaussian mixture by expectation-maximisation, and add one wide component.

    Parameters
    ----------
    samples : (samples, dimensions)
    components : number of Gaussians, before the wide one
    rng : picks the starting centres
    """
    count, dimensions = samples.shape
    centre, covariance = samples.mean(axis=0), np.cov(samples.T)
    covariance += _RIDGE * np.diag(np.diag(covariance)) + 1e-300 * np.eye(dimensions)
    overall = np.linalg.cholesky(covariance)
    white = np.linalg.solve(overall, (samples - centre).T).T
    seeds = white[rng.choice(count, size=components, replace=False)]
    share, _ = _shares((seeds @ white.T - 0.5 * (seeds**2).sum(axis=1)[:, None]).T)
    # Densities are linear in these and moments are sums of them: both steps are one product each.
    rows, columns = np.triu_indices(dimensions)
    powers = monomials(white)
    reached = -np.inf
    for _ in range(_ITERATIONS):
        moments = share.T @ powers.T
        mass = moments[:, 0] + 1e-10
        means = moments[:, 1 : dimensions + 1] / mass[:, None]
        spread = np.empty((components, dimensions, dimensions))
        spread[:, rows, columns] = moments[:, dimensions + 1 :]
        spread[:, columns, rows] = moments[:, dimensions + 1 :]
        spread -= mass[:, None, None] * means[:, :, None] * means[:, None, :]
        # A component with few samples leans on the others.
        shared = dimensions * spread.sum(axis=0) / count
        spread = (spread + shared) / (mass + dimensions)[:, None, None]
        factors = np.linalg.cholesky(spread + _RIDGE * np.eye(dimensions))
        mixture = Mixture(np.log(mass / mass.sum()), means, factors)
        share, log_density = _shares((mixture.log_polynomials @ powers).T)
        before, reached = reached, float(log_density.mean())
        if reached - before < _SETTLED:
            break
    return Mixture(
        log_weights=np.append(mixture.log_weights + np.log1p(-_WIDE_WEIGHT), np.log(_WIDE_WEIGHT)),
        means=np.vstack([centre + mixture.means @ overall.T, centre]),
        factors=np.concatenate(
            [np.einsum("ij,kjl->kil", overall, mixture.factors), _WIDE_SCALE * overall[None]]
        ),
    )


@dataclass(frozen=True)
class LocalProposal:
    """Proposal function for `emcee.moves.MHMove`: steps as long and wide as the mixture is there.

    Where the target has much more than the mixture, independent proposals are hardly ever accepted;
    short steps are. A walker picks a component by how likely it comes from it, and steps by that
    one's covariance. The step itself is as likely as its way back; what differs is how likely both
    ends pick the component.

    Attributes
    ----------
    mixture : frozen
    """

    mixture: Mixture

    def __call__(
        self, position: FloatArray, random: np.random.RandomState
    ) -> tuple[FloatArray, FloatArray]:
        """New positions (walkers, dimensions) and log q(old)/q(new), (walkers,)."""
        walkers = np.arange(len(position))
        here = self._log_shares(position)
        below = np.exp(here).cumsum(axis=1) < random.random_sample((len(position), 1))
        chosen = np.minimum(below.sum(axis=1), here.shape[1] - 1)
        noise = random.standard_normal(position.shape)
        length = np.exp(random.uniform(np.log(_SHORTEST), np.log(_LONGEST), len(position)))
        proposed = position + length[:, None] * np.einsum(
            "nij,nj->ni", self.mixture.factors[chosen], noise
        )
        there = self._log_shares(proposed)
        return proposed, there[walkers, chosen] - here[walkers, chosen]

    def _log_shares(self, points: FloatArray) -> FloatArray:
        log_components = self.mixture.log_components(points)
        return np.asarray(log_components - _log_sum(log_components))
