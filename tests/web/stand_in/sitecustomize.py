"""Put on PYTHONPATH, this takes the place of the fits behind the upload page.

What it writes has the form of a run's results and is made of the drive folder alone, so that tests
of the service take no longer than the service itself. STAND_IN_SECONDS says how long a job takes
at least, and it lasts as long as the file STAND_IN_HOLD is there; a drive with "fails" in its id
ends in an error, one with "dies" ends its process.
"""

from __future__ import annotations

import csv
import json
import os
import time
import tomllib
from pathlib import Path

from hdprog.atomic import atomic_directory
from hdprog.errors import BadInputError
from hdprog.service import drive_run

LEVELS = ("q05", "q25", "q50", "q75", "q95")


def levels(*values: float | None) -> dict[str, float | None]:
    return dict(zip(LEVELS, values, strict=True))


def stand_in(order: drive_run.Order, say: drive_run.Say) -> None:
    content = tomllib.loads((order.folder / "drive.toml").read_text("utf-8"))
    name = content["drive"]["id"]
    with (order.folder / "tests.csv").open(encoding="utf-8") as file:
        rows = sorted(csv.DictReader(file), key=lambda row: float(row["service_hours"]))
    say("looking for effects", 0.1)
    ends = time.monotonic() + float(os.environ.get("STAND_IN_SECONDS", "0"))
    hold = os.environ.get("STAND_IN_HOLD")
    while time.monotonic() < ends or (hold and Path(hold).exists()):
        time.sleep(0.1)
        say("fitting", 0.5)
    if "dies" in name:
        os._exit(9)
    if "fails" in name:
        raise BadInputError("a drive that fails", "test", "another", "Look elsewhere.")
    summary = summary_of(content, rows)
    with atomic_directory(order.out) as aside:
        (aside / "summary.json").write_text(json.dumps(summary), "utf-8")
        (aside / "explain.json").write_text("{}", "utf-8")
        (aside / "report.html").write_text(page(f"Report of {name}"), "utf-8")
        for folder in ("tests", "posteriors", "pictures"):
            (aside / folder).mkdir()
        for row in rows:
            label = row["test_id"]
            (aside / "tests" / f"{label}.html").write_text(page(f"Report of {label}"), "utf-8")
            (aside / "posteriors" / f"{label}.nc").write_bytes(b"\x89HDF\r\n")
        picture(aside / "pictures")


def summary_of(content: dict, rows: list[dict[str, str]]) -> dict:
    now = float(rows[-1]["service_hours"])
    tests = [
        {
            "test_id": row["test_id"],
            "service_hours": float(row["service_hours"]),
            "converged": True,
            "parameters": {"K_F": {"mean": 1.0, "sd": 0.1}},
            "figures": {
                "lost_motion_arcmin": levels(0.4, 0.45, 0.5, 0.55, 0.6),
                "hysteresis_width_arcmin": levels(0.4, 0.45, 0.5, 0.55, 0.6),
            },
            "effects": ["creep"] if number else [],
            "rmse_rad": 1e-5,
            "noise_floor_rad": 9e-6,
            "warnings": [],
        }
        for number, row in enumerate(rows)
    ]
    limited = bool(content.get("limits"))
    remaining = levels(267.0, 320.0, 374.0, 460.0, None)
    forecast = {
        "now_hours": now,
        "already_crossed": False,
        "acceptable_risk": 0.05,
        "horizon_hours": 20000.0,
        "inspect_before_hours": now + 267.0,
        "probability_crossed_by_shutdown": None,
        "probability_crossed_by_horizon": 0.93,
        "remaining_hours": remaining,
        "crossing_probability": [[now, 0.0], [20000.0, 0.93]],
    }
    first = {"quantity": "first_limit", "limit": None, "direction": None, "at_torque_Nm": None}
    lost = {"quantity": "lost_motion_arcmin", "limit": 2.0, "direction": "above"}
    text = f"The stand-in saw {len(rows)} tests; inspect before {now + 267:.0f} h. Test again."
    return {
        "schema": "hdprog.summary/1",
        "hdprog_version": "0",
        "seed": 0,
        "drive": {"id": content["drive"]["id"]},
        "converged": True,
        "verdict": {
            "status": "plan" if limited else "present",
            "provisional": False,
            "label": "Plan an inspection" if limited else "Present condition only",
            "text": text,
        },
        "tests": tests,
        "trend": None,
        "forecast": (
            [{**lost, "at_torque_Nm": None, **forecast}, {**first, **forecast}] if limited else []
        ),
        "warnings": [],
        "provenance": {"quick": False},
    }


def page(title: str) -> str:
    return f"<!DOCTYPE html><html lang=en><title>{title}</title><h1>{title}</h1></html>"


def picture(folder: Path) -> None:
    svg = '<svg xmlns="http://www.w3.org/2000/svg" width="40" height="20"></svg>'
    words = {"alt": "A picture.", "shows": "", "action": "Nothing.", "width": 40, "height": 20}
    (folder / "0.svg").write_text(svg, "utf-8")
    (folder / "pictures.json").write_text(json.dumps([words]), "utf-8")


drive_run.run_here = stand_in
