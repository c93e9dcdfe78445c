"""The paper's numbers made again: reference values, verdicts that can fail, the command's files."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hdprog import reproducing
from hdprog.inference.sampling_plan import QUICK
from hdprog.reproduction import mesh, sensitivity, stiffness
from hdprog.reproduction.results import Finding
from hdprog.reproduction.table2 import INITIAL, POST_TEST, steady_loop
from tests.cli.conftest import Invoke, invoke  # noqa: F401 - a fixture
from tests.physics import table2
from tests.reporting.page import Page

SHORT = replace(
    QUICK, warm_up_steps=(60, 30, 30), first_steps=60, most_steps=200, further_steps=0, refits=0
)


def test_table_2_is_that_of_the_reference_values() -> None:
    assert table2.INITIAL == INITIAL
    assert table2.POST_TEST == POST_TEST


@pytest.mark.parametrize(
    ("parameters", "at_zero", "at_50", "at_100"),
    [
        (INITIAL, 6.106267e-05, (1.089414e-03, 1.206092e-03), 2.235409e-03),
        (POST_TEST, 4.348585e-05, (2.385559e-03, 2.469014e-03), 4.000364e-03),
    ],
)
def test_steady_loops_meet_the_reference_values(
    parameters: dict[str, float], at_zero: float, at_50: tuple[float, float], at_100: float
) -> None:
    loop = steady_loop(parameters, "x", points=401)
    middle, half = 200, 300
    assert loop.torque[[middle, half, -1]].tolist() == [0.0, 50.0, 100.0]
    assert loop.rising[middle] == pytest.approx(-at_zero, rel=1e-6)
    assert loop.falling[middle] == pytest.approx(at_zero, rel=1e-6)
    assert (loop.rising[half], loop.falling[half]) == pytest.approx(at_50, rel=1e-6)
    assert loop.rising[-1] == pytest.approx(at_100, rel=1e-6)
    np.testing.assert_allclose(loop.rising, -loop.falling[::-1], atol=1e-15)


def test_widths_are_those_of_the_physics() -> None:
    widths = [sensitivity.width_at_zero(steady_loop(p, "x")) for p in (INITIAL, POST_TEST)]
    assert widths == pytest.approx([0.420, 0.299], abs=5e-4)


def test_the_sum_and_the_integral_differ_as_known() -> None:
    numbers = mesh.finding().numbers
    assert numbers["difference_rad"] == pytest.approx(9.1e-5, abs=5e-7)
    integral, printed, finer = mesh.curves()
    assert integral.y[-1] == pytest.approx(numbers["integral_rad"])
    assert printed.y[-1] == pytest.approx(numbers["sum_rad"])
    assert abs(finer.y[-1] - integral.y[-1]) < 0.2 * abs(printed.y[-1] - integral.y[-1])


def test_stiffness_beyond_the_threshold_is_constant_and_known() -> None:
    found = stiffness.fits()
    K_T = POST_TEST["a"] * 30 + POST_TEST["b"]
    expected = 1 / (1 / POST_TEST["K_F"] + (1 / 3) / POST_TEST["K_W"] + 1 / K_T)
    np.testing.assert_allclose(found.local[found.torque > 30], expected, rtol=1e-9)
    # The cubic and the pieces give back what they were fitted to: residuals without a trend.
    assert abs(np.mean(found.piecewise - found.angle)) < 3e-5
    slope = np.gradient(found.torque, found.cubic)
    np.testing.assert_allclose(slope[1:-1], found.local_cubic[1:-1], rtol=1e-2)


def test_the_published_errors_do_not_come_out() -> None:
    """26.3 % and 24.8 %: none of the conventions tried gives either; reported as it is."""
    errors = stiffness.relative_errors()
    assert min(errors.values()) > 0.4
    [finding] = [one for one in stiffness.findings() if "26.3" in one.claim]
    assert finding.outcome == "disagrees"


def test_what_is_swept_is_named_with_its_unit() -> None:
    """It was "From 6.898e+04 to 1.281e+05", of what was not said."""
    said = [one.came_out for one in sensitivity.findings(sensitivity.sweeps())[2:]]
    begins = ("μ = 0.0532 to 0.0988", "K_W = 69 000 to 128 000 Nm/rad", "K_F = 54 700 to 102 000")
    for text, begin in zip(said, begins, strict=True):
        assert text.startswith(f"From {begin}")


def test_verdicts_can_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    """With preloads in the wrong order the claim of Fig. 12 is found wrong."""
    right = {one.claim: one for one in sensitivity.findings(sensitivity.sweeps())}
    assert {one.outcome for one in right.values()} == {"agrees"}
    monkeypatch.setattr(sensitivity, "_PRELOADS", (1.0, 0.5, 0.0))
    wrong: list[Finding] = list(sensitivity.findings(sensitivity.sweeps()))
    assert [one.outcome for one in wrong] == ["disagrees", "agrees", "agrees", "agrees", "agrees"]


@pytest.mark.skipif(
    sys.platform != "linux", reason="the shorter plan reaches forked worker processes only"
)
def test_the_command_writes_its_claims(
    invoke: Invoke,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(reproducing, "QUICK", SHORT)
    shown = invoke("reproduce-paper", "--quick", "--out", "paper")
    assert shown.exit_code == 4, shown.stderr  # a plan this short converges nowhere
    assert "Fig. 15" in shown.stdout
    assert "26.3 %" in shown.stdout.replace("\u202f", " ")
    found = json.loads(Path("paper/reproduction.json").read_text("utf-8"))
    assert found["schema"] == "hdprog.reproduce-paper/1"
    outcomes = [one["outcome"] for one in found["findings"]]
    # The paper's measurements, and the two posteriors that did not converge: nothing against it.
    assert outcomes.count("cannot be checked") == 3
    assert {one["figure"] for one in found["findings"]} == {
        *(f"Fig. {number}" for number in range(10, 16)),
        "eq. 19",
        "Table 2",
    }
    page = Page(Path("paper/report.html").read_text("utf-8"))
    assert page.faults == []
    assert len(page.pictures) == 7
    assert "provisional" in page.text.lower()
    assert len(Path("paper/report.html").read_bytes()) < 2_000_000
