"""README.md's commands can be read by machine, and CI runs those that a reader sees."""

from __future__ import annotations

import shlex

import typer

from hdprog.cli import app
from tests.readme_commands import README, console_commands, named_commands, updated, wrapped

TEXT = README.read_text(encoding="utf-8")


def test_the_two_commands_are_one_line_each() -> None:
    commands = named_commands(TEXT)
    assert set(commands) == {"demo", "tests"}
    assert all("\n" not in line for line in commands.values())
    assert commands["demo"].endswith("hdprog demo")
    assert "-m pytest" in commands["tests"]


def test_console_commands_exist() -> None:
    known = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    shown = [shlex.split(line) for line in console_commands(TEXT)]
    assert {words[1] for words in shown} == {"check", "explain", "fit", "run"}
    for words in shown:
        assert words[0] == "hdprog"
        options = {option for param in known[words[1]].params for option in param.opts}
        assert {word for word in words if word.startswith("--")} <= options


def test_update_replaces_only_the_output() -> None:
    text = "a\n```console\n$ one\nold\n$ two\n```\nb\n```sh\n$ three\n```\n"
    assert updated(text, lambda command: f"said {command}  \n\n") == (
        "a\n```console\n$ one\nsaid one\n$ two\nsaid two\n```\nb\n```sh\n$ three\n```\n"
    )


def test_long_lines_go_on_and_lose_nothing() -> None:
    said = " ".join(["word"] * 60)
    lines = wrapped(f"{said}\n\n").splitlines()
    assert max(len(line) for line in lines) <= 100
    assert " ".join(line.strip() for line in lines) == said
