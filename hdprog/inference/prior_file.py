"""Reading of prior files: names in the shipped folder, models of the catalogue, or paths."""

from __future__ import annotations

import difflib
from importlib.resources.abc import Traversable
from pathlib import Path

from hdprog.config import Drive
from hdprog.config.limits import CATALOGUE_STIFFNESSES
from hdprog.errors import BadInputError
from hdprog.inference.catalogue import find_gear, model_key
from hdprog.inference.prior_schema import PriorFile, parse_prior
from hdprog.inference.priors import Prior, RecordScales
from hdprog.shipped import shipped

GENERIC = "generic"
CATALOGUE_FOLDER = "catalogue"


def _shipped_files() -> dict[str, Traversable]:
    """The shipped priors of loops by name; the folder also holds what is none of a loop."""
    folder = shipped("priors")
    files = {
        entry.name.removesuffix(".toml"): entry
        for entry in folder.iterdir()
        if entry.name.endswith(".toml") and "[parameters." in entry.read_text("utf-8")
    }
    for entry in (folder / CATALOGUE_FOLDER).iterdir():
        if entry.name.endswith(".toml"):
            files.setdefault(entry.name.removesuffix(".toml"), entry)
    return dict(sorted(files.items()))


def names() -> list[str]:
    """Names of the shipped priors."""
    return list(_shipped_files())


def name_of_model(model: str, *, types: bool = True) -> str | None:
    """Name of the shipped prior that serves a model, or None.

    A prior with the model's own name comes first, then the one of its series, size and ratio.

    Parameters
    ----------
    model : e.g. "CSF-25-80" or "csg-32-100-2UH"; upper or lower case
    types : whether a type such as "-2UH" may follow the ratio
    """
    known = names()
    for own in (model.strip().lower(), model_key(model, types=types)):
        if own in known:
            return own
    gear = find_gear(model, types=types)
    return gear.name if gear is not None and gear.name in known else None


def read_prior_file(name: str, folder: Path | None = None) -> PriorFile:
    """Read a prior by name in the shipped folder, by a model of the catalogue, or by path.

    Parameters
    ----------
    name : e.g. "csf-25-80", "CSG-32-100", or a path that ends in .toml
    folder : where a relative path starts, e.g. the folder of drive.toml

    Raises
    ------
    BadInputError
        if there is no such prior or its content is not one
    """
    if name.endswith(".toml"):
        path = (folder or Path()) / name
        if not path.is_file():
            raise BadInputError(
                found=f"no file {path}",
                where="[prior] file",
                expected="a prior file (TOML) or a name that `hdprog prior list` shows",
                advice="correct the path; a relative one starts at the folder of drive.toml",
            )
        return parse_prior(path.read_bytes(), str(path))
    served = name_of_model(name, types=False)
    if served is None:
        matches = difflib.get_close_matches(name.lower(), names(), n=1, cutoff=0.7)
        raise BadInputError(
            found=f"no prior called {name!r}",
            where="[prior] file",
            expected="a name such as csf-25-80, a model of the catalogue such as CSG-32-100, "
            "generic, or a path that ends in .toml",
            advice=(f"Did you mean {matches[0]}? " if matches else "")
            + "`hdprog prior list` shows all names; `hdprog prior from-catalogue` makes a prior "
            "of other drives; without [prior] and model it is centred on the record.",
        )
    return parse_prior(_shipped_files()[served].read_bytes(), f"prior file {served}.toml")


def _named(drive: Drive) -> str | None:
    """The prior that a drive's file names, or the one of its model."""
    if drive.prior is not None:
        return str(drive.prior)
    return None if drive.model is None else name_of_model(drive.model)


def prior_file_of(drive: Drive) -> PriorFile:
    """The prior file that a drive's file asks for: a named one, its model's, or the generic one.

    Raises
    ------
    BadInputError
        for a prior that does not exist
    """
    folder = drive.source.parent if drive.source is not None else None
    return read_prior_file(_named(drive) or GENERIC, folder)


def prior_of_drive(drive: Drive, scales: RecordScales) -> tuple[Prior, str | None]:
    """The prior that a drive's file asks for, and a remark for the report.

    A named prior wins, then the drive's model; with neither the prior is centred on the record's
    own secant stiffness and the remark says so.

    Raises
    ------
    BadInputError
        for a prior that does not exist, and for a limit on a stiffness between torques of the
        maker that the prior does not give
    """
    named = _named(drive)
    prior = prior_file_of(drive).prior(scales)
    _require_stretches(drive, None if named is None else prior.catalogue_torques)
    if named is not None:
        return prior, None
    remark = (
        "No model and no prior are declared for the drive"
        if drive.model is None
        else f"No prior is known for model {drive.model}"
    )
    return prior, (
        f"{remark}: the prior is centred on the record's own secant stiffness "
        f"({scales.secant_stiffness:.3g} Nm/rad) with a log-sd of 1.5, so what a test does not "
        "tell stays wide open."
    )


def require_prior(drive: Drive) -> None:
    """Refuse what `prior_of_drive` refuses, before there is a record."""
    prior_of_drive(drive, RecordScales(1.0, 1.0))


def _require_stretches(drive: Drive, torques: tuple[float, float] | None) -> None:
    """Refuse limits on K1 to K3 where the maker's T1 and T2 (Nm) are not known or leave none."""
    reference = drive.reference_torque or drive.rated_torque
    for number, limit in enumerate(drive.limits, start=1):
        if limit.quantity not in CATALOGUE_STIFFNESSES:
            continue
        known = torques is not None
        third = limit.quantity == CATALOGUE_STIFFNESSES[-1]
        if torques is None or (third and (reference is None or reference <= torques[1])):
            torque = "no rated or reference torque"
            if reference is not None:
                torque = f"{reference:g} Nm of reference torque"
            raise BadInputError(
                found=f"a limit on {limit.quantity}, and {torque if known else 'no T1 and T2'}",
                where=f"{drive.source or 'drive settings'}, [[limits]] number {number}",
                expected="a model of the catalogue, whose T1 and T2 are known, and torque beyond "
                "T2 for K3",
                advice='Give model = "CSF-25-80", or whichever it is, and rated_torque_Nm under '
                "[drive], or set the "
                "limit on secant_stiffness_Nm_per_rad with at_torque_Nm.",
            )
