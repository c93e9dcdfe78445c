"""What closing the loop hands on: which effect was traced, and the error before and after.

Numbers only, ready to be written as JSON or drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.parameters import FloatArray

Quantiles = Mapping[float, float]
"""Value at the levels 0.05, 0.25, 0.5, 0.75 and 0.95."""

Verdict = Literal["adequate", "explained", "partly_explained", "unexplained"]
Origin = Literal["rig", "wear", "unclear"]

UNKNOWN = "unknown"
_PERSONS = {"coulomb": "Coulomb", "stribeck": "Stribeck"}


def spoken_effect(identifier: str) -> str:
    """Id of an effect as running text has it: "Coulomb friction"."""
    return " ".join(_PERSONS.get(word, word) for word in identifier.split("_"))


@dataclass(frozen=True)
class ErrorFigures:
    """Error of a fit, over the recorded samples.

    Attributes
    ----------
    rmse_rad : on the samples that were fitted
    heldout_rmse_rad : on whole cycles left out in turn where there are three or more, else on ten
        contiguous blocks left out in turn
    reversal_rmse_rad : on samples within 5 % of the torque span after a reversal; None where there
        are none
    lag1 : correlation of the residual with itself one sample on
    """

    rmse_rad: float
    heldout_rmse_rad: float
    reversal_rmse_rad: float | None
    lag1: float


@dataclass(frozen=True)
class Carrier:
    """How much of the base model's residual a smooth function of one coordinate carries.

    Attributes
    ----------
    coordinate : time, torque, angle, rate, temperature, output_angle, branch,
        distance_since_reversal or order
    fraction : cross-validated share of the residual's variance; 0 where it predicts nothing
    p_value : of no dependence, corrected for the number of coordinates (Holm)
    """

    coordinate: str
    fraction: float
    p_value: float


@dataclass(frozen=True)
class FoundEffect:
    """An effect that was added to the model.

    Attributes
    ----------
    id : of an effect, or "unknown"
    words : what it is, in a few plain words
    coordinate : what an unknown term depends on; None for a mechanism
    log_evidence_gain : log Bayes factor of the model with it over that without it; of an unknown
        term less what its two numbers must earn
    elpd_gain, elpd_se : expected log predictive density gained, with its standard error
    share : of the base model's explainable error (mean square) that it carries
    parameters : physical values by name
    units : of the parameters by name
    indistinguishable_from : ids of effects that would do as well on this record
    separating_test : the test that would tell them apart; None where there are none
    advice : what to do about it
    origin : of the rig or of wear; None for a single record
    """

    id: str
    words: str
    coordinate: str | None
    log_evidence_gain: float
    elpd_gain: float
    elpd_se: float
    share: float
    parameters: Mapping[str, Quantiles]
    units: Mapping[str, str]
    indistinguishable_from: tuple[str, ...]
    separating_test: str | None
    advice: str
    origin: Origin | None = None


@dataclass(frozen=True)
class LeftOver:
    """What remains beside the mechanisms that were added: clear, but a small share of the error.

    It may be an effect of its own, or that a mechanism's shape is not quite the true one.

    Attributes
    ----------
    id : of the effect that would carry it best, or "unknown" where a curve does
    coordinate : what that curve depends on; None for a mechanism
    log_evidence_gain : that it would gain; of all tests of a drive together, in each of them
    """

    id: str
    coordinate: str | None
    log_evidence_gain: float


@dataclass(frozen=True)
class ConsideredEffect:
    """An effect that was looked at and not added, and why."""

    id: str
    words: str
    log_evidence_gain: float | None
    elpd_gain: float | None
    elpd_se: float | None
    why_not: str


@dataclass(frozen=True)
class ResidualCourse:
    """The residual along the record's blocks, before and after; arrays are (blocks,).

    Attributes
    ----------
    torque, angle : of the blocks in Nm and rad
    rising : whether torque rises
    position : index of the block's middle reading in the record
    time : in s, or None
    count : readings in each block
    before, after : residual of the base model and of the model with the effects, in rad
    added : what the added effects contribute to the angle, in rad, their mean taken out
    unknown : the empirical term's part of it in rad, or None
    coordinates : by name, the value of every coordinate that was looked at
    noise : standard deviation of a block's reading noise in rad
    """

    torque: FloatArray
    angle: FloatArray
    rising: NDArray[np.bool_]
    position: FloatArray
    time: FloatArray | None
    count: FloatArray
    before: FloatArray
    after: FloatArray
    added: FloatArray
    unknown: FloatArray | None
    coordinates: Mapping[str, FloatArray]
    noise: FloatArray


@dataclass(frozen=True)
class Explanation:
    """One record, before and after.

    Attributes
    ----------
    test_id : of the test, or the file's stem
    service_hours : of the test, or None
    verdict : adequate (nothing added), explained (mechanisms added, and what remains is noise or
        little), partly_explained (mechanisms, and an unknown term or structure beside them) or
        unexplained (the unknown term alone)
    noise_floor_rad : scatter of neighbouring residuals about a smooth course
    repeatability_rad : how far the record's own cycles differ from each other (root mean square
        about their mean), or None where no cycle repeats
    outlier_fraction : share of readings set aside as isolated spikes
    before, after : error figures
    branch_rmse : name of a branch ("rising", "falling") → (before, after) in rad
    carried_by : by coordinate, largest share first
    effects, considered : added, and not added
    strained : base parameters that only fit far out in their prior: name → prior standard
        deviations away, before
    parameters_before, parameters_after : quantiles by name
    figures_before, figures_after : quantiles by key
    course : residuals to draw
    converged : both posteriors converged
    warnings : in words
    left_over : what remains beside the mechanisms and was not added, or None
    """

    test_id: str
    service_hours: float | None
    verdict: Verdict
    noise_floor_rad: float
    repeatability_rad: float | None
    outlier_fraction: float
    before: ErrorFigures
    after: ErrorFigures
    branch_rmse: Mapping[str, tuple[float, float]]
    carried_by: tuple[Carrier, ...]
    effects: tuple[FoundEffect, ...]
    considered: tuple[ConsideredEffect, ...]
    strained: Mapping[str, float]
    parameters_before: Mapping[str, Quantiles]
    parameters_after: Mapping[str, Quantiles]
    figures_before: Mapping[str, Quantiles]
    figures_after: Mapping[str, Quantiles]
    course: ResidualCourse
    converged: bool
    warnings: tuple[str, ...] = ()
    left_over: LeftOver | None = None


@dataclass(frozen=True)
class DriveExplanation:
    """A drive's tests together.

    Attributes
    ----------
    verdict : pooled
    effects, considered : pooled over the tests; an effect's parameters are those of the last test
        that carries it, its `origin` is filled
    amplitudes : effect id → (tests, 4) service hours and 5 %, 50 %, 95 % of the angle that it
        moves (root mean square over the record, in rad); a test without it has zeros, one whose
        record cannot show it NaN
    tests : one a test, by service hours
    remaining_hours_before, remaining_hours_after : level → hours to the first limit without and
        with the effects, None past the horizon; None altogether where there is no forecast
    """

    verdict: Verdict
    effects: tuple[FoundEffect, ...]
    considered: tuple[ConsideredEffect, ...]
    amplitudes: Mapping[str, FloatArray]
    tests: tuple[Explanation, ...]
    remaining_hours_before: Mapping[float, float | None] | None = None
    remaining_hours_after: Mapping[float, float | None] | None = None

    @property
    def left_over(self) -> LeftOver | None:
        """What remains of all tests together beside the mechanisms, or None."""
        return next((test.left_over for test in self.tests if test.left_over is not None), None)

    def not_shown_by(self, test_id: str) -> tuple[str, ...]:
        """Ids of effects of the drive that the record of a test cannot show."""
        at = [test.test_id for test in self.tests].index(test_id)
        return tuple(name for name, sizes in self.amplitudes.items() if np.isnan(sizes[at, 2]))
