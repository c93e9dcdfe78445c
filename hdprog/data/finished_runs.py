"""What finished runs of other drives say of wear, read from their summary.json."""

from __future__ import annotations

import json
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.drive_folders import folders_with
from hdprog.errors import BadInputError
from hdprog.physics.parameters import FloatArray

SUMMARY = "summary.json"
SCHEMA = "hdprog.summary/1"


@dataclass(frozen=True)
class KeptSaid:
    """What a drive's tests say of the deviates z: Λ (k, k), η (k,) of −½ zᵀΛz + ηᵀz."""

    precision: FloatArray
    information: FloatArray


@dataclass(frozen=True)
class KeptIfSteady:
    """The same if the drive's pace is steady, and the log of how much better the tests fit that."""

    said: KeptSaid
    log_odds: float


@dataclass(frozen=True)
class FinishedRun:
    """What the tests of one drive say of its wear, its priors left out.

    Attributes
    ----------
    drive_id, path : of the drive, and the summary that was read
    created : ISO 8601, when it was made
    converged : whether its trend is; what one says that is not does not count
    wear_prior : identity of the wear prior whose deviates z these are
    said : by its tests, of z
    steady : if the drive's pace is steady; None where the run did not keep it
    records : SHA-256 of the records of its tests
    """

    drive_id: str
    path: Path
    created: str
    converged: bool
    wear_prior: str
    said: KeptSaid
    steady: KeptIfSteady | None
    records: frozenset[str] = frozenset()


@dataclass(frozen=True)
class FinishedRuns:
    """Usable runs, the newest of each drive, in order of the drives' ids; and what was left out.

    Attributes
    ----------
    runs : of other drives
    left_out : in words
    doubts : on runs that were left out because their drive's id is another drive's, too
    """

    runs: tuple[FinishedRun, ...]
    left_out: tuple[str, ...]
    doubts: tuple[str, ...] = ()


def read_finished_runs(
    folder: Path, *, own_id: str, wear_prior: str, own_records: Collection[str] = ()
) -> FinishedRuns:
    """Finished runs of other drives below a folder.

    Parameters
    ----------
    folder : searched with all below it for summary.json, links followed
    own_id : of the drive that wants to learn; its own runs do not count
    wear_prior : identity of the wear prior in use; runs under another one do not compare
    own_records : SHA-256 of the records of the drive that wants to learn

    Raises
    ------
    BadInputError
        where there is no such folder, or not one usable run in it
    """
    if not folder.is_dir():
        raise BadInputError(
            found=f"no folder {folder}",
            where="--fleet",
            expected="a folder with finished runs of other drives below it",
            advice="Give the folder that `hdprog run --out` of the other drives wrote into.",
        )
    by_drive: dict[str, list[FinishedRun]] = {}
    left_out, doubts = [], []
    for path in (place / SUMMARY for place in folders_with(SUMMARY, folder)):
        try:
            found = _read(path)
        except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
            left_out.append(f"{path}: not a summary of a finished run ({error})")
            continue
        if found is None:
            continue
        if found.drive_id == own_id:
            if _of_another(found.records, own_records):
                left_out.append(f"{path}: {_SAME_ID}")
                doubts.append(_same_id(found, "the drive that is run here"))
            continue
        if not found.converged:
            left_out.append(f"{path}: its trend did not converge; see its report")
            continue
        if found.wear_prior != wear_prior:
            left_out.append(f"{path}: made with another wear prior; run the drive again")
            continue
        by_drive.setdefault(found.drive_id, []).append(found)
    newest = {name: max(runs, key=lambda run: run.created) for name, runs in by_drive.items()}
    for name, runs in by_drive.items():
        for run in runs:
            if _of_another(run.records, newest[name].records):
                left_out.append(f"{run.path}: {_SAME_ID}")
                doubts.append(_same_id(run, f"that of {newest[name].path}, which counts"))
    if not newest:
        said = "; ".join([*left_out, *(doubt.rstrip(".") for doubt in doubts)])
        raise BadInputError(
            found=f"no finished run of another drive below {folder}"
            + (f": {said}" if said else ""),
            where="--fleet",
            expected="at least one summary.json that `hdprog run` has written for another drive "
            "with a converged trend",
            advice="Run the other drives first, with --out below that folder.",
        )
    runs_in_order = tuple(newest[name] for name in sorted(newest))
    return FinishedRuns(runs_in_order, tuple(left_out), tuple(doubts))


_SAME_ID = "the id of its drive is another drive's, too"


def _of_another(records: Collection[str], known: Collection[str]) -> bool:
    """Whether two runs under one id have no record in common, as two runs of a drive have."""
    return bool(records) and bool(known) and set(known).isdisjoint(records)


def _same_id(run: FinishedRun, other: str) -> str:
    return (
        f'The drive of {run.path} has the id "{run.drive_id}", as has {other}, and they have no '
        "record in common: nothing was learnt from the former. If these are two drives, give each "
        "an id of its own in drive.toml (a copied folder keeps the old one) and run them again."
    )


def _read(path: Path) -> FinishedRun | None:
    """A run with a trend, or None for a summary of anything else."""
    content = json.loads(path.read_text("utf-8"))
    if content.get("schema") != SCHEMA:
        raise ValueError(f'"schema" is {content.get("schema")!r}, not {SCHEMA!r}')
    trend = content.get("trend")
    if trend is None:
        return None
    if "says" not in trend:
        raise ValueError("made by an older version, which did not keep what its tests say of wear")
    says = trend["says"]
    return FinishedRun(
        str(content["drive"]["id"]),
        path,
        str(content["provenance"]["created"]),
        bool(trend["converged"]),
        str(says["wear_prior"]),
        _said(says, len(says["deviates"])),
        _if_steady(says),
        frozenset(map(str, content["provenance"].get("files_sha256", {}).values())),
    )


def _if_steady(says: dict[str, Any]) -> KeptIfSteady | None:
    steady = says.get("steady")
    if steady is None:
        return None
    log_odds = float(steady["log_odds"])
    if not np.isfinite(log_odds):
        raise ValueError("what its tests say of a steady pace is not finite")
    return KeptIfSteady(_said(steady, len(says["deviates"])), log_odds)


def _said(says: dict[str, Any], size: int) -> KeptSaid:
    precision = np.array(says["precision"], dtype=float)
    information = np.array(says["information"], dtype=float)
    if precision.shape != (size, size) or information.shape != (size,):
        raise ValueError(f"what its tests say is not of {size} deviates")
    if not (np.isfinite(precision).all() and np.isfinite(information).all()):
        raise ValueError("what its tests say holds numbers that are not finite")
    if np.linalg.eigvalsh(precision)[0] < -1e-6 * max(1.0, float(np.abs(precision).max())):
        raise ValueError("what its tests say has a negative precision")
    return KeptSaid(precision, information)
