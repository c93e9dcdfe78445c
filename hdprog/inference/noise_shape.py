"""Find the shape of a loop's noise from what its best fit leaves: white, or with a memory.

White noise is tested against white noise plus an Ornstein-Uhlenbeck term by restricted likelihood,
the fitted sensitivities projected out. Where it fails, one term's length and share are known so
badly from one record that the covariance at their best values makes intervals too narrow: it is
averaged over all of them, each with the weight of its restricted likelihood.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg.lapack import dpttrf, dpttrs
from scipy.optimize import minimize
from scipy.special import chdtri

from hdprog.inference.noise import NoiseModel
from hdprog.physics.parameters import FloatArray

FALSE_ALARM_RATE = 0.01
"""Share of loops with white noise that get the correlated model all the same (tested)."""

_RATIO_STEP, _LENGTH_STEP = 0.5, 0.5  # of the grid of logs that shapes are averaged over
_RATIO_REACH = 3.0  # to either side of the best
_ROUNDING = 1e-12  # of a residual: no more than this left of it is no noise
_LEAST_WEIGHT = 1e-3  # of the likeliest shape's: those below it are left out


@dataclass(frozen=True)
class DecayingNoise:
    """White noise plus an Ornstein-Uhlenbeck term, solved in a time linear in the blocks.

    The inverse of the term's covariance K is tridiagonal, so with M = K⁻¹ + D⁻¹
    (D + K)⁻¹ = D⁻¹ − D⁻¹M⁻¹D⁻¹ and |D + K| = |M||K||D|.
    """

    variance: FloatArray
    pivots: FloatArray
    ratios: FloatArray
    log_det: float

    @staticmethod
    def of(variance: FloatArray, correlated: float, steps: FloatArray) -> DecayingNoise:
        """From white variances (blocks,), the term's variance and steps (blocks − 1,) in lengths.

        Raises LinAlgError where the numbers are too far apart to be solved.
        """
        kept = np.exp(-steps)
        renewed = -np.expm1(-2 * steps) * correlated
        diagonal = 1 / variance
        diagonal[0] += 1 / correlated
        diagonal[1:] += 1 / renewed
        diagonal[:-1] += kept**2 / renewed
        pivots, ratios, failed = dpttrf(diagonal, -kept / renewed)
        if failed or not np.isfinite(pivots).all():
            raise np.linalg.LinAlgError("covariance is not positive definite")
        log_det = np.log(pivots).sum() + np.log(renewed).sum() + np.log(correlated)
        return DecayingNoise(variance, pivots, ratios, float(log_det + np.log(variance).sum()))

    def solve(self, columns: FloatArray) -> FloatArray:
        """(D + K)⁻¹ times columns (blocks, k)."""
        scaled = columns / self.variance[:, None]
        inner, _ = dpttrs(self.pivots, self.ratios, scaled)
        return np.asarray(scaled - inner / self.variance[:, None])


@dataclass(frozen=True)
class _Restricted:
    """What a residual says of one shape of the noise, the sensitivities projected out.

    Attributes
    ----------
    deviance : −2 log restricted likelihood, the scale profiled out, up to a constant
    variance : the scale's best square
    """

    deviance: float
    variance: float

    @staticmethod
    def of(solved: FloatArray, log_det: float, columns: FloatArray) -> _Restricted:
        """`solved` is the inverse covariance times columns: sensitivities, and last the residual.

        Raises LinAlgError where these cannot be told apart.
        """
        # The last diagonal element is what of the residual the sensitivities do not explain.
        *explained, left = np.diag(np.linalg.cholesky(columns.T @ solved))
        degrees = len(columns) - len(explained)
        deviance = 2 * degrees * np.log(left) + log_det + 2 * np.log(explained).sum()
        return _Restricted(float(deviance), float(left**2 / degrees))


_IMPOSSIBLE = _Restricted(np.inf, 0.0)


def fit_noise(
    residual: FloatArray, sensitivities: FloatArray, sd: FloatArray, position: FloatArray
) -> NoiseModel:
    """Test whether a residual is white and, where it is not, fit the correlated model.

    Parameters
    ----------
    residual : (blocks,) angle minus best fit in rad
    sensitivities : (blocks, k) derivatives of the fit that absorbed part of the residual
    sd : (blocks,) relative standard deviation of the white part in rad
    position : (blocks,) increasing time or index that correlation decays over

    Returns
    -------
    NoiseModel, white where the likelihood-ratio test keeps white at `FALSE_ALARM_RATE`, and where
    the sensitivities explain the residual up to rounding
    """
    # Directions that the data do not see make no projection.
    left, strength, _ = np.linalg.svd(sensitivities / sd[:, None], full_matrices=False)
    seen_by_data = left[:, strength > 1e-8 * strength[0]]
    unexplained = _unexplained(residual / sd, seen_by_data)
    if unexplained is None:
        return NoiseModel.white(sd)
    steps = np.maximum(np.diff(position), 1e-9 * (position[-1] - position[0]))
    typical, extent = float(np.median(steps)), float(position[-1] - position[0])
    mean_variance = float(np.mean(sd**2))
    columns = np.column_stack([seen_by_data, unexplained]) * sd[:, None]

    def seen(theta: FloatArray) -> _Restricted:
        try:
            noise = DecayingNoise.of(
                sd**2, mean_variance * np.exp(theta[0]), steps / np.exp(theta[1])
            )
            return _Restricted.of(noise.solve(columns), noise.log_det, columns)
        except np.linalg.LinAlgError:
            return _IMPOSSIBLE

    def deviance(theta: FloatArray) -> float:
        return seen(theta).deviance

    white = _Restricted.of(columns / sd[:, None] ** 2, float(2 * np.log(sd).sum()), columns)
    bounds = [(np.log(1e-3), np.log(1e4)), (np.log(typical), np.log(extent))]
    starts = [(0.0, np.log(3 * typical)), (1.0, np.log(0.1 * extent))]
    best = min(starts, key=lambda start: deviance(np.array(start)))
    found = minimize(
        deviance, best, method="L-BFGS-B", bounds=bounds, options={"maxiter": 15, "eps": 1e-3}
    )
    if white.deviance - found.fun < chdtri(2, FALSE_ALARM_RATE):
        return NoiseModel.white(sd)
    axes = _axes_about(found.x, bounds)
    correlated = mean_variance * _averaged(axes, _seen_about(found.x, axes, seen), position)
    log_ratio, log_length = (float(value) for value in found.x)
    return NoiseModel.white(sd).with_decaying(
        correlated, log_ratio, float(np.exp(log_length)), position
    )


def _unexplained(residual: FloatArray, basis: FloatArray) -> FloatArray | None:
    """Direction (blocks,) of what an orthonormal basis leaves of a residual; None for rounding."""
    left = residual - basis @ (basis.T @ residual)
    length = float(np.linalg.norm(left))
    if length <= _ROUNDING * float(np.linalg.norm(residual)):
        return None
    # A small rest still holds rounding along the basis; the second pass takes it out.
    left -= basis @ (basis.T @ left)
    return np.asarray(left / np.linalg.norm(left))


def _axes_about(
    best: FloatArray, bounds: list[tuple[float, float]]
) -> tuple[FloatArray, FloatArray]:
    """Logs of ratio and of length of a grid inside the bounds, the best among them."""
    ratio = best[0] + np.arange(-_RATIO_REACH, _RATIO_REACH + _RATIO_STEP / 2, _RATIO_STEP)
    ratio = ratio[(ratio >= bounds[0][0]) & (ratio <= bounds[0][1])]
    reach = bounds[1][1] - bounds[1][0]
    length = best[1] + _LENGTH_STEP * np.arange(-reach // _LENGTH_STEP, reach // _LENGTH_STEP + 2)
    length = length[(length >= bounds[1][0]) & (length <= bounds[1][1])]
    return ratio, length


def _seen_about(
    best: FloatArray,
    axes: tuple[FloatArray, FloatArray],
    seen: Callable[[FloatArray], _Restricted],
) -> list[list[_Restricted]]:
    """Every length's shapes by ratio, from the best one outwards as far as any has weight."""
    ratio, length = axes
    found = [[_IMPOSSIBLE] * ratio.size for _ in length]
    first = (int(np.argmin(np.abs(length - best[1]))), int(np.argmin(np.abs(ratio - best[0]))))
    least, waiting, met = np.inf, [first], {first}
    while waiting:
        row, column = waiting.pop()
        one = seen(np.array([ratio[column], length[row]]))
        found[row][column] = one
        least = min(least, one.deviance)
        if np.exp(-0.5 * (one.deviance - least)) <= _LEAST_WEIGHT:
            continue
        for near in product((row - 1, row, row + 1), (column - 1, column, column + 1)):
            inside = 0 <= near[0] < length.size and 0 <= near[1] < ratio.size
            if inside and near not in met:
                met.add(near)
                waiting.append(near)
    return found


def _averaged(
    axes: tuple[FloatArray, FloatArray], seen: list[list[_Restricted]], position: FloatArray
) -> FloatArray:
    """(blocks, blocks) correlated covariance over that of the white part, averaged over shapes."""
    ratio, length = axes
    deviance = np.array([[one.deviance for one in row] for row in seen])
    variance = np.array([[one.variance for one in row] for row in seen])
    likelihood = np.exp(-0.5 * (deviance - deviance.min()))
    rows, columns = np.nonzero(likelihood > _LEAST_WEIGHT)
    weight = likelihood[rows, columns] * variance[rows, columns]
    weight /= weight.sum()
    distance = np.abs(position[:, None] - position[None, :])
    total = np.zeros_like(distance)
    # Shapes of one length differ by a factor only.
    factors = np.bincount(rows, weights=weight * np.exp(ratio[columns]), minlength=length.size)
    for row in np.flatnonzero(factors):
        total += factors[row] * np.exp(-distance / np.exp(length[row]))
    return total
