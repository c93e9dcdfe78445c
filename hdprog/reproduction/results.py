"""What a reproduction of the paper hands on: curves, numbers, and a finding for each claim."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from hdprog.physics.parameters import FloatArray
from hdprog.results import ParameterSummary, Provenance

Outcome = Literal["agrees", "disagrees", "cannot be checked"]


@dataclass(frozen=True)
class Finding:
    """A claim of the paper and what came out.

    Attributes
    ----------
    figure : of the paper, as "Fig. 10"; of this project where it has none
    claim : what the paper says, in words
    came_out : what the computation gave, with its numbers
    outcome : whether that agrees
    numbers : the computed numbers by name, with the unit in the name
    """

    figure: str
    claim: str
    came_out: str
    outcome: Outcome
    numbers: Mapping[str, float]


@dataclass(frozen=True)
class BranchPair:
    """A steady loop.

    Attributes
    ----------
    label : which one
    torque : (points,) rising, in Nm
    rising, falling : (points,) angle on the branches in rad
    """

    label: str
    torque: FloatArray
    rising: FloatArray
    falling: FloatArray

    @property
    def width(self) -> FloatArray:
        """(points,) angle between the branches in rad."""
        return self.falling - self.rising


@dataclass(frozen=True)
class Curve:
    """A named curve: x over y of equal shape, in the units that the picture names."""

    label: str
    x: FloatArray
    y: FloatArray


@dataclass(frozen=True)
class Sweep:
    """Loops with one parameter varied, the rest as in Table 2's post-test column.

    Attributes
    ----------
    parameter : its name
    figure : of the paper
    values : of the parameter
    loops : one a value
    """

    parameter: str
    figure: str
    values: tuple[float, ...]
    loops: tuple[BranchPair, ...]


@dataclass(frozen=True)
class Recovery:
    """Parameters that the posterior finds on a loop made with Table 2.

    Attributes
    ----------
    label : "initial" or "post-test"
    truth : by name; combined and no-load figures too
    found : posterior by the same names: level → value
    deviations : truth less posterior mean, in posterior standard deviations
    summaries : of the eight parameters, with diagnostics
    converged : whether the posterior is to be relied on
    """

    label: str
    truth: Mapping[str, float]
    found: Mapping[str, Mapping[float, float]]
    deviations: Mapping[str, float]
    summaries: Mapping[str, ParameterSummary]
    converged: bool


@dataclass(frozen=True)
class Reproduction:
    """Everything that was computed.

    Attributes
    ----------
    loops : Table 2's two loops (Fig. 10)
    others : the post-test loop and the other models fitted to it (Fig. 11)
    sweeps : Figs 12 and 13
    stiffness : stiffness curves, angle in rad over torque in Nm (Fig. 14)
    local : local elastic coefficients in Nm/rad over torque in Nm (Fig. 15)
    mesh : tooth-mesh torsion by sum and by integral, in rad over torque in Nm
    recoveries : of the parameters
    findings : a claim each
    """

    loops: tuple[BranchPair, ...]
    others: tuple[BranchPair, ...]
    sweeps: tuple[Sweep, ...]
    stiffness: tuple[Curve, ...]
    local: tuple[Curve, ...]
    mesh: tuple[Curve, ...]
    recoveries: tuple[Recovery, ...]
    findings: tuple[Finding, ...]
    warnings: tuple[str, ...]
    provenance: Provenance
    seconds: Mapping[str, float]

    @property
    def converged(self) -> bool:
        """Whether the posteriors of the recoveries converged."""
        return all(one.converged for one in self.recoveries)
