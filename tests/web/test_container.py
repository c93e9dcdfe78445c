"""The Dockerfile of the page on running the service, as far as it goes without Docker.

Its lines are run here, but for what prepares its base image: `useradd` and `install`.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
import urllib.request
import venv
from pathlib import Path

import pytest

from tests.store.postgres import free_port
from tests.web.guide import snippet
from tests.web.server import PATIENCE

ROOT = Path(__file__).resolve().parents[2]


def instructions() -> dict[str, list[str]]:
    """Give what follows each instruction, by its word."""
    found: dict[str, list[str]] = {}
    for line in snippet("dockerfile").splitlines():
        word, _, rest = line.partition(" ")
        found.setdefault(word, []).append(rest)
    return found


@pytest.fixture(scope="module")
def context(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel where the Dockerfile looks for it."""
    place = tmp_path_factory.mktemp("context")
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory"]
    subprocess.run([*command, str(place / "dist")], cwd=ROOT, check=True, capture_output=True)
    return place


@pytest.fixture(scope="module")
def installed(context: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run the line of pip in an environment of its own; gives the folder of its programs."""
    place = tmp_path_factory.mktemp("image")
    venv.create(place, with_pip=True)
    [site] = place.glob("lib/*/site-packages")
    # The packages beside hdprog are found where these tests have them, not fetched again.
    ours = [path for path in sys.path if path.endswith("site-packages")]
    (site / "beside.pth").write_text("\n".join(ours), "utf-8")
    [(source, target)] = [line.split() for line in instructions()["COPY"]]
    [wheel] = context.glob(source)
    (place / "tmp").mkdir()
    (place / "tmp" / wheel.name).write_bytes(wheel.read_bytes())
    assert target == "/tmp/"
    [line] = [line for line in instructions()["RUN"] if "pip install" in line]
    subprocess.run(
        ["sh", "-euc", line.replace("/tmp/", f"{place}/tmp/")],
        check=True,
        env={**os.environ, "PATH": f"{place / 'bin'}:{os.environ['PATH']}"},
    )
    assert not list((place / "tmp").iterdir())
    return place / "bin"


def test_what_it_starts_is_well(installed: Path, tmp_path: Path) -> None:
    said = instructions()
    [command], [check], port = said["CMD"], said["HEALTHCHECK"], str(free_port())
    words = json.loads(command)
    [settings] = said["ENV"]
    environment = {
        **os.environ,
        **dict(re.findall(r"(\w+)=(\S+)", settings)),
        "PATH": f"{installed}:{os.environ['PATH']}",
        "HDPROG_DATA": str(tmp_path / "data"),
    }
    assert said["VOLUME"] == [re.findall(r"HDPROG_DATA=(\S+)", settings)[0]]
    assert said["EXPOSE"] == ["8000"]
    assert said["USER"] == ["hdprog"]
    assert words[words.index("--host") + 1] == "0.0.0.0"
    started = subprocess.Popen(
        [str(installed / words[0]), *words[1:], "--port", port], env=environment, cwd=tmp_path
    )
    asks = check.removeprefix("CMD ").replace(":8000/", f":{port}/")
    ends = time.monotonic() + PATIENCE
    try:
        while subprocess.run(["sh", "-euc", asks], env=environment, check=False).returncode != 0:
            assert started.poll() is None, "it ended while it started"
            assert time.monotonic() < ends
            time.sleep(0.5)
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/login") as answer:
            assert b"Log in" in answer.read()
    finally:
        started.terminate()
        started.wait(PATIENCE)
    assert (tmp_path / "data" / "hdprog.db").is_file()


def test_the_program_is_the_wheels(installed: Path, tmp_path: Path) -> None:
    code = "import hdprog; print(hdprog.__file__)"
    done = subprocess.run(
        [str(installed / "python"), "-c", code],
        cwd=tmp_path,
        check=True,
        capture_output=True,
        text=True,
    )
    assert Path(done.stdout.strip()).is_relative_to(installed.parent)
