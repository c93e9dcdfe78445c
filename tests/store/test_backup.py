"""A back-up holds everything and is put back whole."""

from __future__ import annotations

import errno
import io
import os
import random
import tarfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hdprog.cli import app
from hdprog.errors import BadInputError, UsageError
from hdprog.store.backup import back_up, restore
from hdprog.store.drives import find_drive
from hdprog.store.store import Store, open_store
from hdprog.store.uploads import TestFacts, list_tests
from tests.store.samples import add_bytes, add_sample


def fill(store: Store) -> None:
    with store.writing() as session:
        drive = add_sample(session)
        add_bytes(session, store.files, drive, b"a,b\n1,2\n", TestFacts(3.0, label="t01"))


def check(store: Store) -> None:
    with store.reading() as session:
        drive = find_drive(session, "cell3-axis2")
        assert drive is not None
        [test] = list_tests(session, drive, "accepted")
        assert store.files.record(test.sha256).read_bytes() == b"a,b\n1,2\n"


def test_sqlite_there_and_back(tmp_path: Path) -> None:
    store = Store(tmp_path / "data")
    store.prepare()
    fill(store)
    archive = tmp_path / "backup.tar.gz"
    assert back_up(store, archive) == archive.stat().st_size
    store.close()
    restore(archive, tmp_path / "again", None)
    again = Store(tmp_path / "again")
    again.prepare()
    check(again)
    again.close()


def test_a_backup_is_its_owners_alone_as_the_data_folder_is(tmp_path: Path) -> None:
    """It holds the hashes of all passwords."""
    store = Store(tmp_path / "data")
    store.prepare()
    archive = tmp_path / "backup.tar.gz"
    left = archive.with_name(f".{archive.name}.part")  # by a backup that was killed
    left.touch(mode=0o644)
    before = os.umask(0o022)
    try:
        back_up(store, archive)
    finally:
        os.umask(before)
        store.close()
    assert archive.stat().st_mode & 0o777 == 0o600
    assert not left.exists()


@pytest.mark.postgres
def test_postgres_there_and_back(
    tmp_path: Path, postgres_url: str, postgres_server: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    import psycopg

    from tests.store.postgres import programs

    # The tools must be of the server's version.
    monkeypatch.setenv("PATH", f"{programs()}:{os.environ['PATH']}")
    store = Store(tmp_path / "data", postgres_url)
    store.prepare()
    fill(store)
    archive = tmp_path / "backup.tar.gz"
    back_up(store, archive)
    store.close()
    with psycopg.connect(postgres_server, autocommit=True) as connection:
        connection.execute("CREATE DATABASE again")
    target = postgres_server.replace("/postgres", "/again")
    restore(archive, tmp_path / "again", target)
    again = Store(tmp_path / "again", target)
    again.prepare()
    check(again)
    again.close()


def test_no_earlier_backup_is_lost(tmp_path: Path) -> None:
    store = Store(tmp_path / "data")
    store.prepare()
    (tmp_path / "backup.tar.gz").write_bytes(b"precious")
    with pytest.raises(UsageError, match="name that is free"):
        back_up(store, tmp_path / "backup.tar.gz")
    store.close()


def test_nothing_is_put_over_data(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "x").touch()
    with pytest.raises(UsageError, match="empty folder"):
        restore(tmp_path / "backup.tar.gz", tmp_path / "data", None)


def test_an_archive_that_climbs_out_is_refused(tmp_path: Path) -> None:
    archive = tmp_path / "evil.tar.gz"
    with tarfile.open(archive, "w:gz") as tar:
        tar.add(__file__, "../evil.py")
    with pytest.raises(BadInputError, match="no readable archive"):
        restore(archive, tmp_path / "data", None)
    assert not (tmp_path / "evil.py").exists()


def archive_of(path: Path, **files: bytes) -> Path:
    with tarfile.open(path, "w:gz") as tar:
        for name, content in files.items():
            entry = tarfile.TarInfo(name.replace("__", "."))
            entry.size = len(content)
            tar.addfile(entry, io.BytesIO(content))
    return path


@pytest.mark.parametrize("there", [True, False])
def test_what_could_not_be_put_back_leaves_nothing(tmp_path: Path, there: bool) -> None:
    data = tmp_path / "data"
    if there:
        data.mkdir()
    noise = random.Random(1).randbytes(300_000)
    whole = archive_of(tmp_path / "whole.tar.gz", hdprog__db=b"tables", raw=noise)
    cut = tmp_path / "cut.tar.gz"
    cut.write_bytes(whole.read_bytes()[:200_000])
    bent = tmp_path / "bent.tar.gz"
    bent.write_bytes(whole.read_bytes()[:100_000] + bytes(200_000))
    dump = archive_of(tmp_path / "dump.tar.gz", database__pgdump=b"dump")
    other = archive_of(tmp_path / "other.tar.gz", readme=b"words")
    before = sorted(tmp_path.rglob("*"))
    nowhere = "postgresql://nobody@127.0.0.1:1/none"
    for archive, url, words in (
        (cut, None, "no readable archive"),
        (bent, None, "no readable archive"),
        (other, None, "without a database"),
        (dump, None, "expected the address of an empty database"),
        (dump, f"sqlite:///{data}/hdprog.db", "expected the address of an empty database"),
        (dump, nowhere, "pg_restore"),
        (whole, nowhere, "HDPROG_DATABASE"),
    ):
        with pytest.raises((BadInputError, UsageError), match=words):
            restore(archive, data, url)
        assert sorted(tmp_path.rglob("*")) == before
    restore(whole, data, None)
    assert (data / "raw").read_bytes() == noise
    assert there or os.name != "posix" or data.stat().st_mode & 0o077 == 0


def test_what_is_written_or_goes_meanwhile_is_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An analysis that ended under the copy had broken it."""
    store = Store(tmp_path / "data")
    store.prepare()
    fill(store)
    analyses = store.files.root / "analyses"
    for name in ("one", "two", ".three.part"):
        (analyses / name).mkdir()
        (analyses / name / "posterior.nc").write_text(name, "utf-8")
    add = tarfile.TarFile.add

    def going(tar: tarfile.TarFile, path: Path, *rest: object, **options: object) -> None:
        if Path(path) == analyses / "one":
            (analyses / "two" / "posterior.nc").unlink(missing_ok=True)
        if Path(path) == analyses / "two":
            raise FileNotFoundError(path)
        add(tar, path, *rest, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(tarfile.TarFile, "add", going)
    back_up(store, tmp_path / "backup.tar.gz")
    store.close()
    with tarfile.open(tmp_path / "backup.tar.gz") as archive:
        names = set(archive.getnames())
    assert "analyses/one/posterior.nc" in names
    assert not [name for name in names if "two" in name or "three" in name]


def test_no_room_for_a_backup_is_told_and_no_fault_of_the_archive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was told to be no readable archive, with the advice to give another one."""
    archive = archive_of(tmp_path / "whole.tar.gz", hdprog__db=b"tables")

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(tarfile.TarFile, "extractall", full)
    with pytest.raises(BadInputError, match=r"no room for what .* Free space"):
        restore(archive, tmp_path / "data", None)
    assert not (tmp_path / "data").exists()


def test_no_room_to_write_a_backup_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The advice was to give another --out, which the command does not have."""

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with open_store(tmp_path / "data") as store:
        monkeypatch.setattr(tarfile.TarFile, "add", full)
        with pytest.raises(BadInputError, match=r"no room for the copy .* give another ARCHIVE\."):
            back_up(store, tmp_path / "backup.tar.gz")
    assert [path.name for path in tmp_path.iterdir()] == ["data"]


@pytest.mark.parametrize(
    "command",
    [
        "store backup backup.tar.gz",
        "store export axis --out axis",
        "user list",
        "user password anna",
        "token list",
        "token revoke robot",
    ],
)
def test_a_folder_without_a_store_has_nothing_to_give(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    """An empty store was made there and backed up, night after night, for the one that counts."""
    monkeypatch.chdir(tmp_path)
    for data in ("slip", "."):
        done = CliRunner().invoke(app, [*command.split(), "--data", data])
        assert done.exit_code == 2
        assert "found no store in" in done.output
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", ["user list", "token add robot", "serve --port 0"])
def test_a_file_in_place_of_the_data_folder_is_no_mistake_of_the_program(
    tmp_path: Path, command: str
) -> None:
    file = tmp_path / "hdprog.db"
    file.write_text("mine")
    done = CliRunner().invoke(app, [*command.split(), "--data", str(file)])
    assert done.exit_code == 2
    assert f"--data: found a file at {file}, expected a folder" in " ".join(done.output.split())
    assert file.read_text() == "mine"
