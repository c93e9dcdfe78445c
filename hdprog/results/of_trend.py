"""What the trend over service hours hands on, and what it tells other drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hdprog.physics.parameters import FloatArray


@dataclass(frozen=True)
class FigureTrend:
    """A figure of merit over service time: its state without the scatter of remounting.

    Attributes
    ----------
    key : figure's name, as in `Limit.key`
    hours : (times,) service hours, from the first test to the horizon
    quantiles : (levels, times) at `LEVELS`
    test_hours, test_quantiles : (tests,), (levels, tests) each test's own posterior; where tests
        differ in temperature, as it would be at the reference
    reference_C : that temperature; None where they do not
    """

    key: str
    hours: FloatArray
    quantiles: FloatArray
    test_hours: FloatArray
    test_quantiles: FloatArray
    reference_C: float | None = None


@dataclass(frozen=True)
class WearSaid:
    """What a drive's tests say of its wear beyond any prior, for other drives to learn from.

    Attributes
    ----------
    wear_prior : identity of the wear prior, in whose deviates z the numbers are
    deviates : (k) names
    precision, information : Λ (k, k), η (k,) of the log likelihood −½ zᵀΛz + ηᵀz
    steady : the same if the drive's pace is steady; None where it was not kept
    """

    wear_prior: str
    deviates: tuple[str, ...]
    precision: FloatArray
    information: FloatArray
    steady: SteadyWearSaid | None = None


@dataclass(frozen=True)
class SteadyWearSaid:
    """What a drive's tests say of its wear if its pace is steady; see `trend.steady_pace`.

    Attributes
    ----------
    precision, information : as in `WearSaid`
    log_odds : log of the tests' likelihood over that under the shipped prior
    """

    precision: FloatArray
    information: FloatArray
    log_odds: float


@dataclass(frozen=True)
class SteadyShare:
    """The chance that a drive's pace is steady, as its fleet and its own tests have it.

    Attributes
    ----------
    told : number of other drives whose runs tell of it
    fleet : before the drive's own tests
    own : after them
    """

    told: int
    fleet: float
    own: float


@dataclass(frozen=True)
class Shrinkage:
    """A hyperparameter on its way from any drive's prior to this drive; level → value each.

    Attributes
    ----------
    shipped : under the shipped prior, that of any drive
    fleet : under the prior of this fleet
    own : by this drive's tests and the shipped prior, without the fleet
    """

    shipped: Mapping[float, float]
    fleet: Mapping[float, float]
    own: Mapping[float, float]


@dataclass(frozen=True)
class FleetShare:
    """What a drive's trend has learnt from other drives.

    Attributes
    ----------
    drives : their ids
    hyperparameters : by name
    left_out : runs that could not be used, in words
    steady : whether the pace is steady; None where no run tells of it
    """

    drives: tuple[str, ...]
    hyperparameters: Mapping[str, Shrinkage]
    left_out: tuple[str, ...] = ()
    steady: SteadyShare | None = None


@dataclass(frozen=True)
class TemperatureEffect:
    """What temperature changes in a drive whose tests differ in it.

    Attributes
    ----------
    reference_C : at which the trend is told: the mean of the tests that give one
    spread_K : standard deviation of the tests' temperatures
    unknown : number of tests without one, taken at the reference, give or take `spread_K`
    percent_per_10K : figure → level → change in per cent of the drive as it is now
    """

    reference_C: float
    spread_K: float
    unknown: int
    percent_per_10K: Mapping[str, Mapping[float, float]]


@dataclass(frozen=True)
class NotReproduced:
    """A figure of some tests that the trend does not reproduce.

    Attributes
    ----------
    key : the figure's
    tests : places of the tests in order of service hours, from 0
    worst : the one that is farthest off
    joint, alone : 5 %, 50 % and 95 % of its figure, by the trend and by its own posterior
    """

    key: str
    tests: tuple[int, ...]
    worst: int
    joint: tuple[float, float, float]
    alone: tuple[float, float, float]


@dataclass(frozen=True)
class SuddenEffect:
    """A followed effect that came, or went, at once between two tests, rather than with wear.

    Attributes
    ----------
    effect : its id
    test : place of the first test after it in order of service hours, from 0
    came : whether there is more of it from then on
    """

    effect: str
    test: int
    came: bool


@dataclass(frozen=True)
class TrendSummary:
    """The trend model as fitted."""

    model: str  # one sentence
    hyperparameters: Mapping[str, Mapping[float, float]]  # name → level → value
    carried_by_prior: tuple[str, ...]  # hyperparameters that the data hardly moved
    figures: Mapping[str, FigureTrend]
    diagnostics: Mapping[str, float]
    converged: bool
    warnings: tuple[str, ...]
    followed: tuple[str, ...] = ()  # effects whose amplitudes are part of the state
    says: WearSaid | None = None
    fleet: FleetShare | None = None  # None where no other drives were given
    temperature: TemperatureEffect | None = None  # None where the tests do not differ in it
    not_reproduced: tuple[NotReproduced, ...] = ()
    sudden: tuple[SuddenEffect, ...] = ()
