"""Whether fits of repeated cycles agree within their intervals; see `run`."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

DRIVE, EXPLAINED = "drive model alone", "with what explain finds"
MODELS = (DRIVE, EXPLAINED)
WIDENED, WHITE = "widened", "white"
NOISES = (WIDENED, WHITE)
LEVELS = tuple((2 * step + 1) / 82 for step in range(41))
"""Levels of the stored quantiles: posteriors are compared through them."""


@dataclass
class Fit:
    """One posterior of one cycle.

    Attributes
    ----------
    group, cycle : name of the state and number of its repeat
    model, noise : out of `MODELS` and `NOISES`
    code : state of the code that it comes from
    status : "fitted", or "failed" with the reason
    converged, readings, blocks : of the fit
    correlated, ou_share, ou_length : whether noise was found correlated, the share of a block's
        variance that is, and its decay in parts of the record
    residual_rad : root mean square of what the best fit leaves
    effects : found beside the drive model, an empirical term as "unknown over …"
    mean, sd : by quantity; stiffnesses in logs, parameters in their unconstrained coordinates
    quantiles : by quantity, at `LEVELS`
    contraction : by quantity, 1 − variance over that of the prior
    direct : figures read off the record without a model, by quantity
    truth : by quantity, where it is known
    """

    group: str
    cycle: int
    model: str
    noise: str
    code: str
    status: str = "fitted"
    reason: str = ""
    converged: bool = False
    readings: int = 0
    blocks: int = 0
    correlated: bool = False
    ou_share: float = 0.0
    ou_length: float = 0.0
    residual_rad: float = 0.0
    effects: list[str] = field(default_factory=list)
    mean: dict[str, float] = field(default_factory=dict)
    sd: dict[str, float] = field(default_factory=dict)
    quantiles: dict[str, list[float]] = field(default_factory=dict)
    contraction: dict[str, float] = field(default_factory=dict)
    direct: dict[str, float] = field(default_factory=dict)
    truth: dict[str, float] = field(default_factory=dict)
    seconds: float = 0.0

    @property
    def words(self) -> str:
        """One line."""
        head = f"{self.group} {self.cycle}, {self.model}, {self.noise}"
        if self.status != "fitted":
            return f"{head} {self.status}: {self.reason}"
        found = f", {'; '.join(self.effects)}" if self.effects else ""
        return f"{head}: {'converged' if self.converged else 'not converged'}{found}"


def read_fits(file: Path) -> tuple[list[Fit], int]:
    """The fits of a file, the last line of each counting, and how many lines are not readable."""
    found: dict[tuple[str, int, str, str], Fit] = {}
    unreadable = 0
    for line in file.read_text("utf-8").splitlines() if file.exists() else ():
        try:
            one = Fit(**json.loads(line)) if line.strip() else None
        except (ValueError, TypeError):
            unreadable += 1
            continue
        if one is not None:
            found[one.group, one.cycle, one.model, one.noise] = one
    return list(found.values()), unreadable


def grouped(fits: Iterable[Fit]) -> dict[str, list[Fit]]:
    """Fitted repeats by their state, in the order of the repeats."""
    groups: dict[str, list[Fit]] = {}
    for one in sorted(fits, key=lambda one: one.cycle):
        if one.status == "fitted":
            groups.setdefault(one.group, []).append(one)
    return groups
