"""`hdprog prior`: listing, checking, drawing and making priors."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import typer

from hdprog.cli import app
from hdprog.inference.prior_file import names, read_prior_file
from hdprog.shipped import shipped
from tests.cli.conftest import Invoke

GROUP: Any = typer.main.get_command(app)
COMMANDS = sorted(GROUP.commands["prior"].commands)
NUMBERS = ("--K1", "3.1e4", "--K2", "5.0e4", "--K3", "5.7e4", "--T1", "14", "--T2", "48")
SHIPPED = (shipped("priors") / "csf-25-80.toml").read_text("utf-8")


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_has_help(invoke: Invoke, name: str) -> None:
    command = GROUP.commands["prior"].commands[name]
    assert command.help
    assert [param.name for param in command.params if not getattr(param, "help", None)] == []
    assert f"hdprog prior {name}" in invoke("prior", name, "--help").stdout
    assert "..." not in invoke("prior", "--help").stdout.partition("Commands:")[2]


def test_help_loads_nothing_numeric() -> None:
    code = (
        "import sys\nfrom hdprog.cli import app\n"
        "try: app(['prior', 'show', '--help'], prog_name='hdprog')\n"
        "except SystemExit: pass\n"
        "print(sorted({'numpy', 'scipy', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_list_names_every_prior(invoke: Invoke) -> None:
    shown = invoke("prior", "list")
    assert shown.exit_code == 0, shown.stderr
    assert [line.split()[0] for line in shown.stdout.splitlines()] == names()
    assert "csf-25-80   CSF-25-80: Table 2" in shown.stdout
    listed = json.loads(invoke("prior", "list", "--json").stdout)["priors"]
    models = {entry["name"]: entry["models"] for entry in listed}
    assert models["csf-25-80"] == ["CSF-25-80"]
    assert "CSF-25-80" not in models["csg-25-80"]
    assert "CSF-25-100" in models["csg-25-80"]


def test_show_says_what_a_prior_means(invoke: Invoke) -> None:
    shown = invoke("prior", "show", "CSG-32-100", "--out", "picture.png")
    assert shown.exit_code == 0, shown.stderr
    assert shown.stdout.startswith("Prior csg-32-80: Stiffness of CSG")
    assert shown.stdout.endswith("Picture: picture.png\n")
    [line] = [line for line in shown.stdout.splitlines() if line.startswith("K2 Nm/rad")]
    assert line.split()[-1] == "1.1e+05"
    assert Path("picture.png").read_bytes().startswith(b"\x89PNG")


def test_show_gives_json_and_the_same_again(invoke: Invoke) -> None:
    first = invoke("prior", "show", "csf-14-30", "--json", "--alpha-deg", "20", "--out", "a.svg")
    document = json.loads(first.stdout)
    assert document["schema"] == "hdprog.prior/1"
    assert document["alpha_deg"] == 20
    assert document["in_support"] > 0.99
    figures = document["figures"]
    assert figures["K1_Nm_per_rad"]["q05"] < 1900 < figures["K1_Nm_per_rad"]["q95"]
    again = invoke("prior", "show", "csf-14-30", "--json", "--alpha-deg", "20", "--out", "b.svg")
    assert again.stdout == first.stdout
    assert Path("a.svg").read_bytes() == Path("b.svg").read_bytes()
    assert b"<svg" in Path("a.svg").read_bytes()


def test_a_prior_without_catalogue_figures_is_drawn(invoke: Invoke) -> None:
    Path("own.toml").write_text(SHIPPED.partition("[catalogue]")[0], "utf-8")
    shown = invoke("prior", "show", "own.toml", "--out", "own.png")
    assert shown.exit_code == 0, shown.stderr
    assert "K1 Nm/rad" not in shown.stdout
    assert "hysteresis width" in shown.stdout
    assert Path("own.png").is_file()


@pytest.mark.parametrize(
    ("old", "new", "found", "expected", "advice"),
    [
        ("log_sd = 0.4\n", "log_sd = -0.4\n", "parameters.K_F.log_sd = -0.4", "greater than 0", ""),
        ("log_sd = 0.4\n", "log_sd = 50\n", "parameters.K_F.log_sd = 50", "at most 5", ""),
        (
            "log_sd = 0.4\n",
            'log_sd = "wide"\n',
            "parameters.K_F.log_sd = 'wide'",
            "a number without quotation marks",
            "",
        ),
        ("median = 0.07", "median = 1.5", "parameters.mu.median = 1.5", "below 1", "0.05 to 0.2"),
        ("T1_Nm = 14.0", "T1_Nm = 50.0", "T1_Nm = 50", "T1_Nm below T2_Nm", "Exchange them"),
        (
            "T1_Nm = 14.0",
            "",
            "catalogue: only T2_Nm",
            "T1_Nm and T2_Nm, or neither",
            "add the other",
        ),
        ("T1_Nm", "T1_nm", "the key catalogue.T1_nm", "only T1_Nm", "Did you mean T1_Nm?"),
        (
            "[parameters.mu]",
            "[parameters.muu]",
            "and no parameters.mu",
            "only K_F",
            "Did you mean mu",
        ),
        ("[parameters.K_F]", "[parameters.K_F", "not valid TOML", "a prior in TOML", "that place"),
    ],
)
def test_a_wrong_file_ends_with_3_and_words(
    invoke: Invoke, old: str, new: str, found: str, expected: str, advice: str
) -> None:
    assert old in SHIPPED
    Path("own.toml").write_text(SHIPPED.replace(old, new, 1), "utf-8")
    shown = invoke("prior", "show", "own.toml", "--out", "own.png")
    assert shown.exit_code == 3
    assert shown.stdout == ""
    assert shown.stderr.startswith("Error: own.toml: found ")
    before, _, after = shown.stderr.partition("; expected ")
    assert found in before
    assert expected in after
    assert advice in after
    assert "pydantic" not in shown.stderr
    assert [path.name for path in Path().iterdir()] == ["own.toml"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("show", "nosuch.toml"), "no file nosuch.toml"),
        (("show", "csf-25-81"), "no prior called 'csf-25-81'"),
        (("from-catalogue", "--series", "RV", "--size", "25", "--ratio", "80"), "no RV-25-80"),
        (("from-catalogue", *NUMBERS[:-1], "4.8"), "T1 = 14 Nm and T2 = 4.8 Nm"),
        (("from-catalogue", *NUMBERS[:-1], "0"), "T2_Nm = 0"),
    ],
)
def test_bad_input_ends_with_3(invoke: Invoke, arguments: tuple[str, ...], said: str) -> None:
    shown = invoke("prior", *arguments, "--out", "out.png")
    assert shown.exit_code == 3
    assert said in shown.stderr
    assert list(Path().iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("show", "csf-25-80", "--out", "picture.pdf"), "ends in .png or .svg"),
        (("show", "csf-25-80", "--alpha-deg", "89"), "from 5 to 60 degrees"),
        (("show", "generic"), "takes its scales from a record"),
        (("from-catalogue",), "found none of"),
        (("from-catalogue", "--all"), "--all without --out"),
        (("from-catalogue", "--all", "--out", "made", "--name", "x"), "--all with --name"),
        (("from-catalogue", "--all", "--out", "made", "--rated-torque", "5"), "are of one prior"),
        (("from-catalogue", "--series", "CSF", *NUMBERS), "found several of"),
        (("from-catalogue", "--series", "CSF", "--size", "25"), "found no --ratio"),
        (("from-catalogue", *NUMBERS[:-2]), "found no --T2"),
    ],
)
def test_wrong_usage_ends_with_2(invoke: Invoke, arguments: tuple[str, ...], said: str) -> None:
    shown = invoke("prior", *arguments)
    assert shown.exit_code == 2
    assert said in shown.stderr
    assert list(Path().iterdir()) == []


def test_a_gear_of_the_catalogue_is_printed(invoke: Invoke) -> None:
    shown = invoke("prior", "from-catalogue", "--series", "csf", "--size", "25", "--ratio", "100")
    assert shown.exit_code == 0, shown.stderr
    Path("own.toml").write_text(shown.stdout, "utf-8")
    own, shipped_one = read_prior_file("own.toml"), read_prior_file("CSF-25-100")
    assert (own.name, shipped_one.name) == ("csf-25-100", "csg-25-80")
    # As in the test that the files are up to date: the last of three digits.
    for name, spec in own.parameters.model_dump(exclude_none=True).items():
        shipped_spec = getattr(shipped_one.parameters, name).model_dump(exclude_none=True)
        assert spec == pytest.approx(shipped_spec, rel=0.01, abs=0.02)


def test_a_drive_of_no_catalogue_is_made_from_its_numbers(invoke: Invoke) -> None:
    asked = ("prior", "from-catalogue", *NUMBERS, "--rated-torque", "70", "--out", 'mine "1".toml')
    shown = invoke(*asked)
    assert shown.exit_code == 0, shown.stderr
    prior = read_prior_file('mine "1".toml')
    assert prior.name == 'mine "1"'
    assert prior.catalogue_table == {
        "T1_Nm": 14.0,
        "T2_Nm": 48.0,
        "K1_Nm_per_rad": 3.1e4,
        "K2_Nm_per_rad": 5.0e4,
        "K3_Nm_per_rad": 5.7e4,
        "rated_torque_Nm": 70.0,
    }
    assert invoke(*asked).exit_code == 0  # the same again changes nothing
    other = invoke(*asked[:-4], "--out", asked[-1])
    assert other.exit_code == 2
    assert "other content" in other.stderr
    assert read_prior_file(asked[-1]) == prior


def test_all_gears_are_written_at_once(invoke: Invoke) -> None:
    shown = invoke("prior", "from-catalogue", "--all", "--out", "made")
    assert shown.exit_code == 0, shown.stderr
    made = sorted(path.name for path in Path("made").iterdir())
    assert made == sorted(entry.name for entry in (shipped("priors") / "catalogue").iterdir())
