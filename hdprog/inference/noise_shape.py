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
from numpy.typing import NDArray
from scipy.linalg import solve_banded
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


@dataclass(frozen=True)
class Shapes:
    """Ornstein-Uhlenbeck terms beside white noise, each with the weight of its likelihood.

    Attributes
    ----------
    variance, length : of the likeliest term: in rad², and over which it decays in the unit of
        the positions
    variances, lengths : of all terms, where the white part has scale one
    squares, degrees : what is left in units of the white part, and its degrees of freedom
    """

    variance: float
    length: float
    variances: FloatArray
    lengths: FloatArray
    squares: float
    degrees: float

    @staticmethod
    def of(
        best: FloatArray,
        axes: tuple[FloatArray, FloatArray],
        seen: list[list[_Restricted]],
        mean_variance: float,
        squares: float,
        degrees: float,
    ) -> Shapes:
        """From a grid of logs of ratio and length, what was seen of each, and the likeliest.

        What was seen is of a residual whose sum of squares in units of the white part is one, and
        not `squares`.
        """
        ratio, length = axes
        deviance = np.array([[one.deviance for one in row] for row in seen])
        variance = np.array([[one.variance for one in row] for row in seen])
        likelihood = np.exp(-0.5 * (deviance - deviance.min()))
        rows, columns = np.nonzero(likelihood > _LEAST_WEIGHT)
        weight = likelihood[rows, columns] * variance[rows, columns]
        scale = float(weight.sum() / likelihood[rows, columns].sum())
        weight /= weight.sum()
        # Shapes of one length differ by a factor only.
        factors = np.bincount(rows, weights=weight * np.exp(ratio[columns]), minlength=length.size)
        some = np.flatnonzero(factors)
        return Shapes(
            mean_variance * float(np.exp(best[0])),
            float(np.exp(best[1])),
            np.asarray(mean_variance * factors[some], dtype=np.float64),
            np.exp(length[some]),
            scale * squares * degrees,
            degrees,
        )

    def covariance(self, position: FloatArray) -> FloatArray:
        """(blocks, blocks) of the terms, averaged, at positions (blocks,)."""
        distance = np.abs(position[:, None] - position[None, :])
        total: FloatArray = np.zeros_like(distance)
        for length, variance in zip(self.lengths, self.variances, strict=True):
            total += variance * np.exp(-distance / length)
        return total

    def covariance_of_means(self, position: FloatArray, block_of: NDArray[np.intp]) -> FloatArray:
        """(blocks, blocks) of the terms' means over readings.

        Parameters
        ----------
        position : (readings,) increasing
        block_of : (readings,) block of each, from 0 on and one after the other
        """
        starts = np.flatnonzero(np.diff(block_of, prepend=-1))
        count = np.bincount(block_of).astype(np.float64)
        first, last = position[starts], position[np.append(starts[1:], position.size) - 1]
        apart = np.maximum(first[None, :] - last[:, None], 0.0)
        later = np.triu(np.ones(apart.shape, dtype=bool), 1)
        total: FloatArray = np.zeros_like(apart)
        for length, variance in zip(self.lengths, self.variances, strict=True):
            kept = np.exp(-np.diff(position, prepend=position[0]) / length)
            kept[starts] = 0.0
            # What of all readings before it in its block each still remembers.
            remembered = solve_banded(
                (1, 0), np.stack([np.ones_like(kept), -np.roll(kept, -1)]), kept
            )
            inside = (count + 2 * np.bincount(block_of, weights=remembered)) / count**2
            ahead = np.bincount(block_of, weights=np.exp((position - last[block_of]) / length))
            behind = np.bincount(block_of, weights=np.exp((first[block_of] - position) / length))
            between = np.outer(ahead / count, behind / count) * np.exp(-apart / length)
            between = np.where(later, between, 0.0)
            total += variance * (between + between.T + np.diag(inside))
        return total


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
    least = float(chdtri(2, FALSE_ALARM_RATE))
    found = fit_shapes(residual, sensitivities, sd, position, least)
    if found is None:
        return NoiseModel.white(sd)
    return NoiseModel.white(sd).with_decaying(
        found.covariance(position), found.variance, found.length, position
    )


def fit_shapes(
    residual: FloatArray,
    sensitivities: FloatArray,
    sd: FloatArray,
    position: FloatArray,
    least: float = -np.inf,
) -> Shapes | None:
    """The shapes that a residual leaves possible; None where no more than rounding is left of it.

    Parameters
    ----------
    residual, sensitivities, sd, position : as in `fit_noise`
    least : deviance by which the likeliest must be better than white noise; None where it is not
    """
    # Directions that the data do not see make no projection.
    left, strength, _ = np.linalg.svd(sensitivities / sd[:, None], full_matrices=False)
    seen_by_data = left[:, strength > 1e-8 * strength[0]]
    unexplained = _unexplained(residual / sd, seen_by_data)
    if unexplained is None:
        return None
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
    if white.deviance - found.fun < least:
        return None
    axes = _axes_about(found.x, bounds)
    degrees = float(sd.size - seen_by_data.shape[1])
    grid = _seen_about(found.x, axes, seen)
    squares = float(unexplained @ (residual / sd)) ** 2
    return Shapes.of(found.x, axes, grid, mean_variance, squares, degrees)


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
