"""What a test's fit hands on: parameters, figures, what the record fixes, and the loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.physics.parameters import FloatArray


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
    figures : key → level → value; without those that the draws do not tell
    """

    alpha: float
    parameters: Mapping[str, Mapping[float, float]]
    figures: Mapping[str, Mapping[float, float]]


@dataclass(frozen=True)
class ReadOff:
    """A figure as the record itself shows it, and the fitted curve at the same torques.

    Attributes
    ----------
    record, record_sd : read off the record without a model, with the standard deviation of its
        noise; at the record's own swing of torque, in the figure's unit
    fit : level → value, the same read off the fitted curves, an empirical curve left out
    differs : the fit misses what the record shows by more than chance, and by enough to matter
    """

    record: float
    record_sd: float
    fit: Mapping[float, float]
    differs: bool


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
class EffectSummary:
    """Posterior of the parameters of an effect that was fitted beside the drive model.

    Attributes
    ----------
    id : of the effect
    parameters : name → level → value
    units : of the parameters by name
    """

    id: str
    parameters: Mapping[str, Mapping[float, float]]
    units: Mapping[str, str]


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
    by_rule : whether the rule's own points gave the parameters; else the first others that did
    rmse_rad : root of the criterion (37) over its points
    figures : figures of merit of these parameters by key
    """

    points: Mapping[str, tuple[float, float]]
    parameters: Mapping[str, float]
    other_choices: Mapping[str, tuple[float, float]]
    choices_tried: int
    choices_solved: int
    threshold_read: float
    by_rule: bool
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
    fit: LoopFit = field(repr=False)
    rmse_rad: float  # over the recorded samples
    noise_floor_rad: float  # scatter of neighbouring residuals about a smooth course
    outlier_fraction: float
    residual_correlation: float  # lag-1 correlation of the residual of neighbouring blocks
    noise_model: str  # white or the named model of correlated noise, in words
    diagnostics: Mapping[str, float]  # numbers of the sampling, and its seconds
    warnings: tuple[str, ...]
    figures_with_effects: Mapping[str, Mapping[float, float]] = field(default_factory=dict)
    """Width, loss and lost motion with lasting effects in them; empty where there are none."""
    read_off: Mapping[str, ReadOff] = field(default_factory=dict)
    """Figures that the record shows without a model, by key; empty for a record of one side."""
    effect_summaries: tuple[EffectSummary, ...] = ()
    """Parameters of the effects fitted; an empirical term has none."""
    identification: Identification | None = None
    sensitivity: Mapping[str, Sensitivity] = field(default_factory=dict)
    """What each parameter and figure rests on, by parameter's name and figure's key."""
    other_tooth_angle: OtherToothAngle | None = None
    """None where the tooth angle is declared."""
    paper: PaperIdentification | None = None
    """The paper's own identification, where it was asked for."""
    draws: ParameterDraws | None = field(default=None, repr=False)
    """Some draws, for pictures of the posterior."""
