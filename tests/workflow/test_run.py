"""A drive folder from its files to the written forecast."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import arviz
import numpy as np
import pytest

import hdprog
from hdprog import workflow
from hdprog.errors import BadInputError, UsageError
from hdprog.shipped import shipped
from hdprog.trend import fitting
from hdprog.workflow import Outcome
from tests.drive_folders import subset_of
from tests.hasty import HASTY, SHORT
from tests.reporting.page import Page

DRIVE = Path(str(shipped("datasets"))) / "wearing-csf-25-80"
LIMITS = [
    "lost_motion_arcmin",
    "secant_stiffness_Nm_per_rad",
    "hysteresis_width_arcmin",
]


def subset(folder: Path, tests: Sequence[str]) -> Path:
    """Copy a few tests of the shipped drive."""
    return subset_of(DRIVE, folder, tests)


def edit(folder: Path, old: str, new: str) -> None:
    text = (folder / "drive.toml").read_text("utf-8")
    assert old in text
    (folder / "drive.toml").write_text(text.replace(old, new), "utf-8")


@pytest.fixture(name="outcome", scope="module")
def outcome_fixture(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    folder = subset(tmp_path_factory.mktemp("run") / "drive", ["t01", "t05", "t10"])
    edit(folder, "horizon_hours = 20000.0", "horizon_hours = 2000.0")
    return hdprog.run(folder, quick=True, seed=1, loads=(1.25, 0.8, 1.0))


@pytest.fixture(name="written", scope="module")
def written_fixture(outcome: Outcome, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run") / "out"
    outcome.write(folder, command="hdprog run drive")
    return folder


@pytest.fixture(name="summary", scope="module")
def summary_fixture(written: Path) -> dict[str, Any]:
    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    return json.loads((written / "summary.json").read_text("utf-8"), parse_constant=refuse)


def test_every_test_is_there_by_service_hours(summary: dict[str, Any], outcome: Outcome) -> None:
    assert summary["schema"] == "hdprog.summary/1"
    assert summary["seed"] == 1
    tests = summary["tests"]
    assert [test["test_id"] for test in tests] == ["t01", "t05", "t10"]
    assert [test["service_hours"] for test in tests] == [0, 411.7, 900]
    assert all(test["converged"] for test in tests)
    assert outcome.converged
    assert summary["converged"] is True
    assert summary["warnings"] == []


def test_the_figures_of_every_test_are_about_the_truth(summary: dict[str, Any]) -> None:
    truth = json.loads((DRIVE / "truth.json").read_text("utf-8"))
    mounted = {test["test_id"]: test["mounted"] for test in truth["tests"]}
    inside = count = 0
    for test in summary["tests"]:
        for name, parameter in test["parameters"].items():
            inside += parameter["q05"] < mounted[test["test_id"]][name] < parameter["q95"]
            count += 1
    # The parameters of a test go together: as if ten were independent. Under seven of ten nine
    # times in ten: 1.3 % of all seeds.
    assert inside >= 0.65 * count
    width = [test["figures"]["hysteresis_width_arcmin"]["q50"] for test in summary["tests"]]
    assert width[2] < width[0]


def test_the_trend_runs_from_the_first_test_to_the_horizon(summary: dict[str, Any]) -> None:
    trend = summary["trend"]
    assert trend["model"]
    assert set(trend["figures"]) >= {"lost_motion_arcmin", "hysteresis_width_arcmin"}
    for figure in trend["figures"].values():
        assert figure["hours"][0] == 0
        assert figure["hours"][-1] == 2_000
        bands = np.array([figure[f"q{level}"] for level in ("05", "25", "50", "75", "95")])
        assert bands.shape[1] == len(figure["hours"])
        assert (np.diff(bands, axis=0) >= 0).all()
    assert any("3 tests" in warning for warning in trend["warnings"])


def test_limits_are_forecast_in_their_order(summary: dict[str, Any]) -> None:
    forecasts = summary["forecast"]
    assert [forecast["quantity"] for forecast in forecasts] == [*LIMITS, "first_limit"]
    assert [forecast["limit"] for forecast in forecasts] == [2.0, 13_000.0, 0.3, None]
    directions = [forecast["direction"] for forecast in forecasts]
    assert directions == ["above", "below", "below", None]
    assert [forecast["at_torque_Nm"] for forecast in forecasts] == [None, 14.0, None, None]


def test_the_crossing_probability_never_falls(summary: dict[str, Any]) -> None:
    for forecast in summary["forecast"]:
        hours, probability = np.array(forecast["crossing_probability"]).T
        assert (hours[0], hours[-1]) == (forecast["now_hours"], 2_000)
        assert (np.diff(hours) > 0).all()
        assert (np.diff(probability) >= 0).all()
        assert probability.min() >= 0
        assert probability.max() <= 1
        assert forecast["now_hours"] == 900
        assert probability[-1] == forecast["probability_crossed_by_horizon"]
        by_shutdown = np.interp(1500, hours, probability)
        assert forecast["probability_crossed_by_shutdown"] == pytest.approx(by_shutdown, abs=1e-9)


def test_quantiles_are_those_of_the_crossing_probability(summary: dict[str, Any]) -> None:
    past = 0
    for forecast in summary["forecast"]:
        hours, probability = np.array(forecast["crossing_probability"]).T
        for name, remaining in forecast["remaining_hours"].items():
            level = int(name[1:]) / 100
            if forecast["probability_crossed_by_horizon"] < level:
                assert remaining is None, name
                past += 1
            else:
                assert np.interp(900 + remaining, hours, probability) == pytest.approx(level)
        before = forecast["inspect_before_hours"]
        assert before == pytest.approx(900 + forecast["remaining_hours"]["q05"])
    assert past > 0  # else nothing was tried: choose another seed


def test_the_first_limit_comes_before_each(summary: dict[str, Any]) -> None:
    *each, first = summary["forecast"]
    probability = np.array(first["crossing_probability"])[:, 1]
    for forecast in each:
        # Each leaves out the paths that are past its own limit now: rounding's worth of paths.
        alone = np.array(forecast["crossing_probability"])[:, 1]
        assert (probability >= alone - 0.005).all()


def test_loads_to_come_move_the_crossings(summary: dict[str, Any], written: Path) -> None:
    forecast = summary["forecast"]
    more, less, same = summary["load_scenarios"]
    assert [one["load"] for one in (more, less, same)] == [1.25, 0.8, 1.0]
    assert same["forecast"] == forecast
    for now, light, heavy in zip(forecast, less["forecast"], more["forecast"], strict=True):
        risks = [one["probability_crossed_by_horizon"] for one in (light, now, heavy)]
        assert risks == sorted(risks)
        assert light["now_hours"] == now["now_hours"]
    assert less["forecast"][-1]["inspect_before_hours"] > forecast[-1]["inspect_before_hours"]
    text = Page((written / "report.html").read_text("utf-8")).text
    assert "80 % of the mean so far" in text.replace("\u2009", " ")
    assert "the cube of the torque to come" in text


@pytest.mark.parametrize("load", [0.0, -1.0, 80.0, float("nan")])
def test_a_load_that_cannot_be_is_refused_before_any_fit(load: float) -> None:
    with pytest.raises(UsageError, match="torque to come over torque so far"):
        hdprog.run(DRIVE, loads=(load,))


def test_the_written_folder_is_whole(written: Path, outcome: Outcome) -> None:
    names = [p.relative_to(written).as_posix() for p in written.rglob("*") if p.is_file()]
    posteriors = [f"posteriors/{test}.nc" for test in ("t01", "t05", "t10")]
    assert sorted(names) == sorted(["explain.json", "summary.json", "report.html", *posteriors])
    for test in outcome.tests:
        idata = arviz.from_netcdf(str(written / "posteriors" / f"{test.test_id}.nc"))
        assert idata.posterior.attrs["source_sha256"] == test.loop.sha256
        assert float(idata.posterior["mu"].mean()) == test.parameters["mu"].mean
    text = (written / "report.html").read_text("utf-8")
    assert len(text) < 2e6
    page = Page(text)
    assert page.faults == []
    assert "inspect before" in page.text
    verdict = outcome.verdict.replace("\u202f", " ")
    assert verdict.split(";")[0] in page.text


def test_the_number_of_workers_changes_no_byte_of_what_is_written(
    outcome: Outcome, tmp_path: Path
) -> None:
    for workers in (1, 2):
        outcome.write(tmp_path / str(workers), "hdprog run", workers)
    files = [path for path in (tmp_path / "1").rglob("*") if path.is_file()]
    assert len(files) == 2 + len(outcome.tests) + (outcome.result.explanation is not None)
    for path in files:
        other = tmp_path / "2" / path.relative_to(tmp_path / "1")
        assert path.read_bytes() == other.read_bytes(), path.name


def test_draws_are_asked_for_by_test(outcome: Outcome) -> None:
    with pytest.raises(UsageError, match="idata_of"):
        _ = outcome.idata
    with pytest.raises(UsageError, match=r"t99.*t01, t05, t10"):
        outcome.idata_of("t99")


@pytest.mark.skipif(
    sys.platform != "linux", reason="the shorter plan reaches forked worker processes only"
)
def test_workers_change_nothing_and_two_tests_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workflow, "QUICK", SHORT)
    monkeypatch.setattr(fitting, "JOINT_QUICK", replace(HASTY, parts=2))
    folder = subset(tmp_path / "drive", ["t05", "t10"])
    steps: list[tuple[str, int, int]] = []
    summaries = []
    for workers in (1, 2):
        outcome = hdprog.run(
            folder, quick=True, workers=workers, progress=lambda *step: steps.append(step)
        )
        summaries.append(outcome.summary() | {"provenance": None})
    assert summaries[0] == summaries[1]
    assert "With 2 tests the pace of wear still leans on the prior" in outcome.verdict
    once = [("effects", 0, 1), ("effects", 1, 1), ("fits", 1, 2), ("fits", 2, 2)]
    once += [("trend", done, 3) for done in range(4)]  # two explanations, and the trend
    assert steps == 2 * once
    # A plan this short converges nowhere, and the whole says so.
    assert not outcome.converged
    assert outcome.verdict.startswith("Not converged: the fits of tests t05 and t10")
    assert summaries[0]["converged"] is False
    assert summaries[0]["verdict"]["label"].endswith("provisional")
    outcome.write(tmp_path / "out")
    page = Page((tmp_path / "out" / "report.html").read_text("utf-8")).text
    assert "Not converged: the fits of tests t05 and t10" in page


def test_one_test_of_a_drive_past_its_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workflow, "QUICK", SHORT)  # far past the limit: a few draws show it
    monkeypatch.setattr(fitting, "JOINT_QUICK", HASTY)
    folder = subset(tmp_path / "drive", ["t10"])
    edit(folder, "above = 2.0", "above = 0.5")
    outcome = hdprog.run(folder, quick=True, workers=1)
    lost_motion, _, _, first = outcome.forecasts
    for forecast in (lost_motion, first):
        assert forecast.already_crossed
        assert forecast.inspect_before_hours == forecast.now_hours == 900
        assert forecast.remaining_hours[0.5] == 0
        assert forecast.crossing_probability[0, 1] > 0.5
    assert "Lost motion is past its limit: above 0.5" in outcome.verdict
    assert "Inspect now." in outcome.verdict
    assert "There is one test only" in outcome.verdict
    outcome.write(tmp_path / "out")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))
    assert summary["verdict"]["status"] == "act"
    assert summary["forecast"][0]["already_crossed"] is True
    page = Page((tmp_path / "out" / "report.html").read_text("utf-8")).text
    assert "Lost motion is past its limit" in page


def test_a_folder_that_cannot_be_used_is_refused_before_any_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_fit(*_: object, **__: object) -> None:
        raise AssertionError("a fit was begun")

    monkeypatch.setattr(workflow, "trace_tests", no_fit)
    folder = subset(tmp_path / "drive", ["t05", "t10"])
    loop = folder / "loops" / "t10.csv"
    text = loop.read_text("utf-8")
    loop.write_text(text.replace("torque_Nm", "torque"), "utf-8")
    with pytest.raises(BadInputError, match=r"t10\.csv"):
        hdprog.run(folder, quick=True)
    loop.write_text(text, "utf-8")
    edit(folder, 'file = "csf-25-80"', 'file = "csf-25-81"')
    with pytest.raises(BadInputError, match="no prior called 'csf-25-81'"):
        hdprog.run(folder, quick=True)


def test_without_a_rated_torque_all_tests_and_forecasts_refer_to_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workflow, "QUICK", SHORT)
    monkeypatch.setattr(fitting, "JOINT_QUICK", HASTY)
    folder = subset(tmp_path / "drive", ["t05", "t10"])
    edit(folder, "rated_torque_Nm = 63.0\n", "")
    limits = (folder / "drive.toml").read_text("utf-8").partition("[[limits]]")[0]
    width = '[[limits]]\nquantity = "hysteresis_width_arcmin"\nbelow = 0.3\n'
    (folder / "drive.toml").write_text(limits + width, "utf-8")
    later = folder / "loops" / "t10.csv"
    header, *rows = later.read_text("utf-8").splitlines()
    cells = [row.split(",") for row in rows]  # time, torque and angle
    smaller = [f"{time},{0.75 * float(torque):.2f},{angle}" for time, torque, angle in cells]
    later.write_text("\n".join([header, *smaller]) + "\n", "utf-8")
    outcome = hdprog.run(folder, quick=True, explain=False, workers=1)
    largest = [float(np.abs(fit.loop.torque).max()) for fit in outcome.posteriors]
    assert largest[1] < 0.8 * largest[0]
    torque = float(f"{largest[1]:.3g}")
    assert [fit.operation.reference_torque for fit in outcome.posteriors] == [torque, torque]
    summary = outcome.summary()
    assert summary["drive"]["rated_torque_Nm"] is None
    (said,) = [text for text in summary["warnings"] if "rated torque" in text]
    assert f"refer to {torque:g} Nm, the smallest of the tests' largest torques" in said
    assert f"test t10; the others reach up to {largest[0]:.3g} Nm" in said
    first_test, last_test = summary["tests"]
    assert first_test["figures"].keys() == last_test["figures"].keys()
    key = "hysteresis_width_arcmin"
    # The width that each test tells the trend, and with it the forecast, is that of its figures.
    assert outcome.trend is not None
    own = [test.figures[key][0.5] for test in outcome.tests]
    np.testing.assert_allclose(outcome.trend.figures[key].test_quantiles[2], own, rtol=0.05)


def test_a_horizon_behind_the_last_test_is_refused_before_any_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_fit(*_: object, **__: object) -> None:
        raise AssertionError("a fit was begun")

    monkeypatch.setattr(workflow, "trace_tests", no_fit)
    folder = subset(tmp_path / "drive", ["t10"])
    edit(folder, "horizon_hours = 20000.0", "horizon_hours = 800.0")
    with pytest.raises(BadInputError, match="horizon"):
        hdprog.run(folder, quick=True)


def test_a_new_drive_learns_from_the_fleet(
    outcome: Outcome, written: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workflow, "QUICK", SHORT)  # the pace is what is looked at
    monkeypatch.setattr(fitting, "JOINT_QUICK", HASTY)
    # The finished drive has worn at a known pace; the fleet shall hold four like it.
    fleet = tmp_path / "fleet"
    for name in ("one", "two", "three", "four"):
        text = (written / "summary.json").read_text("utf-8")
        content = json.loads(text) | {"drive": {"id": name}}
        (fleet / name).mkdir(parents=True)
        (fleet / name / "summary.json").write_text(json.dumps(content), "utf-8")
    (fleet / "notes").mkdir()
    (fleet / "notes" / "summary.json").write_text('{"schema": "another"}', "utf-8")
    folder = subset(tmp_path / "drive", ["t02"])
    alone = hdprog.run(folder, quick=True, explain=False, workers=1)
    taught = hdprog.run(folder, quick=True, explain=False, workers=1, fleet=fleet)
    trend = taught.summary()["trend"]
    assert trend["fleet"]["drives"] == ["four", "one", "three", "two"]
    assert ["another" in said for said in trend["fleet"]["left_out"]] == [True]
    pace = trend["fleet"]["hyperparameters"]["wear_rate"]

    def breadth(levels: dict[str, float]) -> float:
        return float(np.log(levels["q95"] / levels["q05"]))

    assert breadth(pace["fleet"]) < 0.8 * breadth(pace["any_drive"])
    known = outcome.summary()["trend"]["hyperparameters"]["wear_rate"]["q50"]
    assert pace["fleet"]["q05"] < known < pace["fleet"]["q95"]
    assert alone.summary()["trend"]["fleet"] is None
    assert "comes from the fleet, not from the drive" in taught.verdict
    assert "comes from the prior, not from the drive" in alone.verdict
    taught.write(tmp_path / "out")
    page = Page((tmp_path / "out" / "report.html").read_text("utf-8")).text
    assert "Learnt from the finished runs of 4 other drives: four, one, three and two" in page
    steady = trend["fleet"]["steady_pace"]
    assert steady["told_by"] == 4
    assert 0.0 < steady["chance_by_fleet"] < 1.0
    assert "A pace is steady where wear follows a power of the hours" in page
    # What a drive tells others is what its own tests say: the fleet is not passed on.
    says = taught.summary()["trend"]["says"]
    own = alone.summary()["trend"]["says"]
    assert says["wear_prior"] == own["wear_prior"]
    rate = says["deviates"].index("wear_rate")
    assert says["precision"][rate][rate] < own["precision"][rate][rate] + 2.0


def test_a_fleet_without_a_finished_run_is_refused(written: Path, tmp_path: Path) -> None:
    folder = subset(tmp_path / "drive", ["t10"])
    with pytest.raises(BadInputError, match="no folder"):
        hdprog.run(folder, quick=True, fleet=tmp_path / "nowhere")
    with pytest.raises(BadInputError, match="no finished run of another drive"):
        hdprog.run(folder, quick=True, fleet=written)  # its own run
    content = json.loads((written / "summary.json").read_text("utf-8"))
    content["drive"]["id"] = "other"
    content["trend"]["says"]["wear_prior"] = "of another year"
    (tmp_path / "fleet").mkdir()
    (tmp_path / "fleet" / "summary.json").write_text(json.dumps(content), "utf-8")
    with pytest.raises(BadInputError, match="another wear prior"):
        hdprog.run(folder, quick=True, fleet=tmp_path / "fleet")
