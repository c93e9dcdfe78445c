"""What a comparison of models hands on: numbers only, ready to be written as JSON or drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hdprog.data.loop import Loop
from hdprog.explanation import ErrorFigures
from hdprog.physics.figures import Operation
from hdprog.physics.parameters import FloatArray
from hdprog.results import LoopFit, Provenance

DRIVE = "drive"
"""Id of the drive model among the models compared."""

MARGIN = 4.0
"""Difference of expected log predictive density below which two models count as equal."""


@dataclass(frozen=True)
class ModelParameterSummary:
    """Posterior of one parameter of a model in its physical unit, with its diagnostics."""

    unit: str
    meaning: str
    quantiles: Mapping[float, float]
    rhat: float
    ess_bulk: float
    ess_tail: float
    contraction: float


@dataclass(frozen=True)
class StiffnessBand:
    """Local stiffness dT/dΔθ of a model's stiffness curve (39).

    Attributes
    ----------
    torque : (points,) in Nm
    quantiles : level → (points,) in Nm/rad
    """

    torque: FloatArray
    quantiles: Mapping[float, FloatArray]


@dataclass(frozen=True)
class Evidence:
    """How well a model predicts what it has not seen.

    Attributes
    ----------
    elpd, se : expected log predictive density by PSIS-LOO over the blocks, with its standard error
    effective_parameters : p_loo
    difference, difference_se : to the best model's, zero for the best
    weight : stacking weight
    doubtful_blocks : share of blocks whose Pareto k is above 0.7
    heldout_difference, heldout_difference_se : the same difference on left-out cycles or tenths
    """

    elpd: float
    se: float
    effective_parameters: float
    difference: float
    difference_se: float
    weight: float
    doubtful_blocks: float
    heldout_difference: float
    heldout_difference_se: float

    @property
    def level_with_the_best(self) -> bool:
        """Whether the difference is within the margin or within two standard errors."""
        return self.difference < max(MARGIN, 2 * self.difference_se)


@dataclass(frozen=True)
class ComparedModel:
    """One model on the record.

    Attributes
    ----------
    id, words, source, where : which model, from where, and on which records it says something
    equation : its definition, as its docstring has it
    parameters : by name
    errors : over the recorded samples
    evidence : against the others
    width : quantiles of the hysteresis width in rad, see `Comparison.width_torque`
    stiffness : local stiffness over torque; None for the rigid model
    fit : along the blocks
    converged : whether its posterior is to be relied on
    method : how its posterior was had
    noise_model : in words
    sampling : numbers of the run by name
    seconds : wall time
    """

    id: str
    words: str
    source: str
    where: str
    equation: str
    parameters: Mapping[str, ModelParameterSummary]
    errors: ErrorFigures
    evidence: Evidence
    width: Mapping[float, float]
    stiffness: StiffnessBand | None
    fit: LoopFit
    converged: bool
    method: str
    noise_model: str
    sampling: Mapping[str, float]
    seconds: float


@dataclass(frozen=True)
class LeftOut:
    """A model that cannot be defined on the record, and why."""

    id: str
    words: str
    why: str


@dataclass(frozen=True)
class Comparison:
    """All models on one record, best first.

    Attributes
    ----------
    loop : the record
    operation : what figures refer to
    two_sided : whether the record has both signs of torque
    amplitude : torque in Nm of the steady cycle that widths and stiffness curves are read on
    width_torque : torque in Nm at which the width is read: zero, half the amplitude if one-sided
    noise_floor_rad : scatter of neighbouring residuals about a smooth course
    models : by expected log predictive density, best first
    left_out : models that cannot be defined on the record
    warnings : in words
    """

    loop: Loop
    operation: Operation
    two_sided: bool
    amplitude: float
    width_torque: float
    noise_floor_rad: float
    models: tuple[ComparedModel, ...]
    left_out: tuple[LeftOut, ...]
    warnings: tuple[str, ...]
    provenance: Provenance
    seconds: Mapping[str, float]

    @property
    def converged(self) -> bool:
        """Whether every model's posterior converged."""
        return all(model.converged for model in self.models)

    @property
    def level(self) -> tuple[ComparedModel, ...]:
        """The best model and those that cannot be told from it."""
        return tuple(one for one in self.models if one.evidence.level_with_the_best)

    def of(self, model_id: str) -> ComparedModel:
        """One model by its id; KeyError where it is not among them."""
        return {model.id: model for model in self.models}[model_id]
