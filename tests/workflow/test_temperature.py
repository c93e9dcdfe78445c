"""A drive that is tested cold and hot in turn, from its files to report and JSON."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from hdprog import workflow
from hdprog.cli import app
from hdprog.cli.exits import ExitCode
from hdprog.trend import fitting
from tests.hasty import HASTY, SHORT
from tests.independent.drives import write_drive
from tests.independent.simulator import DriveParameters, true_figures

TEMPERATURES = (12.0, 34.0, 23.0, 24.0)
CHANGE = -0.15  # of the logarithm of friction in 10 K
WIDTH = "hysteresis_width_arcmin"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """Results of `hdprog run`, and the truth; the temperature of the last test is not told.

    Sampled shortly: temperature is found by the tests' modes.
    """
    folder = tmp_path_factory.mktemp("temperature")
    truth = write_drive(
        folder / "drive",
        np.random.default_rng(8),
        law="bilinear",
        horizon_hours=4000.0,
        temperatures=TEMPERATURES,
        friction_by_10_kelvin=CHANGE,
        samples=200,
    )
    table = folder / "drive" / "tests.csv"
    table.write_text(table.read_text("utf-8").replace(",24.0,", ",,"), "utf-8")
    arguments = ["run", str(folder / "drive"), "--out", str(folder / "out"), "--seed", "3"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(workflow, "QUICK", SHORT)
        patch.setattr(fitting, "JOINT_QUICK", HASTY)
        done = CliRunner().invoke(app, [*arguments, "--quick", "--no-explain", "--quiet"])
    assert done.exit_code == ExitCode.NOT_CONVERGED, done.output
    return folder / "out", truth


def test_the_change_by_temperature_is_found(made: tuple[Path, dict[str, Any]]) -> None:
    """Real loops of another simulator; the truth inside the central 90 %, of a fixed seed."""
    out, truth = made
    found = json.loads((out / "summary.json").read_text("utf-8"))["trend"]["temperature"]
    assert found["reference_C"] == pytest.approx(np.mean(TEMPERATURES[:3]))
    assert found["tests_without"] == 1
    last = DriveParameters(**truth["tests"][-1]["parameters_without_remounting"])
    values = last.as_dict()
    warm = DriveParameters(**values | {"mu": values["mu"] * np.exp(CHANGE)})
    expected = 100 * (true_figures(warm)[WIDTH] / true_figures(last)[WIDTH] - 1)
    levels = found["percent_per_10K"][WIDTH]
    assert levels["q05"] < expected < levels["q95"]
    assert levels["q95"] - levels["q05"] < 10


def test_the_report_says_it(made: tuple[Path, dict[str, Any]]) -> None:
    report = re.sub(r"\s+", " ", (made[0] / "report.html").read_text("utf-8"))
    assert "told at 23 °C, the mean of the tests; 1 test without a temperature" in report
    assert "What 10 K more change: lost motion by" in report
    assert "each by itself as it would be at 23 °C" in report
