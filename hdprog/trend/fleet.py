"""What other drives of a fleet tell a drive of its wear, before its own tests: partial pooling.

Every hyperparameter and loading is a standard normal deviate under the shipped prior, which is
that of any drive of any fleet. Part of that spread is between fleets, the rest between the drives
of one; for each deviate k of drive i

    z_ik = M_k + ε_ik,   M_k ~ N(0, ρ_k),   ε_ik ~ N(0, 1 − ρ_k)

so that without other drives a drive's prior is the shipped one, and with many it is theirs. The
spread within a fleet, √(1 − ρ_k), is half-Cauchy (Gelman, Bayesian Analysis 1, 2006), up to one:
drives of one fleet are alike until they show that they are not. Of another drive only what its
tests say beyond its prior is used, exp(−½ zᵀΛz + ηᵀz), so no prior counts twice; pace of wear and
loadings are kept together, for their product is known best. The posterior of M, ρ and the drives'
z is drawn by Gibbs' sampler (the normal hierarchical model: Gelman et al., Bayesian Data Analysis,
3rd ed. 2013, section 11.6); what it predicts for the next drive is passed on as a Gaussian of its
mean and covariance. Drives whose pace is steady are pooled beside the others (see `steady_pace`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hdprog.physics.parameters import NAMES, FloatArray

WITHIN = np.geomspace(0.01, 0.99, 70)
"""Standard deviations of a deviate within a fleet, √(1 − ρ), that may be."""
_WARM_UP, _SWEEPS = 200, 1500
_CHANCE = 1e-3  # of a shift of the mean that is none
_REACH = 2.0  # spreads of the prior within which draws of it can tell where a likelihood lies
_SEED = 0  # pooling is a calculation: the same drives always give the same prior


@dataclass(frozen=True)
class Said:
    """What a drive's tests say of its deviates z (k,) beyond its prior: −½ zᵀΛz + ηᵀz.

    Attributes
    ----------
    precision, information : Λ (k, k), η (k,); zero where they say nothing
    """

    precision: FloatArray
    information: FloatArray

    @staticmethod
    def of(draws: FloatArray, mean: FloatArray, covariance: FloatArray, worth: float) -> Said:
        """Divide a Gaussian prior out of draws from the posterior.

        A direction counts where the draws are narrower than draws of the prior itself could be by
        chance (the lower edge of Marchenko & Pastur's law, 1967). What is left of the mean's shift
        counts as one more where it is longer than chance makes it, for many drives may agree on
        what none of them knows well. Draws that hardly narrow say nothing of places beyond them:
        such a likelihood's centre is put within reach of the draws, and its precision so that the
        drive's own mean comes out.

        Parameters
        ----------
        draws : (draws, k)
        mean, covariance : (k,), (k, k) of the prior that they were drawn under
        worth : independent draws that they are worth
        """
        from scipy.special import chdtri

        size = mean.size
        nothing = Said(np.zeros((size, size)), np.zeros(size))
        if worth <= size:
            return nothing
        unit = np.linalg.inv(np.linalg.cholesky(covariance))
        standard = (draws - mean) @ unit.T
        variance, axes = np.linalg.eigh(np.cov(standard.T))
        seen = variance < (1.0 - np.sqrt(size / worth)) ** 2
        shift = standard.mean(axis=0)
        left = axes[:, ~seen] @ (axes[:, ~seen].T @ shift)
        variance, axes = np.maximum(variance[seen], 1e-12), axes[:, seen]
        precision = (axes * (1.0 / variance - 1.0)) @ axes.T
        pull = axes @ (axes.T @ shift / variance)
        length, unseen = float(np.linalg.norm(left)), size - axes.shape[1]
        if unseen and length**2 * worth > chdtri(unseen, _CHANCE):
            along, short = left / length, min(length, 0.9 * _REACH)
            spread = float(np.var(standard @ along))
            known = max(1.0 / spread - 1.0, short / (_REACH - short))
            precision = precision + known * np.outer(along, along)
            pull = pull + (1.0 + known) * short * along
        precision = unit.T @ precision @ unit
        return Said(precision, unit.T @ pull + precision @ mean)

    def times(self, share: float) -> Said:
        """The same said by a share of a drive."""
        return Said(share * self.precision, share * self.information)

    def posterior(self, mean: FloatArray, covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Mean (k,) and covariance (k, k) under a Gaussian prior."""
        own = np.linalg.inv(covariance)
        found = np.asarray(np.linalg.inv(own + self.precision))
        return found @ (self.information + own @ mean), found


@dataclass(frozen=True)
class FleetPrior:
    """The prior of a drive's deviates that other drives of its fleet make.

    Attributes
    ----------
    drives : ids of the other drives
    mean, covariance : (k,), (k, k) of the deviates: hyperparameters, then loadings
    steady : the same of a drive whose pace is steady, by the drives that tell of it; None where
        none does
    chance : that the drive's pace is
    """

    drives: tuple[str, ...]
    mean: FloatArray
    covariance: FloatArray
    steady: FleetPrior | None = None
    chance: float = 0.0

    @staticmethod
    def of(drives: Sequence[str], said: Sequence[Said], within: FloatArray) -> FleetPrior:
        """Pool what each of the drives said; the shipped prior where there is none.

        Parameters
        ----------
        drives : their ids
        said : by each
        within : (k,) scales of the half-Cauchy prior of the spread within a fleet
        """
        size = said[0].information.size
        rng = np.random.default_rng(_SEED)
        precision = np.stack([one.precision for one in said])
        information = np.stack([one.information for one in said])
        centre, share = np.zeros(size), np.full(size, 0.5)
        log_prior = log_prior_of_spread(within)
        means, variances = [], []
        for sweep in range(_WARM_UP + _SWEEPS):
            own = _draw_drives(precision, information, centre, 1.0 - share, rng)
            weight = 1.0 / share + len(said) / (1.0 - share)
            mean = own.sum(axis=0) / (1.0 - share) / weight
            centre = mean + rng.standard_normal(size) / np.sqrt(weight)
            own, centre = _move_fleet(precision, information, own - centre, share, rng)
            share = 1.0 - _draw_within(own, centre, log_prior, rng) ** 2
            if sweep >= _WARM_UP:
                means.append(centre)
                variances.append(1.0 - share)
        drawn = np.array(means)
        covariance = np.cov(drawn.T) + np.diag(np.mean(variances, axis=0))
        return FleetPrior(tuple(drives), drawn.mean(axis=0), covariance)

    @cached_property
    def of_hyperparameters(self) -> tuple[FloatArray, FloatArray]:
        """Mean (k − 8,) of the deviates before the loadings, and root of their covariance."""
        first = self.mean.size - len(NAMES)
        root = np.linalg.cholesky(self.covariance[:first, :first])
        return self.mean[:first], np.asarray(root)

    def of_loadings(self, hyperparameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Mean (draws, 8) and sd (8,) of the loadings' deviates, given those before them.

        Parameters
        ----------
        hyperparameters : (draws, k − 8) deviates; one that is not finite tells nothing
        """
        first = self.mean.size - len(NAMES)
        slope, sd = self._regression
        departure = hyperparameters - self.mean[:first]
        return self.mean[first:] + np.where(np.isfinite(departure), departure, 0.0) @ slope, sd

    @cached_property
    def _regression(self) -> tuple[FloatArray, FloatArray]:
        """Slope (k − 8, 8) of the loadings' deviates on those before, and what is left, (8,)."""
        first = self.mean.size - len(NAMES)
        cross = self.covariance[first:, :first]
        slope = np.asarray(np.linalg.solve(self.covariance[:first, :first], cross.T))
        left = np.diag(self.covariance[first:, first:]) - np.einsum("ij,ji->i", cross, slope)
        return slope, np.sqrt(left)


def _draw_drives(
    precision: FloatArray,
    information: FloatArray,
    centre: FloatArray,
    variance: FloatArray,
    rng: np.random.Generator,
) -> FloatArray:
    """Draw every drive's deviates (drives, k), given the fleet's mean and variance (k,)."""
    factor = np.linalg.cholesky(precision + np.diag(1.0 / variance))
    pull = (information + centre / variance)[..., None]
    noise = rng.standard_normal(pull.shape)
    upper = np.swapaxes(factor, -1, -2)
    return np.asarray(np.linalg.solve(upper, np.linalg.solve(factor, pull) + noise)[..., 0])


def _move_fleet(
    precision: FloatArray,
    information: FloatArray,
    departure: FloatArray,
    share: FloatArray,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Draw the fleet's mean with all drives along, given their departures ε (drives, k) from it.

    Where drives of one fleet hardly differ, mean and drives would hold each other in their places
    (interweaving: Yu & Meng, J. Comp. Graph. Stat. 20, 2011).

    Returns
    -------
    the drives' deviates (drives, k), and the mean (k,)
    """
    factor = np.linalg.cholesky(precision.sum(axis=0) + np.diag(1.0 / share))
    pull = (information - np.einsum("dij,dj->di", precision, departure)).sum(axis=0)
    noise = rng.standard_normal(share.size)
    centre = np.linalg.solve(factor.T, np.linalg.solve(factor, pull) + noise)
    return centre + departure, np.asarray(centre)


def _draw_within(
    own: FloatArray, centre: FloatArray, log_prior: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Draw √(1 − ρ) (k,) given the drives' deviates (drives, k) and the fleet's mean (k,).

    `log_prior` (70, k) is that of `WITHIN`.
    """
    squares = ((own - centre) ** 2).sum(axis=0)
    spread = WITHIN[:, None]
    within, between = spread**2, 1.0 - spread**2
    log_density = log_prior - 0.5 * (
        np.log(between) + centre**2 / between + len(own) * np.log(within) + squares / within
    )
    return np.asarray(WITHIN[np.argmax(log_density + rng.gumbel(size=log_density.shape), axis=0)])


def log_prior_of_spread(scale: FloatArray) -> FloatArray:
    """Log of the half-Cauchy masses (70, k) of `WITHIN`, evenly spaced in the logarithm.

    Parameters
    ----------
    scale : (k,) of each deviate
    """
    spread = WITHIN[:, None]
    return np.asarray(np.log(spread) - np.log1p((spread / scale) ** 2))
