"""Many drives: the list, what is kept, and what is left out."""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from hdprog import fleet_run, workflow
from hdprog.atomic import atomic_directory
from hdprog.errors import BadInputError, HdprogError, UsageError
from hdprog.fleet_run import Fleet, LeftOut, run_fleet
from hdprog.outcome import RUN_KEY, Outcome, results_in
from hdprog.packed import packed, unpack, unpacked
from hdprog.shipped import shipped
from hdprog.trend import fitting
from tests.hasty import HASTY, SHORT
from tests.reporting.page import Page
from tests.workflow.test_run import edit, subset


@pytest.fixture(scope="module")
def runs() -> dict[str, Outcome]:
    """Outcomes that were had already: what is written of them is tried, not the runs."""
    return {}


@pytest.fixture(name="folder")
def folder_fixture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, runs: dict[str, Outcome]
) -> Path:
    """A worn drive past its limit, one that has one test, and a broken folder."""
    monkeypatch.setattr(workflow, "QUICK", SHORT)
    monkeypatch.setattr(fitting, "JOINT_QUICK", HASTY)
    run_drive = workflow.run

    def once(path: Path, **options: object) -> Outcome:
        given = (path / "drive.toml").read_text("utf-8") + repr(sorted(options.items()))
        if given not in runs:
            runs[given] = run_drive(path, **options)  # type: ignore[arg-type]
        return runs[given]

    monkeypatch.setattr(workflow, "run", once)
    fleet = tmp_path / "fleet"
    worn = subset(fleet / "cell1" / "worn", ["t10"])
    edit(worn, 'id = "wearing-csf-25-80"', 'id = "worn"')
    edit(worn, "above = 2.0", "above = 0.5")
    subset(fleet / "cell2", ["t01"])
    (fleet / "broken").mkdir()
    (fleet / "broken" / "drive.toml").write_text("x", "utf-8")
    return fleet


def run(folder: Path, out: Path, **options: object) -> Fleet:
    return run_fleet(folder, out, quick=True, explain=False, workers=1, **options)  # type: ignore[arg-type]


def test_drives_are_listed_worst_first_and_kept(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = folder / "out"  # inside the fleet: its results are no drives
    steps: list[tuple[str, int, int]] = []
    found = run(folder, out, progress=lambda *step: steps.append(step))
    content = json.loads((out / "fleet.json").read_text("utf-8"))
    assert content == found.content
    assert content["schema"] == "hdprog.fleet/1"
    assert [drive["folder"] for drive in content["drives"]] == ["cell1/worn", "cell2"]
    assert [one["folder"] for one in content["left_out"]] == ["broken"]
    assert content["warnings"] == []
    assert "TOML" in content["left_out"][0]["reason"]
    worst = content["drives"][0]
    assert worst["status"] == "act"
    assert worst["id"] == "worn"
    assert (out / worst["report"]).is_file()
    assert (out / worst["summary"]).is_file()
    assert "2 drives: 1 needs action now; 1 needs a second test" in found.sentence
    assert "1 folder could not be used" in found.sentence
    assert steps == [("drives", 0, 2), ("drives", 1, 2), ("drives", 2, 2)]
    page = Page((out / "index.html").read_text("utf-8"))
    assert page.text.index("worn") < page.text.index("cell2")

    def no_run(*_: object, **__: object) -> None:
        raise AssertionError("a drive was run again")

    # What a run ends with 4 for, a fleet does: here the drive model alone did not settle.
    explained = out / "drives" / "cell2" / "explain.json"
    explained.write_text(json.dumps({"converged": False}), "utf-8")
    assert all(drive["converged"] for drive in content["drives"]) == found.converged
    doubtful = fleet_run._content(
        folder,
        fleet_run._orders(folder, out, 0, True, False)[0],
        [],
        seed=0,
        quick=True,
        command="",
    )
    assert [one["explanation_converged"] for one in doubtful["drives"]] == [True, False]
    assert not Fleet(out, doubtful).converged
    explained.unlink()

    again = []
    with monkeypatch.context() as patch:
        patch.setattr(workflow, "run", no_run)
        kept = run(folder, out)
        assert kept.content["drives"] == content["drives"]
        # Another seed or a changed file makes a drive anew.
        order = fleet_run._orders(folder, out, 1, True, False)[0]
        again.append([one.finished for one in order])
        edit(folder / "cell2", "above = 2.0", "above = 1.9")
        order = fleet_run._orders(folder, out, 0, True, False)[0]
        again.append([one.finished for one in order])
    assert again == [[False, False], [True, False]]


def test_drives_behind_links_are_found_once(folder: Path, tmp_path: Path) -> None:
    linked = tmp_path / "linked"
    linked.mkdir()
    (linked / "a").symlink_to(folder / "cell2")
    (linked / "b").symlink_to(folder / "cell1")
    (folder / "cell1" / "back").symlink_to(linked)  # a ring
    found = fleet_run._orders(linked, tmp_path / "out", 0, True, False)[0]
    assert [order.name for order in found] == ["a", "b/worn"]


def test_results_may_lie_beside_the_drives_or_above(folder: Path, tmp_path: Path) -> None:
    for out in (folder, tmp_path):
        found = fleet_run._orders(folder, out, 0, True, False)[0]
        assert [order.name for order in found] == ["cell1/worn", "cell2"]


def test_of_two_names_of_a_folder_the_first_by_letter_counts(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Results are kept by name: another one on another day would be run anew."""
    (folder / "another").symlink_to(folder / "cell2")
    walk = os.walk

    def backwards(top: Path, *, followlinks: bool) -> Iterator[tuple[str, list[str], list[str]]]:
        for place, inner, files in walk(top, followlinks=followlinks):
            inner.sort(reverse=True)
            yield place, inner, files

    monkeypatch.setattr(os, "walk", backwards)
    found = fleet_run._orders(folder, tmp_path / "out", 0, True, False)[0]
    assert [order.name for order in found] == ["another", "cell1/worn"]


def test_results_are_not_put_among_a_drives_own_records(folder: Path, tmp_path: Path) -> None:
    drives = folder.rename(tmp_path / "drives")
    with pytest.raises(BadInputError, match="among its own records"):
        run(drives, tmp_path)


def test_another_prior_makes_a_drive_anew(folder: Path, tmp_path: Path) -> None:
    worn = folder / "cell1" / "worn"
    own = worn / "own.toml"
    shutil.copyfile(shipped("priors") / "csf-25-80.toml", own)
    edit(worn, 'file = "csf-25-80"', 'file = "own.toml"')
    before = fleet_run._key(worn, 0, True, False)
    assert fleet_run._key(worn, 0, True, False) == before
    text = own.read_text("utf-8")
    own.write_text(text.replace("log_sd = 0.4", "log_sd = 0.5", 1), "utf-8")
    assert fleet_run._key(worn, 0, True, False) != before
    own.unlink()
    with pytest.raises(BadInputError, match=r"own\.toml"):
        fleet_run._key(worn, 0, True, False)


def test_the_work_goes_out_packed_and_comes_back_packed(folder: Path, tmp_path: Path) -> None:
    """What a machine of a cluster does, without the cluster."""
    order = fleet_run._orders(folder, tmp_path / "out", 0, True, False)[0][1]
    results = fleet_run.run_packed(packed(order.folder), order, "hdprog fleet")
    assert isinstance(results, bytes)
    (tmp_path / "back").mkdir()
    unpack(results, tmp_path / "back")
    assert (tmp_path / "back" / "report.html").is_file()
    assert not order.out.exists()


def test_a_drive_with_links_is_sent_with_what_they_lead_to(tmp_path: Path) -> None:
    """A link out of the folder, of whatever, had it left out for want of memory."""
    drive = subset(tmp_path / "drive", ["t01"])
    own = (shipped("priors") / "csf-25-80.toml").read_text("utf-8")
    (drive / "own.toml").write_text(own, "utf-8")
    edit(drive, 'file = "csf-25-80"', 'file = "own.toml"')
    (drive / "drive.toml").rename(tmp_path / "shared.toml")
    (drive / "drive.toml").symlink_to(tmp_path / "shared.toml")
    (drive / "loops").rename(drive / "raw")
    (drive / "loops").symlink_to(drive / "raw")
    (drive / "fleet").symlink_to(tmp_path)
    (drive / "own.toml").rename(tmp_path / "own.toml")
    (drive / "own.toml").symlink_to(tmp_path / "own.toml")
    with unpacked(fleet_run.pack_drive(drive), "drive") as (there, _):
        found = {path.relative_to(there).as_posix(): path for path in there.rglob("*.*")}
        assert set(found) == {"drive.toml", "tests.csv", "own.toml", "loops/t01.csv"}
        for name, path in found.items():
            assert path.read_bytes() == (drive / name).read_bytes()
        assert fleet_run._key(there, 0, True, False) == fleet_run._key(drive, 0, True, False)


def test_a_drive_that_cannot_be_sent_leaves_the_others_their_run(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A prior beside the folder was not found where it was sent to; a lost file ended the fleet."""
    orders = fleet_run._orders(folder, tmp_path / "out", 0, True, False)[0]
    shutil.copyfile(shipped("priors") / "csf-25-80.toml", folder / "cell1" / "own.toml")
    edit(folder / "cell1" / "worn", 'file = "csf-25-80"', 'file = "../own.toml"')
    sent = packed(folder / "cell2")
    monkeypatch.setattr(fleet_run, "run_packed", lambda *_: sent)
    with ThreadPoolExecutor(1) as cluster:
        left, kept = fleet_run._spread_packed(cluster, orders, "hdprog fleet")
    assert kept is None
    assert left is not None
    assert left.name == "cell1/worn"
    assert "found the prior ../own.toml, outside the drive folder" in left.reason
    assert "Copy it into the folder" in left.reason


def test_a_drive_of_any_name_is_sent_apart_from_its_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Records of a drive called results came back among its results; one at . could not be sent."""

    def run_aside(order: fleet_run.Order, *_: object) -> None:
        assert order.folder.name == "results"
        assert (order.folder / "drive.toml").is_file()
        order.out.mkdir()
        (order.out / "summary.json").write_text("{}", "utf-8")

    monkeypatch.setattr(fleet_run, "_run_one", run_aside)
    drive = subset(tmp_path / "results", ["t01"])
    monkeypatch.chdir(drive)
    for place in (tmp_path, Path()):
        [order] = fleet_run._orders(place, tmp_path / "out", 0, True, False)[0]
        sent = fleet_run.run_packed(packed(order.folder), order, "hdprog fleet")
        assert isinstance(sent, bytes)
        back = Path(tempfile.mkdtemp(dir=tmp_path))
        unpack(sent, back)
        assert [path.name for path in back.iterdir()] == ["summary.json"]
        shutil.rmtree(back)


def test_a_drive_whose_summary_was_removed_is_run_again(folder: Path, tmp_path: Path) -> None:
    """The fleet had no list until its other file was found and removed, too."""
    order = fleet_run._orders(folder, tmp_path / "out", 0, True, False)[0][1]
    order.out.mkdir(parents=True)
    (order.out / RUN_KEY).write_text(order.key + "\n", "utf-8")
    assert not order.finished
    (order.out / "summary.json").write_text("{}", "utf-8")
    assert order.finished


class _Written:
    """What a run hands back, without the run."""

    def write(self, out: Path, *_: object) -> None:
        with atomic_directory(out, results_in(out)) as aside:
            for name in ("report.html", "summary.json"):
                (aside / name).write_text("{}", "utf-8")


@pytest.mark.parametrize("on_cluster", [False, True])
def test_results_that_were_half_kept_are_nobodys(
    on_cluster: bool, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed in between, a new key stood beside an old summary, or an old key beside a new one."""
    monkeypatch.setattr(workflow, "run", lambda *_, **__: _Written())
    order = fleet_run._orders(folder, tmp_path / "out", 0, True, False)[0][1]
    order.out.mkdir(parents=True)
    for name, text in (("summary.json", "{}"), (RUN_KEY, "of before\n")):
        (order.out / name).write_text(text, "utf-8")
    replace_file = Path.replace

    def killed(path: Path, target: Path) -> Path:
        if target == order.out / "summary.json":
            raise KeyboardInterrupt
        return replace_file(path, target)

    monkeypatch.setattr(Path, "replace", killed)
    with ThreadPoolExecutor(1) as cluster:
        spread = fleet_run._spread_packed if on_cluster else fleet_run._spread
        with pytest.raises(KeyboardInterrupt):
            list(spread(cluster, [order], "hdprog fleet"))
    assert (order.out / "report.html").is_file()
    assert not (order.out / RUN_KEY).exists()
    assert not order.finished
    monkeypatch.setattr(Path, "replace", replace_file)
    with ThreadPoolExecutor(1) as cluster:
        assert list(spread(cluster, [order], "hdprog fleet")) == [None]
    assert order.finished


def _begin(order: fleet_run.Order, *_: object) -> None:
    """A worker in the middle of writing."""
    with atomic_directory(order.out, results_in(order.out)) as aside:
        (aside / "report.html").write_text("half", "utf-8")
        time.sleep(60.0)


def test_an_interrupt_leaves_nothing_half_written(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Workers are ended without a word: their hidden folders stayed, against what was said."""
    monkeypatch.setattr(fleet_run, "_run_one", _begin)
    results = tmp_path / "out" / "drives"
    results.joinpath("cell2").mkdir(parents=True)  # where files move in one by one

    def interrupted(*_: object) -> None:
        within = time.monotonic() + 30.0
        while len(list(results.rglob("report.html"))) < 2 and time.monotonic() < within:
            time.sleep(0.01)
        raise KeyboardInterrupt

    monkeypatch.setattr(fleet_run, "as_completed", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_fleet(folder, tmp_path / "out", quick=True, explain=False, workers=2)
    assert [path for path in results.rglob("*") if not path.is_dir()] == []
    assert sorted(path.name for path in results.rglob("*")) == ["cell1", "cell2"]


@pytest.mark.parametrize("on_cluster", [False, True])
def test_a_disk_that_is_full_is_told_of_the_drive_that_it_was_full_for(
    on_cluster: bool, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The list had a number and no advice; from a cluster it ended the fleet without a list."""
    monkeypatch.setattr(workflow, "run", lambda *_, **__: _Written())
    order = fleet_run._orders(folder, tmp_path / "out", 0, True, False)[0][1]

    def full(_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(fleet_run, "_kept", full)
    spread = fleet_run._spread
    if on_cluster:
        spread = fleet_run._spread_packed
        monkeypatch.setattr(fleet_run, "run_packed", lambda *_: packed(folder / "cell2"))
    with ThreadPoolExecutor(1) as cluster:
        [found] = spread(cluster, [order], "hdprog fleet")
    assert found is not None
    assert found.reason.startswith("no room for its results (No space left on device). Free space")
    content = {"drives": [], "left_out": [{"folder": found.name, "reason": found.reason}]}
    assert Fleet(tmp_path, content).broken


def test_a_dask_cluster_runs_the_drives(folder: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    shutil.rmtree(folder / "broken")
    results = tmp_path / "out" / "drives" / "cell2"
    results.mkdir(parents=True)
    for name in ("summary.json", "explain.json"):
        (results / name).write_text("{}", "utf-8")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        found = run(folder, tmp_path / "out", dask=cluster.scheduler_address)
    assert [drive["folder"] for drive in found.content["drives"]] == ["cell1/worn", "cell2"]
    assert (tmp_path / "out" / "drives" / "cell2" / "report.html").is_file()
    assert not (results / "explain.json").exists()  # it was not made anew


def test_results_of_a_run_by_itself_are_not_the_fleets(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "summary.json").write_text("{}", "utf-8")
    (out / RUN_KEY).write_text("of a fleet's run", "utf-8")
    workflow.run(folder / "cell2", quick=True, explain=False, workers=1).write(out)
    assert not (out / RUN_KEY).exists()


def test_folders_without_a_usable_drive_are_refused(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"no drive\.toml below it"):
        run(tmp_path / "fleet" / "cell2" / "loops", tmp_path / "out")
    with pytest.raises(BadInputError, match="Left out: broken: "):  # not Broken
        run(folder / "broken", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_scheduler_that_does_not_answer_is_said(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed")

    def nobody(*_: object, **__: object) -> None:
        raise OSError("timed out")

    monkeypatch.setattr(distributed, "Client", nobody)
    with pytest.raises(UsageError, match="no scheduler at tcp://nobody:8786"):
        run(folder, tmp_path / "out", dask="tcp://nobody:8786")


def test_tls_without_certificates_is_wrong_usage(folder: Path, tmp_path: Path) -> None:
    """It ended as a mistake of the program."""
    pytest.importorskip("distributed")
    with pytest.raises(UsageError, match=r"certificates in Dask's configuration"):
        run(folder, tmp_path / "out", dask="tls://127.0.0.1:8786")


@pytest.mark.parametrize("address", ["nobody", "tcp://nobody", "tcp://nobody:port", "no://a:1"])
def test_what_is_no_address_of_a_scheduler_makes_no_client(
    address: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that is half made waits 20 s at its end, and prints a traceback."""
    distributed = pytest.importorskip("distributed")

    def made(*_: object, **__: object) -> None:
        raise AssertionError("a client was made")

    monkeypatch.setattr(distributed, "Client", made)
    with pytest.raises(UsageError, match=f"no scheduler at {address}"):
        run(folder, tmp_path / "out", dask=address)


def test_a_mistake_with_one_drive_leaves_the_others_their_list(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = workflow.run

    def wrong(path: Path, **options: object) -> object:
        if path.name == "worn":
            raise ZeroDivisionError("planted")
        return right(path, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(workflow, "run", wrong)
    found = run(folder, tmp_path / "out")
    assert [drive["folder"] for drive in found.content["drives"]] == ["cell2"]
    reasons = {one["folder"]: one["reason"] for one in found.content["left_out"]}
    assert reasons["cell1/worn"] == "a mistake in hdprog: ZeroDivisionError: planted"
    assert found.broken
    assert (tmp_path / "out" / "index.html").is_file()


@pytest.mark.parametrize("reason", [fleet_run._DIED, f"{fleet_run._MISTAKE}: planted"])
def test_a_fleet_that_fails_by_no_fault_of_its_files_is_no_bad_input(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reason: str
) -> None:
    monkeypatch.setattr(fleet_run, "_run_one", lambda order, *_: LeftOut(order.name, reason))
    with pytest.raises(HdprogError, match="no fault of its files") as raised:
        run(folder, tmp_path / "out")
    assert reason in str(raised.value)
    assert raised.value.exit_code == 1
    assert not (tmp_path / "out").exists()
    left_out = [{"folder": "worn", "reason": reason}]
    assert Fleet(tmp_path, {"drives": [], "left_out": left_out}).broken


def test_every_word_of_a_prior_counts(tmp_path: Path) -> None:
    """Also the scale of the softplus, which means and spreads do not show."""
    folder = subset(tmp_path / "own", ["t01"])
    text = (shipped("priors") / "csf-25-80.toml").read_text("utf-8")
    keys = []
    for scale in ("10.0", "40.0"):
        changed = re.sub(r"scale_Nm = [0-9.]+", f"scale_Nm = {scale}", text)
        (folder / "own.toml").write_text(changed, "utf-8")
        if not keys:
            edit(folder, 'file = "csf-25-80"', 'file = "own.toml"')
        keys.append(fleet_run._key(folder, 0, True, False))
    assert keys[0] != keys[1]
