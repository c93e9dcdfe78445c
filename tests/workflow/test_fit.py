"""One loop from the file to the written result."""

from __future__ import annotations

import errno
import gc
import hashlib
import json
import os
import sys
from pathlib import Path
from typing import Any

import arviz
import numpy as np
import pytest
import xarray

import hdprog
from hdprog import workflow
from hdprog.errors import BadInputError, UsageError
from hdprog.physics.parameters import BY_NAME, NAMES
from hdprog.shipped import shipped
from hdprog.workflow import Outcome
from tests.hasty import SHORT
from tests.reporting.page import Page

DRIVE = Path(str(shipped("datasets"))) / "wearing-csf-25-80"
LOOP = DRIVE / "loops" / "t05.csv"
DIMS = ("ensemble", "walker", "step")
FILES = ["posterior.nc", "report.html", "summary.json"]


def fitted(**options: Any) -> Outcome:
    return hdprog.fit(hdprog.read_loop(LOOP), hdprog.read_drive(DRIVE / "drive.toml"), **options)


@pytest.fixture(name="outcome", scope="module")
def outcome_fixture() -> Outcome:
    return fitted(quick=True, seed=5)


@pytest.fixture(name="written", scope="module")
def written_fixture(outcome: Outcome, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fit") / "out"
    outcome.write(folder, command="hdprog fit t05.csv")
    return folder


@pytest.fixture(name="short")
def short_fixture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workflow, "QUICK", SHORT)


def summary_of(folder: Path) -> dict[str, Any]:
    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    return json.loads((folder / "summary.json").read_text("utf-8"), parse_constant=refuse)


def test_the_truth_is_mostly_inside_the_intervals(outcome: Outcome) -> None:
    truth = json.loads((DRIVE / "truth.json").read_text("utf-8"))
    mounted = next(t for t in truth["tests"] if t["test_id"] == "t05")["mounted"]
    assert outcome.converged
    bands = {name: p.quantiles for name, p in outcome.tests[0].parameters.items()}
    inside = [name for name in NAMES if bands[name][0.05] < mounted[name] < bands[name][0.95]]
    # Three or more of eight outside 90 % intervals: 4 % of all seeds, were they independent.
    assert len(inside) >= 6, inside


def test_the_draws_keep_ensemble_walker_and_step(outcome: Outcome) -> None:
    idata = outcome.idata
    groups = {"posterior", "prior", "log_likelihood", "observed_data", "posterior_predictive"}
    assert groups <= set(idata.groups())
    assert set(NAMES) <= set(idata.posterior)
    for name in NAMES:
        variable = idata.posterior[name]
        assert variable.dims == DIMS
        unit = BY_NAME[name].unit
        assert variable.attrs["units"] == ("1" if unit == "-" else unit)
        assert idata.prior[name].attrs["units"] == variable.attrs["units"]
    assert idata.posterior.sizes["ensemble"] == 4
    assert idata.posterior["angle_offset"].dims == DIMS
    blocks = idata.observed_data.sizes["block"]
    for group in ("log_likelihood", "posterior_predictive"):
        assert idata[group]["angle"].dims[:2] == DIMS[:2]
        assert idata[group]["angle"].dims[-1] == "block"
        assert idata[group].sizes["block"] == blocks
        assert np.isfinite(idata[group]["angle"]).all()
    for name, summary in outcome.tests[0].parameters.items():
        assert float(idata.posterior[name].mean()) == pytest.approx(summary.mean, rel=1e-9)


def test_every_group_says_where_it_comes_from(outcome: Outcome) -> None:
    digest = hashlib.sha256(LOOP.read_bytes()).hexdigest()
    for group in outcome.idata.groups():
        attributes = outcome.idata[group].attrs
        assert attributes["source_sha256"] == digest
        assert attributes["source_file"] == "t05.csv"
        assert attributes["hdprog_version"] == hdprog.__version__
        assert attributes["seed"] == 5
    assert outcome.result.provenance.files == {"t05.csv": digest}


def test_predictions_spread_as_the_record_does(outcome: Outcome) -> None:
    predicted = outcome.idata.posterior_predictive["angle"].values
    draws = predicted.reshape(-1, predicted.shape[-1])
    low, high = np.quantile(draws, (0.05, 0.95), axis=0)
    observed = outcome.idata.observed_data["angle"].values
    inside = ((low < observed) & (observed < high)).mean()
    # 90 % of about 300 blocks, known to 1.7 %: four of that is 1 in 15 000.
    assert inside == pytest.approx(0.9, abs=0.07)


def test_the_prior_is_wider_than_the_posterior(outcome: Outcome) -> None:
    for name in ("K_W", "c", "T_i", "mu"):
        prior, posterior = outcome.idata.prior[name], outcome.idata.posterior[name]
        assert float(prior.std()) > float(posterior.std()), name


def test_the_summary_holds_what_is_agreed(written: Path, outcome: Outcome) -> None:
    summary = summary_of(written)
    assert summary["schema"] == "hdprog.summary/1"
    assert summary["hdprog_version"] == hdprog.__version__
    assert summary["seed"] == 5
    assert summary["drive"]["id"] == "wearing-csf-25-80"
    assert summary["converged"] is True
    assert summary["forecast"] == []
    assert isinstance(summary["warnings"], list)
    (test,) = summary["tests"]
    assert test["test_id"] == "t05"
    assert test["converged"] is True
    assert test["effects"] == []
    assert list(test["parameters"]) == list(NAMES)
    numbers = {"mean", "sd", "q05", "q25", "q50", "q75", "q95"}
    numbers |= {"rhat", "ess_bulk", "ess_tail", "contraction"}
    for name, parameter in test["parameters"].items():
        assert numbers <= set(parameter), name
        levels = [parameter[level] for level in ("q05", "q25", "q50", "q75", "q95")]
        assert levels == sorted(levels)
        assert parameter["rhat"] < 1.01
        assert parameter["ess_bulk"] >= 400
        assert parameter["contraction"] < 1
        assert parameter["mean"] == outcome.tests[0].parameters[name].mean
    figures = {"hysteresis_width_arcmin", "hysteresis_loss_J", "lost_motion_arcmin", "preload_Nm"}
    figures |= {f"{kind}_stiffness_Nm_per_rad@63Nm" for kind in ("local", "secant")}
    figures |= {"secant_stiffness_Nm_per_rad@14Nm"}
    figures |= {"K1_Nm_per_rad", "K2_Nm_per_rad", "K3_Nm_per_rad"}
    assert figures <= set(test["figures"])
    assert all({"q05", "q50", "q95"} <= set(figure) for figure in test["figures"].values())
    # The rig reads an angle to 1e-5 rad and a torque to 0.1 Nm, which is 1e-6 rad.
    assert 0.8e-5 < test["noise_floor_rad"] < 1.4e-5
    assert test["noise_floor_rad"] < 1.2 * test["rmse_rad"] < 2 * test["noise_floor_rad"]
    # Nothing but what the record leaves open: the drive is not loaded to its preload torque.
    assert [text.partition(",")[0] for text in test["warnings"]] == ["Of the parameters"]
    assert summary["provenance"]["command"] == "hdprog fit t05.csv"


def test_the_report_is_small_and_loads_nothing(written: Path) -> None:
    report = written / "report.html"
    assert report.stat().st_size < 2e6
    text = report.read_text("utf-8")
    page = Page(text)
    assert page.faults == []
    for tag, attributes in page.tags:
        assert tag not in {"script", "iframe"}
        for name in ("src", "href", "srcset", "action", "data"):
            if name in attributes:
                assert str(attributes[name]).startswith(("data:", "#")), (tag, attributes[name])
    assert "@import" not in text
    assert "url(http" not in text
    assert "Not converged" not in page.text


def test_the_posterior_is_read_back_as_it_was(written: Path, outcome: Outcome) -> None:
    again = arviz.from_netcdf(str(written / "posterior.nc"))
    assert set(again.groups()) == set(outcome.idata.groups())
    for group in again.groups():
        for name, variable in outcome.idata[group].items():
            np.testing.assert_array_equal(again[group][name].values, variable.values)
            assert again[group][name].dims == variable.dims
            assert again[group][name].attrs == variable.attrs
    assert again.posterior.attrs["command"] == "hdprog fit t05.csv"
    with xarray.open_dataset(
        written / "posterior.nc", group="posterior", engine="h5netcdf"
    ) as posterior:
        assert float(posterior["mu"].mean()) == pytest.approx(
            float(outcome.idata.posterior["mu"].mean()), rel=1e-12
        )
    assert sorted(path.name for path in written.iterdir()) == FILES


@pytest.mark.usefixtures("short")
def test_same_seed_same_numbers(tmp_path: Path) -> None:
    summaries = []
    for name, seed in (("one", 2), ("again", 2), ("other", 3)):
        outcome = fitted(quick=True, seed=seed)
        outcome.write(tmp_path / name)
        summaries.append(summary_of(tmp_path / name)["tests"])
    assert summaries[0] == summaries[1]
    assert summaries[0][0]["parameters"] != summaries[2][0]["parameters"]
    one, again = (arviz.from_netcdf(str(tmp_path / n / "posterior.nc")) for n in ("one", "again"))
    for group in one.groups():
        xarray.testing.assert_identical(one[group].drop_attrs(), again[group].drop_attrs())


@pytest.mark.usefixtures("short")
def test_a_generator_of_ones_own_is_used() -> None:
    given = [fitted(quick=True, rng=np.random.default_rng(2)) for _ in range(2)]
    seeded = fitted(quick=True, seed=2)
    for name in NAMES:
        values = [outcome.tests[0].parameters[name].mean for outcome in (*given, seeded)]
        assert len(set(values)) == 1, name


def test_a_failed_write_leaves_the_old_files(
    written: Path, outcome: Outcome, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> str:
        raise RuntimeError("no report")

    before = {path.name: path.read_bytes() for path in written.iterdir()}
    monkeypatch.setattr("hdprog.reporting.build.build_report", fail)
    for folder in (written, tmp_path / "new"):
        with pytest.raises(RuntimeError, match="no report"):
            outcome.write(folder, command="again")
    assert {path.name: path.read_bytes() for path in written.iterdir()} == before
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("short")
def test_a_posterior_that_finds_no_room_leaves_nothing_and_says_so_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    resource = pytest.importorskip("resource")
    beside: list[object] = []
    outcome = fitted(quick=True)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    monkeypatch.setattr(sys, "unraisablehook", beside.append)
    resource.setrlimit(resource.RLIMIT_FSIZE, (400_000, before[1]))
    try:
        with pytest.raises(OSError, match=os.strerror(errno.EFBIG)):
            outcome.write(tmp_path / "out")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    gc.collect()  # HDF5 lets go of what it could not write
    assert beside == []
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("short")
def test_what_is_not_declared_is_said(tmp_path: Path) -> None:
    outcome = hdprog.fit(hdprog.read_loop(LOOP), quick=True)
    said = " ".join(outcome.tests[0].warnings)
    for words in (
        "No model and no prior are declared",
        "log-sd of 1.5",
        "rated torque is not given",
        "gear-tooth angle is not declared: 30°",
    ):
        assert words in said, words
    assert outcome.tests[0].prior_name == "generic"
    outcome.write(tmp_path / "out")
    written = summary_of(tmp_path / "out")["tests"][0]["warnings"]
    assert written[: len(outcome.tests[0].warnings)] == list(outcome.tests[0].warnings)
    page = Page((tmp_path / "out" / "report.html").read_text("utf-8")).text
    assert "log-sd of 1.5" in page
    assert "rated torque is not given" in page


@pytest.mark.usefixtures("short")
def test_a_fit_that_did_not_converge_says_so_everywhere(tmp_path: Path) -> None:
    outcome = fitted(quick=True)
    assert outcome.result.converged is False
    assert outcome.converged is False
    assert outcome.verdict.startswith("Not converged: the fit of test t05.")
    assert outcome.tests[0].warnings[0].startswith("This fit did not converge within")
    assert outcome.idata.posterior.attrs["converged"] == 0
    outcome.write(tmp_path / "out")
    summary = summary_of(tmp_path / "out")
    assert summary["converged"] is False
    assert summary["verdict"]["provisional"] is True
    assert summary["tests"][0]["converged"] is False
    page = Page((tmp_path / "out" / "report.html").read_text("utf-8")).text
    assert "Not converged: the fit of test t05" in page
    assert "This fit did not converge within" in page


@pytest.mark.usefixtures("short")
def test_a_record_from_no_file_is_fitted_and_written(tmp_path: Path) -> None:
    loop = hdprog.read_loop(LOOP)
    outcome = hdprog.fit(hdprog.Loop(torque=loop.torque, angle=loop.angle), quick=True)
    outcome.write(tmp_path / "out")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == FILES
    assert outcome.tests[0].test_id == "record"


def test_effects_that_do_not_exist_or_cannot_show_are_refused() -> None:
    with pytest.raises(UsageError, match="effects: found nosuch, expected ids out of torque"):
        fitted(effects=("nosuch",))
    with pytest.raises(BadInputError, match="without output angle"):
        fitted(effects=("kinematic_error",))


@pytest.mark.usefixtures("short")
def test_an_effect_is_fitted_beside_the_drive_model(tmp_path: Path) -> None:
    outcome = fitted(effects=("backlash",), quick=True)
    assert outcome.tests[0].effects == ("backlash",)
    assert "backlash.play" in outcome.idata.posterior
    outcome.write(tmp_path / "out")
    assert summary_of(tmp_path / "out")["tests"][0]["effects"] == ["backlash"]


@pytest.mark.usefixtures("short")
def test_progress_is_reported() -> None:
    seen: list[tuple[str, int, int]] = []
    fitted(quick=True, progress=lambda *step: seen.append(step))
    assert seen
    assert all(0 <= done <= total for _, done, total in seen)
