"""Doubts on the runs that a drive would learn from stand among the warnings of its trend."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hdprog import outlook_of_drive
from hdprog.data.finished_runs import FinishedRuns
from hdprog.outlook_of_drive import OutlookUnderWay
from hdprog.results import FleetShare
from hdprog.trend.fitting import TrendUnderWay
from tests.reporting import drives


def test_two_drives_of_one_id(monkeypatch: pytest.MonkeyPatch) -> None:
    result = drives.wearing(drives.LOST_MOTION, count=2)
    assert result.trend is not None
    summary = replace(result.trend, warnings=("first",), fleet=FleetShare(("a",), {}))
    trend = SimpleNamespace(linearised=None, finished=lambda: None)
    monkeypatch.setattr(outlook_of_drive, "summarise", lambda *_: summary)
    monkeypatch.setattr(outlook_of_drive, "told_early", lambda *_: None)
    monkeypatch.setattr(outlook_of_drive, "begin_forecast", lambda *_, **__: tuple)
    others = FinishedRuns((), ("left out",), ("a doubt",))
    under_way = OutlookUnderWay(
        result.drive,
        drives.OPERATION,
        cast(TrendUnderWay, cast(Any, trend)),
        others,
        np.random.SeedSequence(0),
        None,
    )
    found = under_way.outlook(()).trend
    assert found.warnings == ("first", "a doubt")
    assert found.fleet is not None
    assert found.fleet.left_out == ("left out",)
