"""Prior files as text: TOML that a person reads and edits."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator

from hdprog.inference.catalogue import CatalogueGear
from hdprog.inference.catalogue_prior import ANCHOR, prior_of_gear
from hdprog.inference.prior_schema import PriorFile
from hdprog.physics.parameters import BY_NAME, NAMES

_LINE = 98


def prior_text(prior: PriorFile, remarks: Iterable[str]) -> str:
    """Text of a prior file.

    Parameters
    ----------
    prior : its content
    remarks : paragraphs of the comment at its head
    """
    lines = [
        line
        for remark in remarks
        for line in textwrap.wrap(remark, _LINE, initial_indent="# ", subsequent_indent="# ")
    ]
    lines += [f"name = {_value(prior.name)}", f"source = {_value(prior.source)}"]
    for name in NAMES:
        spec = getattr(prior.parameters, name).model_dump(exclude_none=True)
        parameter = BY_NAME[name]
        unit = "" if parameter.unit == "-" else f", {parameter.unit}"
        lines += ["", f"[parameters.{name}]  # {parameter.meaning}{unit}"]
        lines += [f"{key} = {_value(value)}" for key, value in spec.items()]
    if prior.catalogue_table:
        lines += ["", "[catalogue]"]
        lines += [f"{key} = {_value(value)}" for key, value in prior.catalogue_table.items()]
    return "\n".join(lines) + "\n"


def _value(value: float | str) -> str:
    if isinstance(value, str):
        escaped = "".join(
            f"\\u{ord(letter):04X}" if ord(letter) < 32 or ord(letter) == 127 else letter
            for letter in value.replace("\\", "\\\\").replace('"', '\\"')
        )
        return f'"{escaped}"'
    return repr(float(value))


FORM = (
    "Each parameter is normal in the logarithm of its size; T_T = scale_Nm * log(1 + exp(x)) with x"
    " normal. How the numbers follow from the catalogue: reports/guide/priors.md."
)


def gear_text(gear: CatalogueGear) -> str:
    """Text of the prior file of an entry of the catalogue."""
    command = (
        f"hdprog prior from-catalogue --series {gear.series[0]} --size {gear.size} "
        f"--ratio {gear.ratio}"
    )
    remarks = [
        f"Prior of a strain wave gear: {gear.words}; from new to heavily worn.",
        f"Made by `{command}` from priors/catalogue.toml; edit a copy of it, not this file.",
        FORM,
    ]
    if ANCHOR in map(str.lower, gear.models):
        remarks.append(f"{ANCHOR.upper()} itself has a prior of its own, {ANCHOR}.toml.")
    return prior_text(prior_of_gear(gear), remarks)


def gear_texts(gears: Iterable[CatalogueGear]) -> Iterator[tuple[str, str]]:
    """File name and text of the prior of each entry."""
    for gear in gears:
        yield f"{gear.name}.toml", gear_text(gear)
