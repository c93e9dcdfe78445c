"""Errors end in words and in the exit code of the contract."""

from __future__ import annotations

import errno
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hdprog.errors import BadInputError, UsageError
from tests.cli.conftest import Invoke, Workflow, put_module
from tests.terminal import hear_it_close

BAD_INPUT = BadInputError("no unit", "loop.csv, row 1", "a unit", "Set it with --columns.")


def test_bad_input_ends_with_3_and_writes_nothing(
    invoke: Invoke, workflow: Workflow, tmp_path: Path
) -> None:
    workflow.error = BAD_INPUT
    shown = invoke("run", "drive")
    assert shown.exit_code == 3
    assert "loop.csv, row 1: found no unit; expected a unit. Set it with --columns." in shown.stderr
    assert shown.stdout == ""
    assert list(tmp_path.iterdir()) == []


def test_usage_found_wrong_later_ends_with_2(invoke: Invoke, workflow: Workflow) -> None:
    workflow.error = UsageError("--effects: found 'x', expected an effect's id.")
    assert invoke("run", "drive").exit_code == 2


def test_a_seed_that_no_posterior_can_hold_is_wrong_usage(
    invoke: Invoke, workflow: Workflow
) -> None:
    assert invoke("run", "drive", "--seed", str(2**63 - 1)).exit_code == 0
    assert invoke("run", "drive", "--seed", str(2**63)).exit_code == 2
    assert len(workflow.calls) == 1  # refused before the work


def test_the_package_runs_as_a_module() -> None:
    asked = [sys.executable, "-m", "hdprog", "run"]
    done = subprocess.run(asked, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("Usage: hdprog run")


def test_not_converged_ends_with_4_with_the_report_written(
    invoke: Invoke, workflow: Workflow, tmp_path: Path
) -> None:
    workflow.outcome.converged = False
    shown = invoke("run", "drive")
    assert shown.exit_code == 4
    assert (tmp_path / "hdprog-drive" / "report.html").is_file()
    assert "Not converged" in shown.stderr


def test_a_bug_is_owned_up_to_without_traceback(invoke: Invoke, workflow: Workflow) -> None:
    workflow.error = ZeroDivisionError("float division")
    shown = invoke("run", "drive")
    assert shown.exit_code == 1
    assert "ZeroDivisionError: float division (hdprog/cli/run.py, line" in shown.stderr
    assert "Please report it" in shown.stderr
    assert "Traceback" not in shown.stderr


def test_debug_adds_the_traceback(
    invoke: Invoke, workflow: Workflow, monkeypatch: pytest.MonkeyPatch
) -> None:
    workflow.error = ZeroDivisionError("float division")
    monkeypatch.setenv("HDPROG_DEBUG", "1")
    shown = invoke("run", "drive")
    assert shown.exit_code == 1
    assert "Traceback (most recent call last)" in shown.stderr


def test_interrupt_ends_with_130(invoke: Invoke, workflow: Workflow, tmp_path: Path) -> None:
    workflow.error = KeyboardInterrupt()
    shown = invoke("run", "drive")
    assert shown.exit_code == 130
    assert "Interrupted" in shown.stderr
    assert "a fleet keeps the drives that are finished" in shown.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("sent", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupt_that_a_library_turns_into_an_error_is_no_bug(
    sent: signal.Signals, code: int, invoke: Invoke, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One drawing in ten that was interrupted asked to have it reported."""

    def drawing(*_: object, **__: object) -> None:
        try:
            signal.raise_signal(sent)
        except BaseException:
            raise ValueError("Invalid affine transformation matrix") from None

    put_module(monkeypatch, "hdprog.workflow", run=drawing)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        shown = invoke("run", "drive")
    finally:
        signal.signal(signal.SIGINT, before)
    assert shown.exit_code == code
    assert "mistake" not in shown.stderr
    assert ("Interrupted" in shown.stderr) == (sent == signal.SIGINT)


def test_an_interrupt_of_the_imports_is_no_traceback() -> None:
    """They take half a second, in which somebody sees that the command is the wrong one."""
    code = (
        "import sys\n"
        "class Interrupts:\n"
        "    def find_spec(self, name, *rest):\n"
        "        if name == 'typer':\n"
        "            raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Interrupts())\n"
        "from hdprog.__main__ import main\n"
        "main()\n"
    )
    asked = [sys.executable, "-c", code]
    done = subprocess.run(asked, capture_output=True, text=True, check=False)
    assert done.returncode == 130
    assert done.stderr == "Interrupted before anything was begun.\n"


def test_refused_by_the_system_is_no_bug(invoke: Invoke, workflow: Workflow) -> None:
    workflow.error = PermissionError(13, "Permission denied", "/locked/summary.json")
    shown = invoke("run", "drive")
    assert shown.exit_code == 3
    assert "/locked/summary.json: Permission denied" in shown.stderr


@pytest.mark.parametrize("command", ["check", "fit", "explain", "run", "fleet", "backtest"])
def test_whether_a_path_can_be_read_is_not_settled_by_the_command_line(
    invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    """It was wrong usage, with code 2 and no advice, where the reader's own words are better."""
    path = tmp_path / "loop.csv"
    path.write_text("torque_Nm,angle_rad\n")
    monkeypatch.setattr("os.access", lambda *_, **__: False)  # as a user who is not root meets it
    shown = invoke(command, str(path))
    assert "not readable" not in shown.output


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EFBIG])
def test_a_full_disk_is_no_bug(invoke: Invoke, workflow: Workflow, number: int) -> None:
    workflow.error = OSError(number, "what a write says, which names no file")
    shown = invoke("run", "drive")
    assert shown.exit_code == 3
    assert os.strerror(number) in shown.stderr
    assert "Free space" in shown.stderr


def test_out_that_is_a_file_is_refused_before_the_work(
    invoke: Invoke, workflow: Workflow, tmp_path: Path
) -> None:
    (tmp_path / "taken").write_text("mine", encoding="utf-8")
    shown = invoke("run", "drive", "--out", "taken")
    assert shown.exit_code == 2
    assert workflow.calls == []
    assert (tmp_path / "taken").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("lies", ["drive.toml", "tests.csv"])
@pytest.mark.parametrize("asked", [("fit", "loop.csv"), ("run", "mine"), ("backtest", "mine")])
def test_results_are_not_written_among_the_files_of_a_drive(
    invoke: Invoke, workflow: Workflow, tmp_path: Path, lies: str, asked: tuple[str, ...]
) -> None:
    """They were, without a word."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / lies).touch()
    shown = invoke(*asked, "--out", "mine")
    assert shown.exit_code == 3
    assert f"--out mine: found the {lies} of a drive" in shown.stderr
    assert "Give another folder with --out DIR." in shown.stderr
    assert workflow.calls == []
    assert [file.name for file in (tmp_path / "mine").iterdir()] == [lies]


def test_out_that_is_a_link_to_nothing_is_refused_before_the_work(
    invoke: Invoke, workflow: Workflow, tmp_path: Path
) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "gone")
    shown = invoke("run", "drive", "--out", "link")
    assert shown.exit_code == 2
    assert "whose target is not there" in shown.stderr
    assert workflow.calls == []


@pytest.mark.parametrize("asked", [("fit", "m\udcfcller.csv"), ("run", "d", "--out", "\udcff")])
def test_a_name_that_no_report_can_show_is_refused_before_the_work(
    invoke: Invoke, workflow: Workflow, asked: tuple[str, ...]
) -> None:
    shown = invoke(*asked)
    assert shown.exit_code == 2
    assert "not UTF-8" in shown.stderr
    assert workflow.calls == []


def test_a_closed_pipe_is_quiet() -> None:
    code = (
        "import os, sys, types\n"
        "import hdprog.data\n"
        "read, write = os.pipe(); os.close(read); os.dup2(write, 1)\n"
        "found = types.SimpleNamespace(kind='loop', lines=['two cycles'], ok=True)\n"
        "stand_in = types.ModuleType('hdprog.data.check')\n"
        "stand_in.check_path = lambda path, **options: found\n"
        "sys.modules['hdprog.data.check'] = stand_in\n"
        "from hdprog.cli import app\n"
        "app(['check', 'loop.csv'], prog_name='hdprog')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.returncode == 141


def _runs(process: Path) -> bool:
    """Whether a process is there and no zombie, which in a container nobody may take away."""
    try:
        return (process / "stat").read_text("utf-8").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(sys.platform != "linux", reason="looks for the workers below /proc")
@pytest.mark.parametrize(
    ("sent", "code_of_end"),
    [("SIGTERM", 143), ("SIGHUP", 129), ("SIGKILL", -9)],
)
def test_a_command_that_is_told_to_end_takes_its_workers_along(
    tmp_path: Path, sent: str, code_of_end: int
) -> None:
    code = (
        "import os, sys, time, types\n"
        "from hdprog.parallel import process_executor\n"
        "def run(*_, **options):\n"
        "    with process_executor(2) as executor:\n"
        "        found = list(executor.map(os.getpid_after, [0.5, 0.5]))\n"
        "        print(*found, flush=True)\n"
        "        list(executor.map(time.sleep, [60, 60]))\n"
        "os.getpid_after = lambda seconds: time.sleep(seconds) or os.getpid()\n"
        "os.getpid_after.__module__, os.getpid_after.__qualname__ = 'os', 'getpid_after'\n"
        "stand_in = types.ModuleType('hdprog.workflow')\n"
        "stand_in.run = run\n"
        "sys.modules['hdprog.workflow'] = stand_in\n"
        "import hdprog; hdprog.workflow = stand_in\n"
        "from hdprog.cli import app\n"
        "app(['run', '.', '--out', 'out'], prog_name='hdprog')\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        preexec_fn=hear_it_close,
    ) as command:
        assert command.stdout is not None
        workers = [Path("/proc", one) for one in command.stdout.readline().split()]
        assert len(workers) == 2
        command.send_signal(signal.Signals[sent])
        assert command.wait(30) == code_of_end
    within = time.monotonic() + 10.0  # a killed command cannot wait for them
    while any(_runs(worker) for worker in workers) and time.monotonic() < within:
        time.sleep(0.05)
    assert not any(_runs(worker) for worker in workers)
    assert not (tmp_path / "out").exists()


def test_a_folder_below_a_file_is_refused_before_the_work(
    invoke: Invoke, workflow: Workflow, tmp_path: Path
) -> None:
    (tmp_path / "afile").write_text("x", "utf-8")
    shown = invoke("run", "drive", "--out", "afile/sub/deeper")
    assert shown.exit_code == 2
    assert "found a file at" in shown.stderr
    assert workflow.calls == []


@pytest.mark.parametrize(
    "command",
    [
        "store export axis --out F/x",
        "store backup F/x.tgz",
        "store restore kept.tgz --data F/x",
        "token add rig --data F/x/y",
        "prior show CSF-25-80 --out F/x.png",
        "prior from-catalogue --all --out F",
        "prior from-catalogue --series CSF --size 25 --ratio 80 --out F/x/y.toml",
        "simulate --out F/x",
    ],
)
def test_a_file_where_a_folder_of_the_output_should_be_is_wrong_usage(
    invoke: Invoke, tmp_path: Path, command: str
) -> None:
    """Some ended with exit code 1, as mistakes of the program."""
    (tmp_path / "F").write_text("kept", "utf-8")
    shown = invoke(*command.split())
    assert shown.exit_code == 2
    assert "found a file at " in shown.stderr
    assert "F, expected a folder or nothing there. Give another" in shown.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["F"]


@pytest.mark.parametrize("given", ["inf", "nan", "0"])
def test_an_upload_of_no_size_is_wrong_usage(invoke: Invoke, given: str) -> None:
    """One ended as a mistake of the program, the other in words of ValueError."""
    shown = invoke("serve", "--max-upload-mb", given)
    assert shown.exit_code == 2
    assert f"--max-upload-mb: found {given}, expected a number of megabytes" in shown.stderr


@pytest.mark.parametrize("given", ["nonsense", "localhost", "10.0.0.1/8", "", "127.0.0.1,*"])
def test_what_is_no_proxy_is_wrong_usage(invoke: Invoke, given: str) -> None:
    """It was passed over: every browser then had the proxy's address."""
    shown = invoke("serve", "--proxy", given)
    assert shown.exit_code == 2
    assert f"--proxy: found {given!r}, expected the address" in shown.stderr


@pytest.mark.parametrize("given", ["127.0.0.1", "*", "::1, 10.0.0.0/8"])
def test_what_is_a_proxy_is_taken(invoke: Invoke, given: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        shown = invoke("serve", "--proxy", given, "--port", port)
    assert "--host, --port: found 127.0.0.1" in shown.stderr  # refused for what comes after
