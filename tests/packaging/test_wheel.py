"""The wheel carries the folders that a user sees at the top level, and finds them."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from hdprog.shipped import shipped

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel."""
    out = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory"]
    done = subprocess.run(
        [*command, str(out)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    [built] = out.glob("*.whl")
    return built


def files_below(folder: Path) -> set[str]:
    return {
        file.relative_to(folder).as_posix()
        for file in folder.rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }


@pytest.mark.parametrize("kind", ["priors", "datasets"])
def test_wheel_holds_the_folder_whole(wheel: Path, kind: str) -> None:
    prefix = f"hdprog/_shipped/{kind}/"
    with zipfile.ZipFile(wheel) as archive:
        held = {name.removeprefix(prefix) for name in archive.namelist() if prefix in name}
    assert held
    assert held == files_below(ROOT / kind)


def test_wheel_says_that_it_is_typed_and_under_which_licence(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert "hdprog/py.typed" in names
    assert any(name.endswith("LICENSE") for name in names)
    assert not any(name.startswith("tests") for name in names)


def test_unpacked_wheel_reads_its_own_folders(wheel: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    (tmp_path / "priors").mkdir()  # a folder of this name where the command runs is not ours
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path / 'site')!r})\n"
        "from hdprog.shipped import shipped\n"
        "print(shipped('priors'), shipped('datasets'))"
    )
    done = subprocess.run(
        [sys.executable, "-I", "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    home = tmp_path / "site" / "hdprog" / "_shipped"
    assert done.stdout.split() == [str(home / "priors"), str(home / "datasets")]


def test_checkout_reads_the_folders_people_edit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "priors").mkdir()
    monkeypatch.chdir(tmp_path)
    assert Path(str(shipped("priors"))) == ROOT / "priors"


def test_the_upload_page_is_whole(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        held = set(archive.namelist())
    for folder in ("web/templates", "web/static", "store/migrations"):
        here = files_below(ROOT / "hdprog" / folder)
        assert here
        assert {f"hdprog/{folder}/{name}" for name in here} <= held


def test_without_its_packages_the_upload_page_says_what_to_install(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['sqlalchemy'] = None\n"
        "from hdprog.cli import main; sys.argv = ['hdprog', 'user', 'list']; main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert f"{sys.executable} -m pip install -c constraints.txt '.[web]'" in done.stderr
