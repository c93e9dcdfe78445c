"""Form of a prior file, checked: what is wrong in one is said in words."""

from __future__ import annotations

import difflib
import tomllib
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails, PydanticCustomError

from hdprog.config.as_written import as_written
from hdprog.errors import BadInputError
from hdprog.inference.priors import Prior, RecordScales, log_median
from hdprog.physics.parameters import BY_NAME, NAMES

Scale = Literal["secant_stiffness", "largest_torque", "secant_stiffness_per_torque"]


def _refusal(found: str, expected: str, advice: str) -> PydanticCustomError:
    """What a check of several values together has to say; `found` goes on after the table's key."""
    words = {"found": found, "expected": expected, "advice": advice}
    return PydanticCustomError("in_words", "{found}", words)


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
            given = [k for k in ("scale_Nm", "scale", "scale_in") if getattr(self, k) is not None]
            raise _refusal(
                ": " + ("with " + " and ".join(given) if given else "no scale"),
                "either scale_Nm, or scale together with scale_in",
                'Write scale_Nm = 10.0, or scale = 0.15 and scale_in = "largest_torque".',
            )
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
                    raise _refusal(
                        f".{name}.median = {spec.median:g}",
                        f"a {sign} number ({name} is the {BY_NAME[name].meaning})",
                        f"Correct it: the median of {name} must be {sign}, not {spec.median:g}.",
                    )
        if self.mu.median >= 1:
            raise _refusal(
                f".mu.median = {self.mu.median:g}",
                "a number below 1, from which on the teeth lock at every tooth angle",
                "Tooth friction coefficients are about 0.05 to 0.2.",
            )
        return self


class _Catalogue(_Strict):
    T1_Nm: float | None = Field(default=None, gt=0)
    T2_Nm: float | None = Field(default=None, gt=0)
    K1_Nm_per_rad: float | None = Field(default=None, gt=0)
    K2_Nm_per_rad: float | None = Field(default=None, gt=0)
    K3_Nm_per_rad: float | None = Field(default=None, gt=0)
    rated_torque_Nm: float | None = Field(default=None, gt=0)
    average_torque_Nm: float | None = Field(default=None, gt=0)
    repeated_peak_torque_Nm: float | None = Field(default=None, gt=0)
    momentary_peak_torque_Nm: float | None = Field(default=None, gt=0)
    ratcheting_torque_Nm: float | None = Field(default=None, gt=0)

    @model_validator(mode="after")
    def _ranges(self) -> _Catalogue:
        if (self.T1_Nm is None) != (self.T2_Nm is None):
            raise _refusal(
                f": only {'T2_Nm' if self.T1_Nm is None else 'T1_Nm'}",
                "T1_Nm and T2_Nm, or neither",
                "K1, K2 and K3 are read between these two torques: add the other one.",
            )
        if self.T1_Nm is not None and self.T2_Nm is not None and self.T1_Nm >= self.T2_Nm:
            raise _refusal(
                f".T1_Nm = {self.T1_Nm:g} and T2_Nm = {self.T2_Nm:g}",
                "T1_Nm below T2_Nm",
                "Exchange them if they were swapped.",
            )
        return self


class PriorFile(_Strict):
    """Content of a prior file, validated."""

    name: str = Field(min_length=1)
    source: str = Field(min_length=1)
    parameters: _Parameters
    catalogue: _Catalogue = Field(default_factory=_Catalogue)

    @property
    def catalogue_table(self) -> dict[str, float]:
        """The maker's figures by name (T1_Nm, K1_Nm_per_rad, …), those that are given."""
        return self.catalogue.model_dump(exclude_none=True)

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
        return Prior(self.name, mean, sd, softplus_scale, self.source, self.catalogue_table)


def parse_prior(content: bytes, where: str) -> PriorFile:
    """Check the content of a prior file.

    Parameters
    ----------
    content : bytes of the file
    where : the file, for messages

    Raises
    ------
    BadInputError
        what was found, where, what was expected, and what to do
    """
    try:
        table = tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise BadInputError(
            f"bytes that are no text ({error.reason} at byte {error.start})",
            where,
            "a prior in TOML, saved as UTF-8",
            "Save it as UTF-8, or take a copy of a shipped one.",
        ) from None
    except tomllib.TOMLDecodeError as error:
        raise BadInputError(
            f"text that is not valid TOML ({error})",
            where,
            "a prior in TOML",
            "Correct that place; `hdprog prior from-catalogue` shows the form.",
        ) from None
    try:
        return PriorFile.model_validate(table)
    except ValidationError as error:
        raise _in_words(error, where) from None


# What Pydantic's types of error mean to somebody who wrote the file by hand.
_EXPECTED = {
    "float_type": "a number without quotation marks",
    "float_parsing": "a number without quotation marks",
    "finite_number": "a finite number",
    "string_type": "text in quotation marks",
    "string_too_short": "text that is not empty",
    "model_type": "a table",
    "model_attributes_type": "a table",
}


def _in_words(error: ValidationError, where: str) -> BadInputError:
    """Turn what Pydantic refused first into the words of this project."""
    # A key that is not known comes first: it is often the one that another one misses.
    details = sorted(error.errors(), key=lambda detail: detail["type"] != "extra_forbidden")
    first = details[0]
    key = ".".join(str(part) for part in first["loc"])
    found, expected, advice = _reason(first, key)
    unknown = first["type"] == "extra_forbidden"
    more = len(details) - 1
    if more and not unknown:
        advice += f" {more} more {'value is' if more == 1 else 'values are'} wrong in the file."
    elif unknown and any(detail["type"] == "missing" for detail in details):
        missing = [
            ".".join(map(str, detail["loc"])) for detail in details if detail["type"] == "missing"
        ]
        found += f", and no {missing[0]}"
    return BadInputError(found, where, expected, advice)


def _reason(detail: ErrorDetails, key: str) -> tuple[str, str, str]:
    """What was found, what was expected, what to do."""
    kind, limits = detail["type"], detail.get("ctx", {})
    if kind == "in_words":
        return f"{key}{limits['found']}", limits["expected"], limits["advice"]
    if kind == "missing":
        return f"no {key}", f"{key} to be given{_form(key)}", f"Add {key}."
    if kind == "extra_forbidden":
        known = _known_keys(detail["loc"])
        matches = difflib.get_close_matches(str(detail["loc"][-1]), known, n=1, cutoff=0.5)
        advice = f"Did you mean {matches[0]}?" if matches else "Remove it or correct its name."
        return f"the key {key}, which is not known here", "only " + ", ".join(known), advice
    bounds = [
        f"{words} {limits[name]:g}"
        for name, words in (("gt", "greater than"), ("le", "at most"))
        if name in limits
    ]
    expected = _EXPECTED.get(kind) or (
        "a number " + " and ".join(bounds) if bounds else detail["msg"].lower()
    )
    return f"{key} = {as_written(detail['input'])}", expected, f"Correct {key}."


def _form(key: str) -> str:
    """A word on the form of a table or a value that is missing."""
    last = key.rpartition(".")[2]
    if last == "parameters":
        return ": a [parameters.NAME] table for each of " + ", ".join(NAMES)
    if last in BY_NAME:
        log_normal = "median and log_sd"
        values = "a scale, coordinate_mean and coordinate_sd" if last == "T_T" else log_normal
        return f", a table with {values}, one for each of " + ", ".join(NAMES)
    return ""


def _known_keys(location: tuple[int | str, ...]) -> list[str]:
    """Keys that the table at a place in the file may hold."""
    model: type[BaseModel] = PriorFile
    for part in location[:-1]:
        annotation = model.model_fields[str(part)].annotation
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            model = annotation
    return list(model.model_fields)
