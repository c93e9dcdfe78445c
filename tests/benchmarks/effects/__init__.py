"""How well effects are traced on loops of the independent simulator; see `run`."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

from tests.independent.effects import EFFECTS

NOTHING, UNKNOWN = "nothing", "unknown"


@dataclass
class Outcome:
    """What became of one loop.

    Attributes
    ----------
    case, index : of the draw
    code : state of the code that it comes from
    status : "fitted", "not drawable" or "failed", with the reason
    effects : true ones by their names in the simulator
    kind, readings, noise_rad, sizes_rad, reached, decoys, rejected : see `loops.Drawn`
    names, term : effects found, and the coordinate of an empirical term
    alike : stated to do as well as the main one
    before, after : misfit a block, over the declared noise
    heldout_before, heldout_after, heldout_oracle : RMS error on left-out parts in rad, the oracle
        being the first step's refit with the true effect
    seconds, processor_seconds : of preparing and tracing, by the wall's clock and the processor's
    """

    case: str
    index: int
    code: str
    status: str = "fitted"
    reason: str = ""
    effects: list[str] = field(default_factory=list)
    kind: str = ""
    readings: int = 0
    noise_rad: float = 0.0
    sizes_rad: dict[str, float] = field(default_factory=dict)
    reached: dict[str, float] = field(default_factory=dict)
    decoys: list[str] = field(default_factory=list)
    rejected: int = 0
    names: list[str] = field(default_factory=list)
    term: str | None = None
    alike: list[str] = field(default_factory=list)
    before: float = 0.0
    after: float = 0.0
    heldout_before: float = 0.0
    heldout_after: float = 0.0
    heldout_oracle: float | None = None
    seconds: float = 0.0
    processor_seconds: float = 0.0

    @property
    def truth(self) -> set[str]:
        """Identifiers of the true effects."""
        return {EFFECTS[name].identifier for name in self.effects}

    @property
    def main(self) -> str:
        """First mechanism found; else "unknown" for an empirical term, or "nothing"."""
        return self.names[0] if self.names else NOTHING if self.term is None else UNKNOWN

    @property
    def extra(self) -> list[str]:
        """Names after the first that are not true."""
        return [name for name in self.names[1:] if name not in self.truth]

    @property
    def words(self) -> str:
        """One line."""
        head = f"{self.case}:{self.index}"
        if self.status != "fitted":
            return f"{head} {self.status}: {self.reason}"
        found = [*self.names, *([f"unknown over {self.term}"] if self.term else [])]
        truth = "+".join(self.effects) or NOTHING
        return f"{head} {truth} -> {'+'.join(found) or NOTHING} ({self.seconds:.1f} s)"


def read_outcomes(file: Path) -> tuple[list[Outcome], int]:
    """The loops of a file, the last line of each counting, and how many lines are not readable."""
    found: dict[tuple[str, int], Outcome] = {}
    unreadable = 0
    for line in file.read_text("utf-8").splitlines() if file.exists() else ():
        try:
            one = Outcome(**json.loads(line)) if line.strip() else None
        except (ValueError, TypeError):
            unreadable += 1
            continue
        if one is not None:
            found[one.case, one.index] = one
    return list(found.values()), unreadable
