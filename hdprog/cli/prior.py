"""`hdprog prior`: what is assumed of a drive before its tests: list it, see it, make it."""

from __future__ import annotations

import math
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from hdprog.cli.common import command_line, nearest_folder, print_json
from hdprog.cli.options import AsJson, Seed
from hdprog.errors import UsageError

if TYPE_CHECKING:
    from hdprog.inference.prior_predictive import PriorPredictive
    from hdprog.physics.parameters import FloatArray

prior = typer.Typer(
    help="List, check, draw and make priors.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

_KINDS: dict[str, Literal["png", "svg"]] = {".png": "png", ".svg": "svg"}


@prior.command("list")
def list_priors(as_json: AsJson = False) -> None:
    """List the shipped priors and what each serves."""
    from hdprog.inference.catalogue import gears
    from hdprog.inference.prior_file import names, read_prior_file

    served: dict[str, list[str]] = {name: [] for name in names()}
    for gear in gears():
        for model in gear.models:
            own = model.lower()
            served[own if own in served else gear.name].append(model)
    if as_json:
        print_json(
            {
                "schema": "hdprog.priors/1",
                "priors": [{"name": name, "models": models} for name, models in served.items()],
            }
        )
        return
    words = {gear.name: gear.words for gear in gears()}
    for name, models in served.items():
        if name not in words:
            source = read_prior_file(name).source
            words[name] = f"{', '.join(models)}: {source}" if models else source
        typer.echo(f"{name:<11} {words[name]}")


@prior.command("show")
def show(
    name: Annotated[
        str,
        typer.Argument(help="A name, a model such as CSF-25-80, or a path that ends in .toml."),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Draw it into this picture (.png or .svg)."),
    ] = None,
    alpha_deg: Annotated[
        float, typer.Option("--alpha-deg", help="Gear-tooth angle in degrees.")
    ] = 30.0,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Check a prior and say, or draw, what it means.

    The parameters' quantiles and what follows from them: stiffness beside the catalogue's,
    hysteresis width and lost motion; with --out the loops that it expects.
    """
    if out is not None and out.suffix.lower() not in _KINDS:
        raise UsageError(
            f"--out: found {out.name!r}, expected a name that ends in .png or .svg. Give the "
            "picture such a name."
        )
    if out is not None:
        nearest_folder(out.absolute().parent, advice="Give another name with --out.")
    if not 5 <= alpha_deg <= 60:  # as in drive.toml
        raise UsageError(
            f"--alpha-deg: found {alpha_deg:g}, expected an angle from 5 to 60 degrees. Teeth of "
            "strain wave gears have 20 to 30."
        )
    import numpy as np

    from hdprog.inference.prior_file import read_prior_file
    from hdprog.inference.prior_predictive import prior_document, prior_predictive

    file = read_prior_file(name)
    if file.needs_record:
        raise UsageError(
            f"NAME: found {name}, which takes its scales from a record, expected a prior with "
            "numbers of its own. Choose another that `hdprog prior list` shows."
        )
    predictive = prior_predictive(
        file.prior(None), np.random.default_rng(seed), alpha=math.radians(alpha_deg)
    )
    if out is not None:
        from hdprog.atomic import atomic_write_bytes
        from hdprog.reporting.figures.prior_predictive import prior_picture

        atomic_write_bytes(out, prior_picture(predictive, _KINDS[out.suffix.lower()]))
    if as_json:
        print_json(prior_document(predictive))
        return
    _say(predictive)
    if out is not None:
        typer.echo(f"Picture: {out}")


def _say(predictive: PriorPredictive) -> None:
    """Write the prior as a table on standard output."""
    import numpy as np

    from hdprog.physics.parameters import BY_NAME

    prior, operation = predictive.prior, predictive.operation
    typer.echo(f"Prior {prior.name}: {prior.source}.")
    typer.echo(
        f"Inside the model's support at a tooth angle of {math.degrees(operation.alpha):g}°: "
        f"{100 * predictive.in_support:.3g} % of draws. "
        f"Figures after ±{operation.reference_torque:.4g} Nm."
    )
    typer.echo(f"\n{'':<28}{'5 %':>11}{'median':>11}{'95 %':>11}{'catalogue':>11}")
    rows: list[tuple[str, FloatArray, float | None]] = [
        (f"{name} {'' if BY_NAME[name].unit == '-' else BY_NAME[name].unit}", values, None)
        for name, values in predictive.parameters.items()
    ]
    rows += [
        (key.replace("_per_", "/").replace("_", " "), values, prior.catalogue.get(key))
        for key, values in predictive.figures.items()
    ]
    for label, values, maker in rows:
        quantiles = np.quantile(values, [0.05, 0.5, 0.95])
        cells = "".join(f"{quantile:>11.3g}" for quantile in quantiles)
        typer.echo(f"{label:<28}{cells}" + ("" if maker is None else f"{maker:>11.3g}"))


@prior.command("from-catalogue")
def from_catalogue(
    ctx: typer.Context,
    series: Annotated[
        str | None, typer.Option("--series", help="Series of a gear in the catalogue: CSF.")
    ] = None,
    size: Annotated[int | None, typer.Option("--size", help="Its size: 25.")] = None,
    ratio: Annotated[int | None, typer.Option("--ratio", help="Its ratio: 80.")] = None,
    K1: Annotated[
        float | None, typer.Option("--K1", help="Of any gear: stiffness up to T1, in Nm/rad.")
    ] = None,
    K2: Annotated[
        float | None, typer.Option("--K2", help="Stiffness from T1 to T2, in Nm/rad.")
    ] = None,
    K3: Annotated[float | None, typer.Option("--K3", help="Stiffness above T2, in Nm/rad.")] = None,
    T1: Annotated[float | None, typer.Option("--T1", help="Torque T1 in Nm.")] = None,
    T2: Annotated[float | None, typer.Option("--T2", help="Torque T2 in Nm.")] = None,
    rated_torque: Annotated[
        float | None,
        typer.Option("--rated-torque", help="Rated torque in Nm; carried along, not needed."),
    ] = None,
    name: Annotated[
        str | None, typer.Option("--name", help="Name of the prior (default: the file's).")
    ] = None,
    every: Annotated[
        bool,
        typer.Option("--all", help="Make the prior of every gear in the catalogue, into --out."),
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="File to write (with --all a folder); else it is printed."),
    ] = None,
) -> None:
    """Make a prior from a maker's stiffness.

    Either a gear of the catalogue (--series, --size, --ratio), or the five numbers of any data
    sheet (--K1, --K2, --K3, --T1, --T2).
    """
    listed = {"--series": series, "--size": size, "--ratio": ratio}
    given = {"--K1": K1, "--K2": K2, "--K3": K3, "--T1": T1, "--T2": T2}
    any_listed = any(value is not None for value in listed.values())
    any_given = any(value is not None for value in given.values())
    ways = any_listed + any_given + every
    if ways != 1:
        raise UsageError(
            f"found {'several' if ways else 'none'} of: --series --size --ratio; --K1 --K2 --K3 "
            "--T1 --T2; --all. Expected one of the three. Name a gear of the catalogue, or give "
            "the numbers of its data sheet."
        )
    if every:
        if name is not None or rated_torque is not None:
            raise UsageError(
                "found --all with --name or --rated-torque, which are of one prior; expected --all "
                "with --out alone. Leave them out."
            )
        _write_all(out)
        return
    wanted = listed if any_listed else given
    missing = [option for option, value in wanted.items() if value is None]
    if missing:
        raise UsageError(
            f"found no {', '.join(missing)}; expected all of {' '.join(wanted)}. Add what is "
            "missing."
        )
    from dataclasses import replace

    from hdprog.atomic import atomic_write_text
    from hdprog.inference.catalogue import CatalogueNumbers, look_up
    from hdprog.inference.catalogue_prior import catalogue_prior, source_of_gear
    from hdprog.inference.prior_text import FORM, prior_text

    if series is not None and size is not None and ratio is not None:
        gear = look_up(series, size, ratio)
        numbers = replace(gear.numbers, rated_torque=rated_torque)
        label, source = f"{series}-{size}-{ratio}".lower(), source_of_gear(gear)
    else:
        values = {option[2:]: value for option, value in given.items() if value is not None}
        numbers = CatalogueNumbers(**values, rated_torque=rated_torque)
        label = "own" if out is None else out.stem
        source = "Stiffness as given on the command line"
    numbers.check("options of hdprog prior from-catalogue")
    made = catalogue_prior(name or label, numbers, source)
    text = prior_text(made, [f"Made by `{command_line(ctx)}`.", FORM])
    if out is None:
        typer.echo(text, nl=False)
        return
    nearest_folder(out.absolute().parent, advice="Give another name with --out.")
    if out.exists() and (not out.is_file() or out.read_text("utf-8", "replace") != text):
        raise UsageError(
            f"--out: found other content at {out}, expected a name that is free, as a prior edited "
            "by hand would be lost. Give another name, or remove what is there."
        )
    atomic_write_text(out, text)
    typer.echo(f"Prior: {out}")
    typer.echo(f"Look at it: hdprog prior show {shlex.quote(str(out))} --out {out.stem}.png")


def _write_all(out: Path | None) -> None:
    """Write the prior of every gear of the catalogue into a folder."""
    if out is None:
        raise UsageError("found --all without --out; expected a folder. Add --out DIR.")
    nearest_folder(out)
    from hdprog.atomic import atomic_write_text
    from hdprog.inference.catalogue import gears
    from hdprog.inference.prior_text import gear_texts

    texts = dict(gear_texts(gears()))
    for file, text in texts.items():
        atomic_write_text(out / file, text)
    typer.echo(f"Priors: {len(texts)} files in {out}")
