"""A store with thousands of drives, filled in bulk."""

from __future__ import annotations

import random
from pathlib import Path

from sqlalchemy import insert

from hdprog.store.store import open_store
from hdprog.store.tables import AnalysisRow, DriveRow, FitRow, ForecastRow, TestRow
from hdprog.store.tables.base import now

_STATUS = ("act", "plan", "plan", "present", "good", "good", "good")
_RANK = {"act": 0, "plan": 2, "present": 3, "good": 4}


def fill(data: Path, drives: int, tests: int) -> None:
    """Make drives with tests, fits and forecasts of invented numbers."""
    rng = random.Random(0)
    with open_store(data) as store, store.writing() as session:
        rows: dict[str, list[dict]] = {name: [] for name in ("d", "t", "a", "f", "w")}
        for number in range(1, drives + 1):
            _one(rng, rows, number, tests)
        for table, name in (
            (DriveRow, "d"),
            (TestRow, "t"),
            (AnalysisRow, "a"),
            (FitRow, "f"),
            (ForecastRow, "w"),
        ):
            session.execute(insert(table), rows[name])


def _one(rng: random.Random, rows: dict[str, list[dict]], number: int, tests: int) -> None:
    status, analysis = rng.choice(_STATUS), f"00000000-0000-0000-0000-{number:012d}"
    left = rng.uniform(10, 9000)
    remaining = {
        "q05": 0.7 * left,
        "q25": 0.9 * left,
        "q50": left,
        "q75": 1.2 * left,
        "q95": 1.6 * left,
    }
    hours = [100.0 * index for index in range(tests)]
    rows["d"].append(
        {
            "id": number,
            "name": f"cell{number // 6}-axis{number % 6 + 1}",
            "settings": {"drive": {"id": f"cell{number // 6}-axis{number % 6 + 1}"}},
            "created_at": now(),
            "created_by": "benchmark",
            "status": status,
            "provisional": False,
            "label": status,
            "sentence": "The first limit (most likely lost motion above 2 arcmin) is forecast to "
            f"be passed between {left:.0f} and {1.6 * left:.0f} h (90 %).",
            "rank": _RANK[status],
            "rank_hours": left,
            "remaining": {**remaining, "inspect_before": left},
            "sparkline": {
                "name": "lost motion",
                "unit": "arcmin",
                "points": [[at, 0.4 + at / 2000] for at in hours],
                "limit": 2.0,
            },
            "warnings": rng.randrange(3),
            "tests": tests,
            "last_test_at": now(),
            "last_test_hours": hours[-1],
            "analysis_id": analysis,
        }
    )
    rows["a"].append(
        {
            "id": analysis,
            "drive_id": number,
            "created_at": now(),
            "hdprog_version": "0",
            "seed": 0,
            "quick": False,
            "converged": True,
            "status": status,
            "verdict": "An invented verdict.",
            "now_hours": hours[-1],
        }
    )
    rows["w"].append(
        {
            "analysis_id": analysis,
            "position": 0,
            "quantity": "first_limit",
            "now_hours": hours[-1],
            "already_crossed": False,
            "inspect_before_hours": hours[-1] + left,
            "probability_crossed_by_horizon": 0.9,
            "remaining_hours": remaining,
        }
    )
    levels = {"q05": 0.4, "q25": 0.45, "q50": 0.5, "q75": 0.55, "q95": 0.6}
    figures = {f"figure_{index}": levels for index in range(8)} | {"lost_motion_arcmin": levels}
    for index, at in enumerate(hours):
        test = (number - 1) * tests + index + 1
        rows["t"].append(
            {
                "id": test,
                "uid": f"t{test:06d}",
                "drive_id": number,
                "label": f"t{index:02d}",
                "state": "accepted",
                "file_name": "loop.csv",
                "sha256": f"{test:064x}",
                "size": 20_000,
                "service_hours": at,
                "quality": {"samples": 900, "lines": ["usable: 900 samples"], "warnings": []},
                "uploaded_at": now(),
                "uploaded_by": "benchmark",
            }
        )
        rows["f"].append(
            {
                "analysis_id": analysis,
                "test_id": test,
                "converged": True,
                "parameters": dict.fromkeys(("K_F", "K_W", "a", "b"), levels),
                "figures": figures,
                "warnings": [],
            }
        )
