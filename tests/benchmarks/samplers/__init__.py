"""How quickly do samplers draw from the posterior of a loop?

The sampler of hdprog and those of other packages get the same ten posteriors, and each is asked for
1 000 effective draws of the worst coordinate. Peers get the log density compiled, with its gradient
and in the better coordinates.

`run` measures and writes the summary; `posteriors` draws the loops and prepares them; `log_density`
is the log posterior in JAX and `equality` checks it against hdprog's; `own`, `nuts`, `ensemble` and
`nested` run the samplers; `measuring` has the clock and counts effective draws; `fused` compares
the likelihood with a loop in machine code; `summary` and `picture` tell.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Outcome:
    """What one sampler did on one posterior.

    Attributes
    ----------
    index, sampler, code : number of the posterior, who drew, and state of the code
    status, reason : "measured" or "failed", and why
    kind, blocks, stretches : of the loop
    reached : whether there were 1 000 effective draws within the bound
    ess_bulk, ess_tail, rhat : least and largest of the nine coordinates; R-hat 0 where there are no
        chains
    chains, draws : chains, and draws in each, that these are of
    processor_seconds, wall_seconds : by part: "compile", "run"; "preparation" is common to all
    evaluations, gradients : log densities without and with gradient, warm-up included
    preparation_evaluations : model curves that preparing the record took
    mean, sd : (9,) of the unconstrained coordinates
    converged : what hdprog says of its own draws
    """

    index: int
    sampler: str
    code: str
    status: str = "measured"
    reason: str = ""
    kind: str = ""
    blocks: int = 0
    stretches: int = 0
    reached: bool = False
    ess_bulk: float = 0.0
    ess_tail: float = 0.0
    rhat: float = 0.0
    chains: int = 0
    draws: int = 0
    processor_seconds: dict[str, float] = field(default_factory=dict)
    wall_seconds: dict[str, float] = field(default_factory=dict)
    evaluations: int = 0
    gradients: int = 0
    preparation_evaluations: int = 0
    mean: list[float] = field(default_factory=list)
    sd: list[float] = field(default_factory=list)
    converged: bool | None = None

    @property
    def ess(self) -> float:
        """Effective draws of the worst coordinate, bulk or tail."""
        return min(self.ess_bulk, self.ess_tail)

    @property
    def words(self) -> str:
        """One line."""
        if self.status != "measured":
            return f"{self.index} {self.sampler} {self.status}: {self.reason}"
        seconds = ", ".join(f"{part} {s:.2f} s" for part, s in self.processor_seconds.items())
        short = "" if self.reached else " (bound reached)"
        return (
            f"{self.index} {self.kind}, {self.sampler}: {self.ess:.0f} effective draws{short}, "
            f"R-hat {self.rhat:.3f}, {self.evaluations} + {self.gradients} evaluations, {seconds}"
        )


def read_outcomes(file: Path) -> list[Outcome]:
    """The lines of a file, the last of each posterior and sampler counting, broken ones none."""
    found: dict[tuple[int, str], Outcome] = {}
    for line in file.read_text("utf-8").splitlines() if file.exists() else ():
        try:
            one = Outcome(**json.loads(line)) if line.strip() else None
        except (ValueError, TypeError):  # a run was broken off while it wrote
            continue
        if one is not None:
            found[one.index, one.sampler] = one
    return sorted(found.values(), key=lambda one: one.index)
