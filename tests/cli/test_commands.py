"""What each command asks of the workflow and says at the end."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.cli.conftest import Invoke, Workflow, put_module


def test_run_says_verdict_and_where(invoke: Invoke, workflow: Workflow) -> None:
    shown = invoke("run", "cell3-axis2", "--seed", "7", "--quick")
    assert shown.exit_code == 0
    assert shown.stdout == ("Inspect before 1 310 h.\nReport: hdprog-cell3-axis2/report.html\n")
    assert shown.stderr == ""
    [(name, arguments, options)] = workflow.calls
    assert (name, arguments) == ("run", (Path("cell3-axis2"),))
    assert options == {
        "seed": 7,
        "quick": True,
        "explain": True,
        "loads": (),
        "fleet": None,
        "progress": None,
    }
    [(_, command)] = workflow.outcome.written
    assert command == "hdprog run cell3-axis2 --seed 7 --quick"


def test_run_here_is_named_after_the_folder(
    invoke: Invoke, workflow: Workflow, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "axis2").mkdir()
    monkeypatch.chdir(tmp_path / "axis2")
    assert "hdprog-axis2/report.html" in invoke("run", ".").stdout


def test_json_stands_alone(invoke: Invoke, workflow: Workflow) -> None:
    shown = invoke("run", "drive", "--json", "--out", "there")
    assert json.loads(shown.stdout) == workflow.outcome.summary()
    assert Path("there/report.html").is_file()


def test_json_names_the_command_that_the_file_names(
    invoke: Invoke, workflow: Workflow, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = {"provenance": {"command": "Python API", "quick": False}}
    monkeypatch.setattr(workflow.outcome, "document", lambda: made, raising=False)
    shown = json.loads(invoke("run", "drive", "--json").stdout)
    assert shown == {"provenance": {"command": "hdprog run drive --json", "quick": False}}


def test_demo_goes_on_to_the_users_own_file(invoke: Invoke, workflow: Workflow) -> None:
    shown = invoke("demo", "--out", "first")
    assert shown.exit_code == 0, shown.stderr
    lines = shown.stdout.splitlines()
    assert lines[:2] == ["Inspect before 1 310 h.", "Report: first/report.html"]
    assert len(lines[2:]) == 4  # an empty line, then three
    assert lines[3].startswith("Now with your own file")
    [(_, (drive_dir,), _)] = workflow.calls
    assert (drive_dir / "drive.toml").is_file()


def test_fit_hands_on_the_record_the_drive_and_the_effects(
    invoke: Invoke, workflow: Workflow, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: dict[str, Any] = {}

    def read_loop(path: Path, **options: Any) -> str:
        asked.update(options)
        return f"record of {path}"

    put_module(monkeypatch, "hdprog.data.readers", read_loop=read_loop)
    put_module(monkeypatch, "hdprog.config", read_drive=lambda path: f"drive of {path}")
    shown = invoke("fit", "logs/t01.csv.gz", "--drive", "drive.toml", "--effects", "creep, drift")
    assert shown.exit_code == 0, shown.stderr
    assert "Report: hdprog-t01/report.html" in shown.stdout
    [(name, arguments, options)] = workflow.calls
    assert (name, arguments) == ("fit", ("record of logs/t01.csv.gz", "drive of drive.toml"))
    assert options["effects"] == ("creep", "drift")
    assert asked["drive"] == "drive of drive.toml"


@pytest.mark.parametrize(
    ("command", "file", "folder"),
    [
        ("fit", "12.03.2025_axis2.csv", "hdprog-12.03.2025_axis2"),
        ("explain", "12.04.2025_axis5.csv", "hdprog-12.04.2025_axis5"),
        ("compare", "12.05.2025_axis1.TXT", "hdprog-compare-12.05.2025_axis1"),
    ],
)
def test_records_with_dots_in_their_names_are_kept_apart(
    invoke: Invoke, monkeypatch: pytest.MonkeyPatch, command: str, file: str, folder: str
) -> None:
    there = Workflow()
    put_module(monkeypatch, "hdprog.data.readers", read_loop=lambda *_, **__: "record")
    put_module(
        monkeypatch,
        "hdprog.workflow",
        fit=there.answer("fit"),
        explain=there.answer("explain"),
    )
    put_module(monkeypatch, "hdprog.comparing", compare=there.answer("compare"))
    shown = invoke(command, file)
    assert f"Report: {folder}/report.html" in shown.stdout, shown.stderr


@pytest.mark.parametrize(
    ("command", "lies", "refused"),
    [
        (("compare", "t01.csv"), "posteriors", True),
        (("compare", "t01.csv"), "compare.json", False),
        (("compare", "t01.csv"), "notes.json", False),
        (("backtest", "drive"), "posteriors", True),
        (("reproduce-paper",), "compare.json", True),
        (("fit", "t01.csv"), "compare.json", True),
        (("run", "drive"), "backtest.json", True),
        (("run", "drive"), "posteriors", False),
        (("fit", "t01.csv"), "posteriors", True),
    ],
)
def test_the_report_of_another_command_is_not_replaced(
    invoke: Invoke,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    command: tuple[str, ...],
    lies: str,
    refused: bool,
) -> None:
    there = Workflow()
    put_module(monkeypatch, "hdprog.data.readers", read_loop=lambda *_, **__: "record")
    put_module(monkeypatch, "hdprog.workflow", run=there.answer("run"), fit=there.answer("fit"))
    put_module(monkeypatch, "hdprog.comparing", compare=there.answer("compare"))
    put_module(monkeypatch, "hdprog.backtesting", backtest=there.answer("backtest"))
    put_module(monkeypatch, "hdprog.reproducing", reproduce_paper=there.answer("reproduce"))
    folder = tmp_path / "results"
    folder.mkdir()
    (folder / lies).write_text("{}", "utf-8")
    (folder / "report.html").write_text("before", "utf-8")
    shown = invoke(*command, "--out", "results")
    if not refused:
        assert shown.exit_code == 0, shown.stderr
        return
    assert shown.exit_code == 3
    assert f"--out results: found the {lies} of `hdprog " in shown.stderr
    assert "Give another folder with --out DIR." in shown.stderr
    assert there.calls == []
    assert sorted(file.name for file in folder.iterdir()) == sorted([lies, "report.html"])
    assert (folder / "report.html").read_text("utf-8") == "before"


@pytest.mark.parametrize("command", ["run", "fleet"])
@pytest.mark.parametrize("lies", ["drive.toml", "tests.csv"])
def test_results_are_not_written_among_the_files_of_a_drive(
    invoke: Invoke, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, command: str, lies: str
) -> None:
    there = Workflow()
    put_module(monkeypatch, "hdprog.workflow", run=there.answer("run"))
    put_module(monkeypatch, "hdprog.fleet_run", run_fleet=there.answer("fleet"))
    (tmp_path / "drive").mkdir()
    (tmp_path / "drive" / lies).write_text("", "utf-8")
    shown = invoke(command, "drive", "--out", "drive")
    assert shown.exit_code == 3
    assert f"--out drive: found the {lies} of a drive" in shown.stderr
    assert there.calls == []
    assert [file.name for file in (tmp_path / "drive").iterdir()] == [lies]


def test_a_folder_keeps_its_whole_name(
    invoke: Invoke, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    there = Workflow()
    put_module(monkeypatch, "hdprog.workflow", explain=there.answer("explain"))
    (tmp_path / "cell3.axis1.csv").mkdir()
    shown = invoke("explain", "cell3.axis1.csv")
    assert "Report: hdprog-cell3.axis1.csv/report.html" in shown.stdout, shown.stderr


def outcome(*lines: str, ok: bool) -> SimpleNamespace:
    return SimpleNamespace(kind="loop", lines=list(lines), ok=ok, as_json=lambda: {"ok": ok})


@pytest.fixture
def checked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put a check in place to which only `good.csv` is usable."""

    def check_path(path: Path, **_: Any) -> SimpleNamespace:
        return outcome(f"{path}: two cycles", ok=path.name == "good.csv")

    put_module(monkeypatch, "hdprog.data.check", check_path=check_path)


@pytest.mark.usefixtures("checked")
@pytest.mark.parametrize(("names", "code"), [(["good.csv"], 0), (["bad.csv", "good.csv"], 3)])
def test_check_says_a_line_each_and_ends_with_3_on_a_problem(
    invoke: Invoke, names: list[str], code: int
) -> None:
    shown = invoke("check", *names)
    assert shown.exit_code == code
    assert shown.stdout.splitlines() == [f"{name}: two cycles" for name in names]


@pytest.mark.usefixtures("checked")
def test_check_as_json(invoke: Invoke) -> None:
    shown = invoke("check", "good.csv", "bad.csv", "--json")
    assert shown.exit_code == 3
    assert json.loads(shown.stdout) == {
        "schema": "hdprog.check/1",
        "checks": [{"ok": True}, {"ok": False}],
    }


def test_simulate_hands_on_what_was_asked(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, Any] = {}

    def write_drive_folder(out: Path, **options: Any) -> Path:
        asked.update(options)
        out.mkdir()
        (out / "truth.json").write_text('{"seed": 3}', encoding="utf-8")
        return out

    put_module(monkeypatch, "hdprog.data.synthetic", write_drive_folder=write_drive_folder)
    shown = invoke("simulate", "--out", "made", "--seed", "3", "--wear", "healthy", "--one-sided")
    assert shown.exit_code == 0, shown.stderr
    assert "made/truth.json" in shown.stdout
    assert asked["seed"] == 3
    assert asked["scenario"] == "healthy"
    assert asked["one_sided"] is True
    assert asked["tests"] == 10
    assert asked["hours"] == 900.0
    assert asked["effects"] == ()
    shown = invoke("simulate", "--out", "again", "--effect", "creep", "--effect", "backlash")
    assert shown.exit_code == 0, shown.stderr
    assert asked["effects"] == ("creep", "backlash")


def test_simulate_offers_the_scenarios_there_are() -> None:
    from hdprog.cli.simulate import Wear
    from hdprog.data.wear_path import SCENARIOS

    assert {wear.value for wear in Wear} == set(SCENARIOS)


def test_simulate_refuses_an_effect_it_does_not_know(invoke: Invoke, tmp_path: Path) -> None:
    shown = invoke("simulate", "--out", "made", "--effect", "nosuch")
    assert shown.exit_code == 2
    assert "nosuch" in shown.stderr
    assert "torque_offset" in shown.stderr
    assert "slip_jump" in shown.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("hours", ["inf", "nan", "1.1e7"])
def test_simulate_refuses_hours_that_no_table_of_tests_takes(invoke: Invoke, hours: str) -> None:
    assert invoke("simulate", "--out", "drive", "--hours", hours).exit_code == 2
    assert not Path("drive").exists()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("hours", ["1e5", "1e7"])
def test_simulate_refuses_hours_that_wear_a_drive_away(invoke: Invoke, hours: str) -> None:
    shown = invoke("simulate", "--out", "drive", "--hours", hours)
    assert shown.exit_code == 2
    assert "Give fewer --hours, or --wear healthy" in shown.stderr
    assert not Path("drive").exists()


def test_simulate_says_what_effects_it_put_in(invoke: Invoke) -> None:
    effects = ("--effect", "backlash", "--effect", "viscous_friction")
    shown = invoke("simulate", "--out", "made", "--tests", "1", *effects, "--json")
    assert shown.exit_code == 0, shown.stderr
    truth = json.loads(shown.stdout)
    assert [effect["id"] for effect in truth["effects"]] == ["backlash", "viscous_friction"]
    assert "--effect backlash --effect viscous_friction" in truth["made_by"]


def test_units_of_the_report_are_asked_for(invoke: Invoke, workflow: Workflow) -> None:
    invoke("run", "drive", "--angle-unit", "mrad", "--torque-unit", "in-lbf")
    assert (workflow.outcome.units.angle_unit, workflow.outcome.units.torque_unit) == (
        "mrad",
        "in·lbf",
    )
    invoke("run", "drive", "--torque-unit", "lbf ft")
    assert (workflow.outcome.units.angle_unit, workflow.outcome.units.torque_unit) == (
        "arcmin",
        "ft·lbf",
    )


def test_a_unit_that_no_report_has_is_refused_before_the_work(
    invoke: Invoke, workflow: Workflow
) -> None:
    shown = invoke("run", "drive", "--angle-unit", "Nm")
    assert shown.exit_code == 2
    assert '--angle-unit: found "Nm", expected one of arcmin, arcsec, deg' in shown.stderr
    assert workflow.calls == []
