"""The page on running the service names commands and options that there are."""

from __future__ import annotations

import configparser
import json
import re
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
import typer

from hdprog.cli import app
from hdprog.config import drive_from_mapping

TEXT = (Path(__file__).resolve().parents[2] / "reports/guide/serving.md").read_text("utf-8")
COMMANDS: Any = typer.main.get_command(app)


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", TEXT, re.DOTALL)


def commands() -> list[list[str]]:
    """Find every hdprog command in the page, as words."""
    lines = [line for block in blocks("sh") for line in block.replace("\\\n", "").splitlines()]
    lines += re.findall(r"`([^`\n]*hdprog [a-z][^`\n]*)`", TEXT)
    found = []
    for line in lines:
        plain = line.partition("#")[0].replace("$(date +%F)", "DATE")
        match = re.search(r"(?:^|[/(\s])hdprog ((?:serve|worker|user|token|store)\b[^)&|]*)", plain)
        if match:
            found.append(shlex.split(match[1].replace("…", "")))
    return found


@pytest.mark.parametrize("words", commands(), ids=" ".join)
def test_commands_and_options_exist(words: list[str]) -> None:
    command = COMMANDS
    while words and hasattr(command, "commands") and words[0] in command.commands:
        command = command.commands[words.pop(0)]
    assert command is not COMMANDS
    options = {option for param in command.params for option in param.opts}
    assert {word for word in words if word.startswith("--")} <= options


def test_there_are_commands_to_check() -> None:
    assert len(commands()) >= 8


def test_a_drive_that_is_sent_is_one() -> None:
    sent = re.findall(r"-d '(\{.*?\})' \\\n", "".join(blocks("sh")))
    drives = [drive_from_mapping(json.loads(body)) for body in sent]
    assert [drive.id for drive in drives] == ["cell3-axis2"]


def test_the_unit_is_one_that_systemd_takes(tmp_path: Path) -> None:
    [text] = blocks("ini")
    unit = configparser.ConfigParser(strict=False)
    unit.optionxform = str  # type: ignore[assignment, method-assign]
    unit.read_string(text)
    words = shlex.split(unit["Service"]["ExecStart"])
    options = {option for param in COMMANDS.commands["serve"].params for option in param.opts}
    assert words[1] == "serve"
    assert {word for word in words if word.startswith("--")} <= options
    if shutil.which("systemd-analyze"):
        file = tmp_path / "hdprog.service"
        file.write_text(text.replace("/opt/hdprog/bin/hdprog", "/bin/true"), "utf-8")
        done = subprocess.run(
            ["systemd-analyze", "verify", str(file)], capture_output=True, text=True, check=False
        )
        assert "hdprog.service" not in done.stderr
