"""Reading of prior files: names in the shipped folder, or paths."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from hdprog.config import Drive
from hdprog.errors import BadInputError
from hdprog.inference.priors import Prior, RecordScales, log_median
from hdprog.physics.parameters import BY_NAME, NAMES
from hdprog.shipped import shipped

Scale = Literal["secant_stiffness", "largest_torque", "secant_stiffness_per_torque"]
GENERIC = "generic"


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class _LogNormal(_Strict):
    median: float
    median_in: Scale | None = None
    log_sd: float = Field(gt=0, le=5)


class _Softplus(_Strict):
    scale_Nm: float | None = Field(default=None, gt=0)
    scale: float | None = Field(default=None, gt=0)
    scale_in: Literal["largest_torque"] | None = None
    coordinate_mean: float
    coordinate_sd: float = Field(gt=0)

    @model_validator(mode="after")
    def _one_scale(self) -> _Softplus:
        if (self.scale_Nm is None) == (self.scale is None) or (self.scale is None) != (
            self.scale_in is None
        ):
            raise ValueError("give either scale_Nm, or scale together with scale_in")
        return self


class _Parameters(_Strict):
    K_F: _LogNormal
    K_W: _LogNormal
    a: _LogNormal
    b: _LogNormal
    T_T: _Softplus
    c: _LogNormal
    T_i: _LogNormal
    mu: _LogNormal

    @model_validator(mode="after")
    def _signs(self) -> _Parameters:
        for name in NAMES:
            spec = getattr(self, name)
            if isinstance(spec, _LogNormal):
                negative = BY_NAME[name].transform == "negative_log"
                if (spec.median < 0) != negative or spec.median == 0:
                    sign = "negative" if negative else "positive"
                    raise ValueError(f"the median of {name} must be {sign}, not {spec.median:g}")
        return self


class PriorFile(_Strict):
    """Content of a prior file, validated."""

    name: str
    source: str
    parameters: _Parameters
    catalogue: dict[str, float] = Field(default_factory=dict)

    @property
    def needs_record(self) -> bool:
        """Whether a scale is taken from the measured record."""
        specs = [getattr(self.parameters, name) for name in NAMES]
        return any(
            spec.median_in if isinstance(spec, _LogNormal) else spec.scale_in for spec in specs
        )

    def prior(self, scales: RecordScales | None) -> Prior:
        """The prior, with scales of a record filled in where the file asks for them."""
        mean, sd, softplus_scale = np.empty(len(NAMES)), np.empty(len(NAMES)), 1.0
        for index, name in enumerate(NAMES):
            spec = getattr(self.parameters, name)
            if isinstance(spec, _LogNormal):
                factor = scales.factor(spec.median_in) if scales and spec.median_in else 1.0
                mean[index], sd[index] = log_median(name, spec.median * factor), spec.log_sd
            else:
                mean[index], sd[index] = spec.coordinate_mean, spec.coordinate_sd
                if spec.scale_Nm is not None:
                    softplus_scale = spec.scale_Nm
                elif scales is not None and spec.scale is not None:
                    softplus_scale = spec.scale * scales.largest_torque
        return Prior(self.name, mean, sd, softplus_scale, self.source, self.catalogue)


def names() -> list[str]:
    """Names of the shipped priors."""
    return sorted(
        entry.name.removesuffix(".toml")
        for entry in shipped("priors").iterdir()
        if entry.name.endswith(".toml") and "[parameters." in entry.read_text("utf-8")
    )


def read_prior_file(name: str, folder: Path | None = None) -> PriorFile:
    """Read a prior by name in the shipped folder, or by path.

    Parameters
    ----------
    name : e.g. "csf-25-80", or a path that ends in .toml
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
                expected="a prior file (TOML) or one of the names " + ", ".join(names()),
                advice="correct the path; a relative one starts at the folder of drive.toml",
            )
        content = path.read_bytes()
    else:
        if name not in names():
            raise BadInputError(
                found=f"no prior called {name!r}",
                where="[prior] file",
                expected="one of " + ", ".join(names()) + ", or a path that ends in .toml",
                advice="choose one, or leave [prior] out to use one centred on the record",
            )
        content = (shipped("priors") / f"{name}.toml").read_bytes()
    try:
        return PriorFile.model_validate(tomllib.loads(content.decode("utf-8")))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, ValidationError) as error:
        reason = str(error)
        if isinstance(error, ValidationError):
            first = error.errors()[0]
            reason = ".".join(str(part) for part in first["loc"]) + ": " + first["msg"]
        raise BadInputError(
            found=reason,
            where=f"prior file {name}",
            expected="a [parameters.NAME] table for each of " + ", ".join(NAMES),
            advice="compare with a shipped prior such as csf-25-80.toml",
        ) from None


def prior_of_drive(drive: Drive, scales: RecordScales) -> tuple[Prior, str | None]:
    """The prior that a drive's file asks for, and a remark for the report.

    A named prior wins, then the drive's model; with neither the prior is centred on the record's
    own secant stiffness and the remark says so.

    Raises
    ------
    BadInputError
        for a prior that does not exist
    """
    folder = drive.source.parent if drive.source is not None else None
    if drive.prior is not None:
        return read_prior_file(drive.prior, folder).prior(scales), None
    model = drive.model.lower() if drive.model is not None else None
    if model is not None and model in names():
        return read_prior_file(model).prior(scales), None
    remark = (
        "The drive's file names no model and no prior"
        if drive.model is None
        else f"No prior is known for model {drive.model}"
    )
    prior = read_prior_file(GENERIC).prior(scales)
    return prior, (
        f"{remark}: the prior is centred on the record's own secant stiffness "
        f"({scales.secant_stiffness:.3g} Nm/rad) with a log-sd of 1.5, so what a test does not "
        "tell stays wide open."
    )
