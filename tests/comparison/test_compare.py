"""`hdprog compare` from a file to its table, JSON and page."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hdprog
from hdprog import comparing
from hdprog.comparing import ComparisonOutcome
from hdprog.comparison.results import DRIVE
from hdprog.physics.other_models import MODELS
from hdprog.reporting.comparison import build_comparison_report
from hdprog.reporting.comparison_json import comparison_json
from hdprog.reporting.comparison_words import verdict
from hdprog.shipped import shipped
from tests.cli.conftest import Invoke, invoke  # noqa: F401 - a fixture
from tests.comparison.loops import SHORT, loop_of
from tests.reporting.page import Page, spaced
from tests.reporting.test_picture_data import read

SHIPPED = Path(str(shipped("datasets"))) / "wearing-csf-25-80"
forked = pytest.mark.skipif(
    sys.platform != "linux", reason="the shorter plan reaches forked worker processes only"
)


@pytest.fixture(scope="module")
def outcome() -> ComparisonOutcome:
    """All models on a short record of the drive model's own kind, with a short plan."""
    rng = np.random.default_rng(3)
    torque = loop_of("cubic", rng).torque
    parameters = {"K_F": 7.8e4, "K_W": 9.9e4, "a": 1833.5, "b": 5729.6, "T_T": 30.0}
    parameters |= {"c": -1.152, "T_i": 40.0, "mu": 0.076}
    values = {name: np.asarray(value) for name, value in parameters.items()}
    angle = hdprog.predict(torque, values) + 1e-5 * rng.standard_normal(torque.size)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(comparing, "QUICK", replace(SHORT, required_ess=40.0, first_steps=40))
        return comparing.compare(hdprog.Loop(torque, angle, source="worn"), quick=True, seed=2)


@forked
def test_every_model_is_there_or_says_why(outcome: ComparisonOutcome) -> None:
    result = outcome.result
    ids = {one.id for one in result.models} | {one.id for one in result.left_out}
    assert ids == {DRIVE, *(model.id for model in MODELS)}
    assert [(one.id, one.why) for one in result.left_out] == [
        ("tuttle", "needs time_s and output_angle_rad")
    ]
    assert sum(one.evidence.weight for one in result.models) == pytest.approx(1.0, abs=1e-6)
    differences = [one.evidence.difference for one in result.models]
    assert differences == sorted(differences)
    assert differences[0] == 0.0


@forked
def test_the_drive_model_wins_on_its_own_worn_record(outcome: ComparisonOutcome) -> None:
    assert DRIVE in [one.id for one in outcome.result.level]
    drive = outcome.result.of(DRIVE)
    assert drive.errors.rmse_rad == pytest.approx(1e-5, rel=0.15)
    for name in ("cubic", "catalogue_piecewise", "ideal", "dhaouadi"):
        other = outcome.result.of(name)
        assert other.errors.heldout_rmse_rad > 1.5 * drive.errors.heldout_rmse_rad
        assert not other.evidence.level_with_the_best
    # What the loop was made with: 0.17 arcmin wide at no load; stiffness (39) beyond T_T.
    truth = 1 / (1 / 7.8e4 + math.tan(math.pi / 6) ** 2 / 9.9e4 + 1 / (1833.5 * 30 + 5729.6))
    assert drive.stiffness is not None
    assert drive.stiffness.quantiles[0.5][-1] == pytest.approx(truth, rel=0.03)


@forked
def test_the_json_is_as_documented(outcome: ComparisonOutcome) -> None:
    found = json.loads(json.dumps(comparison_json(outcome.result), allow_nan=False))
    assert found["schema"] == "hdprog.compare/1"
    assert [one["rank"] for one in found["models"]] == list(range(1, len(MODELS) + 1))
    for one in found["models"]:
        for key in (
            "rmse_rad",
            "heldout_rmse_rad",
            "elpd",
            "elpd_se",
            "elpd_difference",
            "elpd_difference_se",
            "stacking_weight",
            "hysteresis_width_rad",
            "parameters",
            "converged",
        ):
            assert key in one
        band = one["local_stiffness"]
        assert (band is None) == (one["id"] == "ideal")
        if band is not None:
            assert len(band["torque_Nm"]) == len(band["q50_Nm_per_rad"]) == 48
    guide = (Path(__file__).parents[2] / "reports" / "guide" / "files.md").read_text("utf-8")
    documented = guide.partition("## compare.json")[2]
    assert all(f"`{key}`" in documented for key in found["models"][0])


@forked
def test_the_page_says_what_the_numbers_say(outcome: ComparisonOutcome) -> None:
    page = Page(build_comparison_report(outcome.result))
    assert page.faults == []
    assert len(page.pictures) == 3
    assert all(str(one["src"]).startswith("data:image/svg+xml") for one in page.pictures)
    said = spaced(verdict(outcome.result).text)
    assert said.split(".")[0] in spaced(page.text)
    for one in outcome.result.models:
        assert one.words in page.text
    assert "needs time_s and output_angle_rad" in page.text
    assert "Quick run" in page.text
    files = {str(one["download"]): str(one["href"]) for _, one in page.tags if "download" in one}
    assert list(files) == ["model-ranking.csv", "local-stiffness.csv", "model-loops.csv"]
    models = {one.words for one in outcome.result.models}
    [head, *rows] = read(files["model-loops.csv"])
    assert head[-1] == "measured less modelled angle [µrad]"
    assert {row[0] for row in rows} == models
    yielding = {one.words for one in outcome.result.models if one.stiffness is not None}
    assert {row[0] for row in read(files["local-stiffness.csv"])[1:]} == yielding


@forked
def test_the_table_fits_a_screen(outcome: ComparisonOutcome) -> None:
    lines = outcome.sentence.split("\n\n")[1].splitlines()
    assert max(map(len, lines)) <= 100
    assert all(any(line.startswith(one.words) for line in lines) for one in outcome.models)


@forked
def test_what_did_not_converge_ends_with_4_and_says_so(
    invoke: Invoke,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plan = replace(SHORT, required_ess=1e6, warm_up_steps=(20, 20), first_steps=20, most_steps=60)
    monkeypatch.setattr(comparing, "QUICK", plan)
    monkeypatch.setattr(
        comparing, "MODELS", [one for one in MODELS if one.id in ("cubic", "ideal")]
    )
    shown = invoke("compare", str(SHIPPED / "loops" / "t01.csv"), "--quick", "--out", "there")
    assert shown.exit_code == 4, shown.stderr
    assert "Not converged: " in shown.stdout
    assert "* not converged" in shown.stdout
    found = json.loads(Path("there/compare.json").read_text("utf-8"))
    assert found["converged"] is False
    assert sorted(file.name for file in Path("there").iterdir()) == ["compare.json", "report.html"]


def test_refusals(invoke: Invoke, tmp_path: Path) -> None:  # noqa: F811
    bad = tmp_path / "bad.csv"
    bad.write_text("torque,angle_rad\n1,2\n", "utf-8")
    shown = invoke("compare", str(bad))
    assert shown.exit_code == 3
    assert "bad.csv" in shown.stderr
    assert not (tmp_path / "hdprog-compare-bad").exists()
    assert invoke("compare").exit_code == 2
    (tmp_path / "file").write_text("x", "utf-8")
    assert invoke("compare", str(bad), "--out", "file").exit_code == 2


def test_compare_is_lazily_exported() -> None:
    assert hdprog.compare is comparing.compare
    assert "compare" in hdprog.__all__
