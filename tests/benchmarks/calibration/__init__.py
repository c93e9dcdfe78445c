"""Is the posterior of a loop what it says? Simulation-based calibration.

Parameters are drawn from the prior, a loop is made from them, the loop is fitted as a user's is,
and the truth is ranked among the draws. Over many loops every rank must be as frequent as any
other, in each parameter, each figure of merit, and the log-likelihood (Talts et al.,
arXiv:1804.06788).

`run` fits the loops and writes the summary; `loops` draws them; `ranks` finds where the truth lies;
`ecdf_band` says whether ranks are uniform; `faults` plants faults that must be noticed; `summary`
and `picture` tell.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Outcome:
    """What became of one loop.

    Attributes
    ----------
    index, code : number of the loop, and state of the code that it comes from
    status, reason : "fitted" or "failed", and why
    kind, one_sided, readings, noise_rad, largest_torque, T_i : of the loop, with its true T_i in Nm
    ranks : of the truth among independent draws, in the order of `ranks.QUANTITIES`
    shares : of the posterior below the truth, likewise
    faults : fault → ranks of the truth among draws of the faulty posterior, likewise
    efficiency : fault → effective share of the draws, where they were given weights
    converged, correlated, spikes : what the fit said: noise with memory, readings set aside
    ess : least effective draws of a coordinate, bulk or tail
    rhat, autocorrelation_time : largest ones
    slip_converged, slip_correlated : of the refit with a fixed slip, if there was one
    processor_seconds : of the fit, of ranking with the weighted faults, and of the refit
    """

    index: int
    code: str
    status: str = "fitted"
    reason: str = ""
    kind: str = ""
    one_sided: bool = False
    readings: int = 0
    noise_rad: float = 0.0
    largest_torque: float = 0.0
    T_i: float = 0.0
    ranks: list[int] = field(default_factory=list)
    shares: list[float] = field(default_factory=list)
    faults: dict[str, list[int]] = field(default_factory=dict)
    efficiency: dict[str, float] = field(default_factory=dict)
    converged: bool = True
    correlated: bool = False
    spikes: int = 0
    ess: float = 0.0
    rhat: float = 0.0
    autocorrelation_time: float = 0.0
    slip_converged: bool | None = None
    slip_correlated: bool | None = None
    processor_seconds: dict[str, float] = field(default_factory=dict)

    @property
    def words(self) -> str:
        """One line."""
        if self.status != "fitted":
            return f"{self.index} {self.kind} {self.status}: {self.reason}"
        remarks = ["" if self.converged else "not converged", "correlated" * self.correlated]
        seconds = ", ".join(f"{k} {v:.1f} s" for k, v in self.processor_seconds.items())
        return f"{self.index} {self.kind}: {', '.join([*filter(None, remarks), seconds])}"


def read_outcomes(file: Path) -> tuple[list[Outcome], int]:
    """The loops of a file, the last line of each counting, and how many lines are not readable."""
    found: dict[int, Outcome] = {}
    unreadable = 0
    for line in file.read_text("utf-8").splitlines() if file.exists() else ():
        try:
            one = Outcome(**json.loads(line)) if line.strip() else None
        except (ValueError, TypeError):
            unreadable += 1
            continue
        if one is not None:
            found[one.index] = one
    return sorted(found.values(), key=lambda one: one.index), unreadable
