"""What a notebook shows of a record or an outcome that ends a cell: a line, not its arrays."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from hdprog.backtesting import Backtest
from hdprog.comparing import ComparisonOutcome
from hdprog.outcome import ExplainOutcome, Outcome
from tests.reporting.drives import not_converged, wearing


def test_a_record_is_shown_in_a_line() -> None:
    loop = wearing().tests[0].loop
    assert len(repr(loop)) < 200
    assert repr(loop).startswith(f"<Loop 't01.csv': {len(loop)} samples, torque ")


@pytest.mark.parametrize("kind", [Outcome, ExplainOutcome])
def test_an_outcome_is_shown_in_a_line(kind: type[Outcome]) -> None:
    sound, doubtful = (kind(made(), (), single=False) for made in (wearing, not_converged))
    assert repr(sound).startswith(f"<{kind.__name__} of t01, t02, ")
    assert ": converged; " in repr(sound)
    assert ": not converged; " in repr(doubtful)
    assert len(repr(sound)) < 200
    assert len(repr(sound.tests[0])) < 10_000


def test_other_outcomes_are_shown_in_a_line() -> None:
    stand_in: Any = SimpleNamespace(
        models=(SimpleNamespace(id="drive"), SimpleNamespace(id="cubic")),
        drives=(SimpleNamespace(drive_id="axis-2"),),
        converged=True,
    )
    compared, tested = ComparisonOutcome(stand_in), Backtest(stand_in)
    assert repr(compared).startswith("<ComparisonOutcome of drive, cubic: converged;")
    assert repr(tested).startswith("<Backtest of axis-2: converged;")
