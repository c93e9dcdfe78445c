"""A fleet whose drives may wear at a steady pace: by a power of the hours, and nothing beside it.

The shipped prior takes a drive's pace to bend and to wander. A fleet can show that its drives' does
not: no curvature of the clock, no random change of its rate, and so none to expect past the last
test; wear is then a Wiener process on a power of the hours (Whitmore & Schenkelberg, Lifetime Data
Analysis 3, 1997). Each drive's pace is steady with a chance π that the fleet shares,

    s_i ~ Bernoulli(π),   π ~ Beta(½, ½) (Jeffreys' prior),

and its tests tell by how much better they fit either way. What a drive says of the hyperparameters
under a steady pace counts by the chance that its pace is. A drive without a fleet has the shipped
prior alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.fleet import FleetPrior, Said

CURVATURE, RATE_VOLATILITY = 2, 5
"""Places among `state_space.HYPERPARAMETERS` of those that a steady pace has not."""
_SHARES = (np.arange(400) + 0.5) / 400


@dataclass(frozen=True)
class SteadySaid:
    """What a drive's tests say if its pace is steady.

    Attributes
    ----------
    said : of the deviates
    log_odds : log of the tests' likelihood over that under the shipped prior
    """

    said: Said
    log_odds: float


@dataclass(frozen=True)
class Told:
    """What a drive tells others.

    Attributes
    ----------
    said : of the deviates under the shipped prior's wandering pace
    steady : under a steady one; None where it was not kept
    """

    said: Said
    steady: SteadySaid | None


@dataclass(frozen=True)
class ToldEarly:
    """The same before the loops are sampled; `said` is None where it waits for them."""

    said: Said | None
    steady: SteadySaid | None


def all_steady(size: int) -> FleetPrior:
    """Prior of so many deviates that is the shipped one but for a pace that is surely steady."""
    shipped = FleetPrior((), np.zeros(size), np.eye(size))
    return FleetPrior((), shipped.mean, shipped.covariance, shipped, 1.0)


def pooled_fleet(drives: Sequence[str], told: Sequence[Told], within: FloatArray) -> FleetPrior:
    """Pool what drives tell, of a steady pace where they do.

    Parameters
    ----------
    drives : ids
    told : by each
    within : (k,) how far drives of one fleet may differ; see `FleetPrior.of`
    """
    pooled = FleetPrior.of(drives, [one.said for one in told], within)
    steady = {
        drive: one.steady for drive, one in zip(drives, told, strict=True) if one.steady is not None
    }
    if not steady:
        return pooled
    chance, own = steady_chance(np.array([one.log_odds for one in steady.values()]))
    counted = [one.said.times(share) for one, share in zip(steady.values(), own, strict=True)]
    beside = FleetPrior.of(tuple(steady), counted, within)
    return FleetPrior(pooled.drives, pooled.mean, pooled.covariance, beside, chance)


def steady_chance(log_odds: FloatArray) -> tuple[float, FloatArray]:
    """Chance that the next drive's pace is steady, and that of each drive (drives,).

    Parameters
    ----------
    log_odds : (drives,) of what each one's tests say by themselves
    """
    steady, wandering = np.log(_SHARES)[:, None], np.log1p(-_SHARES)[:, None]
    either = np.logaddexp(steady + log_odds, wandering)
    log_weight = either.sum(axis=1) - 0.5 * (steady + wandering)[:, 0]
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    return float(weight @ _SHARES), weight @ np.exp(steady + log_odds - either)


def pooled_deviates(standard: FloatArray, fleet: FleetPrior) -> FloatArray:
    """Deviates (draws, k) of a drive of the fleet from standard normal ones.

    That of the rate's volatility tells which rows are steady: those in its lower tail of the
    fleet's chance. They have none, a deviate of −∞, and a straight clock.
    """
    mean, root = fleet.of_hyperparameters
    if fleet.steady is None:
        return np.asarray(mean + standard @ root.T)
    from scipy.special import ndtr, ndtri

    level = ndtr(standard[:, RATE_VOLATILITY])
    steady = level < fleet.chance
    above = np.maximum(level - fleet.chance, 0.0) / max(1.0 - fleet.chance, 1e-12)
    stretched = standard.copy()
    stretched[:, RATE_VOLATILITY] = ndtri(np.clip(above, 1e-12, 1.0 - 1e-12))
    found = mean + stretched @ root.T
    mean, root = fleet.steady.of_hyperparameters
    # Below the chance levels are as even as all are: a normal deviate again.
    below = standard[steady].copy()
    level_below = level[steady] / max(fleet.chance, 1e-12)
    below[:, RATE_VOLATILITY] = ndtri(np.clip(level_below, 1e-12, 1.0 - 1e-12))
    found[steady] = mean + below @ root.T
    found[steady, CURVATURE], found[steady, RATE_VOLATILITY] = 0.0, -np.inf
    return np.asarray(found)


def is_steady(deviates: FloatArray) -> np.ndarray:
    """(draws,) which of the deviates (draws, k) are of a steady pace."""
    return np.asarray(np.isneginf(deviates[:, RATE_VOLATILITY]))


def pooled_loadings(deviates: FloatArray, fleet: FleetPrior) -> tuple[FloatArray, FloatArray]:
    """Mean and sd (draws, 8) of the loadings' deviates, given the hyperparameters' (draws, k)."""
    mean, sd = fleet.of_loadings(deviates)
    sd = np.broadcast_to(sd, (len(deviates), len(NAMES)))
    if fleet.steady is None:
        return mean, sd
    steady = is_steady(deviates)[:, None]
    beside, beside_sd = fleet.steady.of_loadings(deviates)
    return np.where(steady, beside, mean), np.where(steady, beside_sd, sd)
