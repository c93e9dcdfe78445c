"""Best least-squares points of a loop, from several starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.inference.likelihood import COUNT, LOGIT_SD, LoopLikelihood
from hdprog.inference.ridge_coordinates import from_unconstrained, to_unconstrained
from hdprog.physics.parameters import NAMES, FloatArray

_SCREENED = 384
_SETTLED = 1e-3  # of the deviance: what is left to gain counts for nothing
_DAMPING, _LEAST_DAMPING, _MOST_DAMPING = 1e-2, 1e-3, 1e8
_LADDER = np.array([1 / 8, 1.0, 8.0, 64.0])  # dampings tried at once, in parts of the last best
_STEP = 1e-6
_T_T, _T_I, _MU = (NAMES.index(name) for name in ("T_T", "T_i", "mu"))
_PRELOAD_AT = (0.15, 0.4, 0.8, 1.3, 2.5)  # of the largest torque
_TEETH_MET_AT = (0.03, 0.3, 0.7, 1.0)
_SCOUTING, _HOPELESS = 8, 40.0  # iterations after which a start so far behind in deviance is left


@dataclass(frozen=True)
class StartingPoint:
    """A mode of the posterior of one loop.

    Attributes
    ----------
    point : (size,) as in `likelihood`
    covariance : (size, size) of the Gaussian with the mode's Gauss-Newton curvature
    deviance : −2 log posterior, up to a constant common to all starts
    variance : s², the noise scale squared at the mode
    """

    point: FloatArray
    covariance: FloatArray
    deviance: float
    variance: float


def starting_points(
    likelihood: LoopLikelihood,
    rng: np.random.Generator,
    starts: int = 5,
    known: Sequence[FloatArray] = (),
) -> list[StartingPoint]:
    """Modes of the posterior, best first.

    They are sought from the best of many draws of the prior, and from about the best mode found.

    Parameters
    ----------
    likelihood : of the loop
    rng : for the draws of the prior
    starts : least-squares runs; equal results are kept once
    known : points (size,) to start from as well; the first gives the effects of the draws

    Returns
    -------
    at least one StartingPoint
    """
    drawn = np.zeros((_SCREENED, likelihood.size))
    drawn[:, :COUNT] = likelihood.prior.sample(_SCREENED, rng)
    if known:
        drawn[:, COUNT + 1 :] = known[0][COUNT + 1 :]
    drawn = np.vstack([likelihood.prior_mean, drawn[likelihood.supported(drawn)]])
    ranked = np.argsort(-likelihood.log_likelihood(drawn))
    # The best few tend to be neighbours: the other starts come from further down the list.
    chosen = ranked[np.unique(np.geomspace(1, ranked.size / 4, starts).astype(int) - 1)]
    found = _different(descend_all(likelihood, [*known, *drawn[chosen]]))
    if not found:
        found.append(describe(likelihood, likelihood.prior_mean))
    if likelihood.ridge:
        best = min(found, key=lambda start: start.deviance)
        elsewhere = _elsewhere(likelihood, best.point)
        found = _different([*found, *descend_all(likelihood, elsewhere)] if elsewhere else found)
    return sorted(found, key=lambda start: start.deviance)


def modes_near(likelihood: LoopLikelihood, starts: Sequence[FloatArray]) -> list[StartingPoint]:
    """Modes near those (size,) of a likelihood that is much the same, best first."""
    found = _different(descend_all(likelihood, starts))
    return sorted(found, key=lambda start: start.deviance)


def _different(candidates: Sequence[StartingPoint]) -> list[StartingPoint]:
    """Modes without those that were found before."""
    found: list[StartingPoint] = []
    for candidate in candidates:
        if all(np.abs(candidate.deviance - other.deviance) > 0.1 for other in found):
            found.append(candidate)
    return found


def _elsewhere(likelihood: LoopLikelihood, point: FloatArray) -> list[FloatArray]:
    """Points (size,) where a mode (size,) would have its twins, inside the hard support.

    Loops part into modes by where the kinks lie: the torques at which the preload is lifted and at
    which all teeth have met. Friction at no load, the product of mu and T_i, stays as it is.
    """
    largest = likelihood.reduced.path.largest
    around = []
    for share in _PRELOAD_AT:
        moved = point.copy()
        moved[_T_I] = np.log(share * largest)
        moved[_MU] -= moved[_T_I] - point[_T_I]
        around.append(moved)
    with np.errstate(over="ignore"):  # beyond all numbers, where a record is in other units
        for share in _TEETH_MET_AT:
            moved = point.copy()
            moved[_T_T] = np.log(np.expm1(share * largest / likelihood.prior.softplus_scale))
            around.append(moved)
        inside = likelihood.supported(np.array(around)) & np.isfinite(around).all(axis=1)
    return [moved for moved, kept in zip(around, inside, strict=True) if kept]


def descend(
    likelihood: LoopLikelihood, start: FloatArray, iterations: int = 30
) -> StartingPoint | None:
    """The mode near one start (size,), see `descend_all`; None where it would be left out."""
    found = descend_all(likelihood, [start], iterations)
    return found[0] if found else None


def descend_all(
    likelihood: LoopLikelihood, starts: Sequence[FloatArray], iterations: int = 30
) -> list[StartingPoint]:
    """Maxima a posteriori near starts, by damped least squares (Levenberg, Marquardt).

    The starts go side by side. Each iteration tries several steps from each, straight ones and ones
    along the ridge that the posterior follows (see `ridge_coordinates`), and takes the best.
    Starts that fall far behind the best one are given up.

    Parameters
    ----------
    likelihood : of the loop
    starts : points (size,)
    iterations : bound on the steps

    Returns
    -------
    one a start, in their order, those left out that begin outside the hard support and stay there
    """
    points = np.array(starts)
    deviance = _deviance(likelihood, points)
    damping = np.full(len(points), _DAMPING)
    running = np.arange(len(points))
    for iteration in range(iterations):
        if iteration == _SCOUTING:
            running = running[deviance[running] < deviance.min() + _HOPELESS]
        if running.size == 0:
            break
        here = points[running]
        linear = _Linear.at(likelihood, here)
        dampings = damping[running, None] * _LADDER
        steps = linear.steps(dampings)
        with np.errstate(all="ignore"):
            tried = here[:, None, :] + steps
            if likelihood.ridge:
                bent = _along_ridge(likelihood, here, steps)
                tried = np.concatenate([tried, bent], axis=1)
            reached = _deviance(likelihood, tried.reshape(-1, likelihood.size))
        reached = reached.reshape(tried.shape[:2])
        best = np.argmin(reached, axis=1)
        each = np.arange(len(here))
        with np.errstate(invalid="ignore"):  # a start outside the support that stays there
            gained = deviance[running] - reached[each, best]
        better = gained > 0
        points[running[better]] = tried[each, best][better]
        deviance[running[better]] = reached[each, best][better]
        damping[running] = np.where(
            better,
            np.maximum(dampings[each, best % _LADDER.size], _LEAST_DAMPING),
            dampings[:, -1] * _LADDER[-1],
        )
        going = (linear.promised > _SETTLED) & ~(better & (gained < _SETTLED))
        running = running[going & (damping[running] < _MOST_DAMPING)]
    return [describe(likelihood, point) for point in points[np.isfinite(deviance)]]


@dataclass(frozen=True)
class _Linear:
    """Least squares linearised at points, on the axes of its curvature.

    Attributes
    ----------
    axes : (points, size, size) columns, scaled by the prior's standard deviations
    curvature, slope : (points, size) of −log posterior along them
    """

    axes: FloatArray
    curvature: FloatArray
    slope: FloatArray

    @staticmethod
    def at(likelihood: LoopLikelihood, points: FloatArray) -> _Linear:
        sd = likelihood.prior_sd
        residual, derivative = likelihood.jacobians(points)
        scale = np.sqrt(likelihood.scale_squared(np.sum(residual**2, axis=-1)))[:, None]
        residual = np.nan_to_num(residual / scale)
        scaled = np.nan_to_num(derivative / scale[:, :, None]) * sd
        turned = scaled.transpose(0, 2, 1)
        values, vectors = np.linalg.eigh(turned @ scaled)
        pull = (points - likelihood.prior_mean) / sd
        if likelihood.ridge:
            pull[:, COUNT] = LOGIT_SD * np.tanh(0.5 * points[:, COUNT])  # the logistic prior's own
        gradient = (turned @ residual[:, :, None])[:, :, 0] + pull
        slope = np.einsum("pij,pi->pj", vectors, gradient)
        return _Linear(sd[:, None] * vectors, np.maximum(values, 0.0) + 1.0, slope)

    @property
    def promised(self) -> FloatArray:
        """(points,) fall of the deviance by the whole step, were everything linear."""
        return np.asarray(np.sum(self.slope**2 / self.curvature, axis=1))

    def steps(self, dampings: FloatArray) -> FloatArray:
        """(points, dampings, size) steps under dampings (points, dampings)."""
        along = -self.slope[:, None, :] / (self.curvature[:, None, :] + dampings[:, :, None])
        return np.asarray(along @ self.axes.transpose(0, 2, 1))


def _along_ridge(likelihood: LoopLikelihood, points: FloatArray, steps: FloatArray) -> FloatArray:
    """Where steps (points, steps, size) lead that are straight in ridge coordinates; same shape."""
    alpha, scale = likelihood.alpha, likelihood.prior.softplus_scale
    shifts = np.vstack([np.zeros(COUNT), _STEP * np.eye(COUNT)])
    near = (points[:, None, :COUNT] + shifts).reshape(-1, COUNT)
    ridge = from_unconstrained(near, alpha, scale).reshape(len(points), COUNT + 1, COUNT)
    derivative = (ridge[:, 1:] - ridge[:, :1]) / _STEP
    moved = ridge[:, :1] + steps[:, :, :COUNT] @ derivative
    reached, _ = to_unconstrained(moved.reshape(-1, COUNT), alpha, scale)
    straight = points[:, None, COUNT:] + steps[:, :, COUNT:]
    return np.concatenate([reached.reshape(moved.shape), straight], axis=2)


def _deviance(likelihood: LoopLikelihood, points: FloatArray) -> FloatArray:
    """−2 log posterior (points,) at points (points, size); infinite outside the hard support."""
    density = likelihood.log_likelihood(points) + likelihood.log_prior(points)
    inside = likelihood.supported(points) & np.isfinite(density)
    return np.where(inside, -2 * density, np.inf)


def describe(likelihood: LoopLikelihood, point: FloatArray) -> StartingPoint:
    """A point (size,) with its Gauss-Newton curvature and deviance."""
    residual, derivative = likelihood.jacobian(point)
    variance = float(likelihood.scale_squared(np.sum(residual**2, keepdims=True))[0])
    curvature = np.nan_to_num(derivative.T @ derivative) / variance
    curvature += np.diag(1 / likelihood.prior_sd**2)
    log_prior = float(likelihood.log_prior(point[None, :])[0])
    deviance = likelihood.degrees * np.log(variance) - 2 * log_prior
    return StartingPoint(point, np.asarray(np.linalg.inv(curvature)), float(deviance), variance)
