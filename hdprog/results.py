"""What the stages hand on: frozen results of a test, of its trend and of its forecast.

They hold numbers only, ready to be written as JSON, drawn or stored.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Literal

from hdprog import __version__
from hdprog.config import Drive, Limit
from hdprog.data.loop import Loop
from hdprog.explanation import DriveExplanation, Explanation
from hdprog.physics.parameters import FloatArray

LEVELS: tuple[float, ...] = (0.05, 0.25, 0.50, 0.75, 0.95)
"""Quantile levels of every band and summary."""


@dataclass(frozen=True)
class ParameterSummary:
    """Posterior of one parameter in its physical unit, with its diagnostics.

    `contraction` is 1 − var(posterior)/var(prior) in the unconstrained coordinate: 0 where the
    test said nothing, near 1 where it said all.
    """

    mean: float
    sd: float
    quantiles: Mapping[float, float]
    rhat: float
    ess_bulk: float
    ess_tail: float
    contraction: float


Diagnosis = Literal["record", "shared", "prior", "conflict", "overruled"]
"""Who carries a number: the record alone, both, the prior alone; or prior and record disagree and
share it ("conflict"), or disagree and the record alone decides ("overruled")."""


@dataclass(frozen=True)
class Sensitivity:
    """What a number of a test rests on.

    Attributes
    ----------
    prior, record : power-scaling sensitivity to the prior and to the likelihood; 0.05 and more
        counts
    diagnosis : what follows
    shift : how far the record moved a parameter from the prior's mean, standard normal where
        prior and record agree; None for figures
    """

    prior: float
    record: float
    diagnosis: Diagnosis
    shift: float | None = None


@dataclass(frozen=True)
class Combination:
    """Parameters that a record knows together, in a physical unit.

    Attributes
    ----------
    quantiles : by level
    contraction : 1 − var(posterior)/var(prior) of its logarithm
    """

    quantiles: Mapping[float, float]
    contraction: float


@dataclass(frozen=True)
class Identification:
    """What a record tells of the eight parameters, and what it leaves to the prior.

    Attributes
    ----------
    largest_torque : of the record, in Nm
    beyond_record : probability that the preload torque T_i lies beyond it
    one_spring : cup and teeth act as one stiffness, as where T_T is near 0
    combined_stiffness : K of cup and meshed teeth in Nm/rad (38)
    no_load_friction : −c·μ·T_i in Nm
    """

    largest_torque: float
    beyond_record: float
    one_spring: bool
    combined_stiffness: Combination
    no_load_friction: Combination


@dataclass(frozen=True)
class OtherToothAngle:
    """A test as it would read with another gear-tooth angle than the assumed one.

    Attributes
    ----------
    alpha : the other angle in rad
    parameters : name → level → value
    figures : key → level → value
    """

    alpha: float
    parameters: Mapping[str, Mapping[float, float]]
    figures: Mapping[str, Mapping[float, float]]


@dataclass(frozen=True)
class ParameterDraws:
    """Some draws of a test's eight parameters in their physical units, to be looked at.

    Attributes
    ----------
    posterior, prior : name → (draws,); the draws of one point stand at one place in all parameters
    """

    posterior: Mapping[str, FloatArray]
    prior: Mapping[str, FloatArray]


@dataclass(frozen=True)
class PaperIdentification:
    """Point estimate by the paper's own identification: five points, then least squares.

    Attributes
    ----------
    points : A1 … A5, torque in Nm and angle in rad (of A3 the loop's width)
    parameters : by name
    other_choices : least and largest value of each parameter over other choices of the points
    choices_tried, choices_solved : choices of points, and those that gave parameters at all
    threshold_read : torque in Nm where the loading branch was read to turn straight
    rmse_rad : root of the criterion (37) over its points
    figures : figures of merit of these parameters by key
    """

    points: Mapping[str, tuple[float, float]]
    parameters: Mapping[str, float]
    other_choices: Mapping[str, tuple[float, float]]
    choices_tried: int
    choices_solved: int
    threshold_read: float
    rmse_rad: float
    figures: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class LoopFit:
    """The fit along the (reduced) record of one test; all arrays are (blocks,).

    Attributes
    ----------
    torque, angle : block averages of the record in Nm and rad
    count : readings in each block
    fitted : posterior median angle in rad, offset included
    low, high : 5 % and 95 % of the posterior of the angle in rad
    residual : angle − fitted in rad
    noise : standard deviation of a block's angle as fitted, in rad
    position : index of the block's middle reading in the record
    """

    torque: FloatArray
    angle: FloatArray
    count: FloatArray
    fitted: FloatArray
    low: FloatArray
    high: FloatArray
    residual: FloatArray
    noise: FloatArray
    position: FloatArray


@dataclass(frozen=True)
class TestResult:
    """One measured loop, fitted."""

    __test__ = False  # not a pytest class

    test_id: str
    service_hours: float | None
    date: str | None
    note: str | None
    event: str | None
    loop: Loop
    drive: Drive
    prior_name: str
    converged: bool
    parameters: Mapping[str, ParameterSummary]
    figures: Mapping[str, Mapping[float, float]]  # key → level → value
    effects: tuple[str, ...]
    fit: LoopFit
    rmse_rad: float  # over the recorded samples
    noise_floor_rad: float  # scatter of neighbouring readings about a smooth course
    outlier_fraction: float
    residual_correlation: float  # lag-1 correlation of the residual of neighbouring blocks
    noise_model: str  # "white" or the named model of correlated noise, in words
    diagnostics: Mapping[str, float]  # ensembles, walkers, steps, burn_in, tau, acceptance, seconds
    warnings: tuple[str, ...]
    figures_with_effects: Mapping[str, Mapping[float, float]] = field(default_factory=dict)
    """Width, loss and lost motion with lasting effects in them; empty where there are none."""
    identification: Identification | None = None
    sensitivity: Mapping[str, Sensitivity] = field(default_factory=dict)
    """What each parameter and figure rests on, by parameter's name and figure's key."""
    other_tooth_angle: OtherToothAngle | None = None
    """None where the tooth angle is declared."""
    paper: PaperIdentification | None = None
    """The paper's own identification, where it was asked for."""
    draws: ParameterDraws | None = None
    """Some draws, for pictures of the posterior."""


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


@dataclass(frozen=True)
class Forecast:
    """First crossing of one limit; `limit` is None for the first of all limits.

    Attributes
    ----------
    now_hours : service hours of the last test
    already_crossed : the state at now is past the limit with more than even odds
    inspect_before_hours : service hours at which P(crossed) reaches the acceptable risk, or None
        past the horizon
    remaining_hours : level → hours from now, None past the horizon
    crossing_probability : (times, 2) service hours and P(crossed), non-decreasing, now to horizon
    """

    limit: Limit | None
    now_hours: float
    already_crossed: bool
    acceptable_risk: float
    horizon_hours: float
    inspect_before_hours: float | None
    probability_crossed_by_shutdown: float | None
    probability_crossed_by_horizon: float
    remaining_hours: Mapping[float, float | None]
    crossing_probability: FloatArray


@dataclass(frozen=True)
class LoadScenario:
    """What the forecasts would be under another load from now on.

    Attributes
    ----------
    load : torque to come over the torque so far
    forecasts : of the same limits, from the same draws of the trend
    """

    load: float
    forecasts: tuple[Forecast, ...]


@dataclass(frozen=True)
class Provenance:
    """How a result came about."""

    hdprog_version: str
    seed: int | None  # None where a generator was handed in
    quick: bool
    command: str
    created: str  # ISO 8601, UTC
    versions: Mapping[str, str]
    files: Mapping[str, str]  # file name → SHA-256

    @staticmethod
    def of(
        loops: Iterable[Loop],
        seed: int | None,
        quick: bool,
        packages: Sequence[str] = ("numpy", "scipy", "emcee", "arviz"),
    ) -> Provenance:
        """What is made now from these records, with the versions of these packages."""
        return Provenance(
            hdprog_version=__version__,
            seed=seed,
            quick=quick,
            command="Python API",
            created=datetime.now(UTC).isoformat(timespec="seconds"),
            versions={name: version(name) for name in packages},
            files={loop.source: loop.sha256 for loop in loops},
        )


@dataclass(frozen=True)
class DriveResult:
    """Everything about a drive: its tests, trend and forecasts (empty for a single fit).

    `forecasts` take the load to stay as it was, `scenarios` (where asked for) take it to change.
    `explanation` is None where effects were not looked for.
    """

    drive: Drive
    tests: tuple[TestResult, ...]
    trend: TrendSummary | None
    forecasts: tuple[Forecast, ...]
    warnings: tuple[str, ...]
    provenance: Provenance
    seconds: Mapping[str, float] = field(default_factory=dict)
    explanation: Explanation | DriveExplanation | None = None
    scenarios: tuple[LoadScenario, ...] = ()

    @property
    def converged(self) -> bool:
        """Whether every fit and the trend converged."""
        return all(test.converged for test in self.tests) and (
            self.trend is None or self.trend.converged
        )
