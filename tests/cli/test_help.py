"""Every command and option says what it is for."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from hdprog import __version__
from hdprog.cli import app
from hdprog.cli.exits import ExitCode
from tests.cli.conftest import Invoke

GROUP: Any = typer.main.get_command(app)
COMMANDS = sorted(GROUP.commands)
GROUPS = [name for name in COMMANDS if hasattr(GROUP.commands[name], "commands")]
EVERY = [
    *((name,) for name in COMMANDS),
    *((group, name) for group in GROUPS for name in sorted(GROUP.commands[group].commands)),
]


def test_commands_are_those_of_the_contract() -> None:
    assert {"demo", "check", "fit", "run", "simulate"} <= set(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_has_help(name: str) -> None:
    command = GROUP.commands[name]
    assert command.help
    assert [param.name for param in command.params if not getattr(param, "help", None)] == []


@pytest.mark.parametrize(
    "name",
    ["demo", "check", "fit", "explain", "compare", "run", "fleet", "simulate", "reproduce-paper"],
)
def test_the_common_options_are_those_of_every_command(name: str) -> None:
    options = {option for param in GROUP.commands[name].params for option in param.opts}
    assert {"--seed", "--json", "--quick", "--quiet"} <= options


@pytest.mark.parametrize("name", COMMANDS)
def test_help_names_the_command_and_ends_well(invoke: Invoke, name: str) -> None:
    shown = invoke(name, "--help")
    assert shown.exit_code == 0
    assert f"hdprog {name}" in shown.stdout


@pytest.mark.parametrize("group", ["", *GROUPS])
def test_first_sentences_fit_the_list_of_commands(group: str) -> None:
    """In a terminal of 80 columns, of which help leaves two free."""
    asked = [group, "--help"] if group else ["--help"]
    shown = CliRunner().invoke(app, asked, prog_name="hdprog", terminal_width=78)
    listed = shown.stdout.partition("Commands:")[2]
    assert all(name in listed for name in (GROUP.commands[group] if group else GROUP).commands)
    assert "..." not in listed


@pytest.mark.parametrize("path", EVERY, ids=" ".join)
def test_help_of_every_command_has_all_exit_codes(invoke: Invoke, path: tuple[str, ...]) -> None:
    told = " ".join(invoke(*path, "--help").stdout.partition("Exit codes:")[2].split())
    assert [code for code in ExitCode if not re.search(rf"\b{code:d} ", told)] == []


def test_the_guide_has_all_exit_codes() -> None:
    guide = (Path(__file__).parents[2] / "reports" / "guide" / "files.md").read_text("utf-8")
    told = guide.partition("Exit codes:")[2].partition("\n\n")[0]
    assert [code for code in ExitCode if not re.search(rf"\b{code:d} ", told)] == []


def test_version(invoke: Invoke) -> None:
    assert invoke("--version").stdout == f"hdprog {__version__}\n"


@pytest.mark.parametrize("arguments", [["nosuch"], ["fit"], ["run", "--seed", "-1", "x"]])
def test_wrong_usage_ends_with_2(invoke: Invoke, arguments: list[str]) -> None:
    shown = invoke(*arguments)
    assert shown.exit_code == 2
    assert shown.stdout == ""
    assert "Error" in shown.stderr
