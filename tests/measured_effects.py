"""What `hdprog explain` says of records that others measured.

    python tests/measured_effects.py --data DIR [--only torsion|cycloidal] [--quick]
    python tests/measured_effects.py --table        the tables of the guide page, from the JSON

DIR holds the folders torsion-spring and cycloidal-torque-ramps; they are no part of the project.
Writes reports/guide/measured-effects.json (entries of files that were not run are kept). Reports of
two of the records are made by tests/example_reports.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import hdprog
from hdprog.data.column_options import parse_columns, parse_select
from hdprog.explanation import ErrorFigures, Explanation, FoundEffect, ResidualCourse

ROOT = Path(__file__).resolve().parent.parent
JSON = ROOT / "reports" / "guide" / "measured-effects.json"
FIGURES = (
    "hysteresis_width_arcmin",
    "hysteresis_loss_J",
    "lost_motion_arcmin",
    "secant_stiffness_Nm_per_rad",
)
BINS = np.linspace(-0.9, 0.9, 17)  # of the demanded torque, for comparing two repeats
LOADING_LINE = (0.3, 0.9)  # share of the largest torque over which a loading line is fitted

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Kind:
    """One of the two sets of records."""

    folder: str
    columns: str
    select: str | None
    stems: tuple[str, ...]

    def command(self, name: str, quick: bool) -> str:
        """Write the command line that gives the same result."""
        parts = ["hdprog explain", f"DATA/{self.folder}/{name}", "--columns", self.columns]
        parts += [] if self.select is None else ["--select", self.select]
        return " ".join(parts + (["--quick"] if quick else []))


KINDS = {
    "torsion": Kind(
        "torsion-spring",
        "torque=torque_out:Nm,angle=displacement:deg,time=time:s",
        None,
        ("kt-4-7", "kt-4-8", "kt-6-1", "kt-6-2", "kt-8-1", "kt-8-2"),
    ),
    "cycloidal": Kind(
        "cycloidal-torque-ramps",
        "torque=TORQUE:Nm,angle=POSITION:rev,time=TIME:s",
        "test_nr=100,101,102",
        (
            "base_init1",
            "base_runin1",
            "conic_init1",
            "conic_runin1",
            "conic_1pre1",
            "conic_3pre1",
            "conic_5pre1",
        ),
    ),
}
REPEATS = (("kt-4-7", "kt-4-8"), ("kt-6-1", "kt-6-2"), ("kt-8-1", "kt-8-2"))
CONFIGURATIONS = {"base": "Baseline (PC-CF)", "conic": "Conic Disk (PC-CF)"}
PHASES = {"init1": "initial", "runin1": "after run-in"} | {
    f"{step}pre1": f"preload increase {step}" for step in range(1, 6)
}


def errors(figures: ErrorFigures) -> dict[str, float | None]:
    """Error figures in µrad."""
    reversal = figures.reversal_rmse_rad
    return {
        "rmse_urad": micro(figures.rmse_rad),
        "heldout_rmse_urad": micro(figures.heldout_rmse_rad),
        "reversal_rmse_urad": None if reversal is None else micro(reversal),
        "lag1": round(figures.lag1, 3),
    }


def micro(value: float) -> float:
    """From rad to µrad, four digits."""
    return digits(1e6 * value)


def digits(value: float, count: int = 4) -> float:
    """Round to some digits that count."""
    return float(f"{value:.{count}g}")


def effect(found: FoundEffect) -> dict[str, Any]:
    """Write an effect down."""
    return {
        "id": found.id,
        "words": found.words,
        "coordinate": found.coordinate,
        "share": round(found.share, 3),
        "log_evidence_gain": digits(found.log_evidence_gain),
        "elpd_gain": digits(found.elpd_gain),
        "elpd_se": digits(found.elpd_se),
        "indistinguishable_from": list(found.indistinguishable_from),
        "separating_test": found.separating_test,
        "parameters": {
            name: {"q05": digits(q[0.05]), "q50": digits(q[0.5]), "q95": digits(q[0.95])}
            for name, q in found.parameters.items()
        },
        "units": dict(found.units),
    }


def figures(values: Mapping[str, Mapping[float, float]]) -> dict[str, list[float]]:
    """5 %, 50 % and 95 % of a few figures."""
    return {
        key: [digits(levels[level]) for level in (0.05, 0.5, 0.95)]
        for key, levels in values.items()
        if key.partition("@")[0] in FIGURES
    }


def branches(course: ResidualCourse, demand: float) -> dict[str, list[float | None]]:
    """Angle and residuals at fixed torques of the three branches of a single loop, in µrad."""
    order = np.argsort(course.position)
    torque = course.torque[order]
    top, bottom = int(np.argmax(torque)), int(np.argmin(torque))
    if top > bottom:
        raise ValueError("the loop does not go to its positive side first")
    parts = (slice(0, top), slice(top, bottom), slice(bottom, None))
    values = {"angle": course.angle, "before": course.before, "after": course.after}
    found: dict[str, list[float | None]] = {name: [] for name in values}
    for part in parts:
        cell = np.digitize(torque[part] / demand, BINS)
        for name, all_values in values.items():
            for index in range(1, BINS.size):
                inside = cell == index
                mean = None
                if inside.any():
                    mean = micro(
                        float(
                            np.average(
                                all_values[order][part][inside],
                                weights=course.count[order][part][inside],
                            )
                        )
                    )
                found[name].append(mean)
    return found


def loading_lines(course: ResidualCourse, angle: FloatArray) -> dict[str, float]:
    """Straight lines through the loading branches: their slopes and their gap at no torque.

    The torque between `LOADING_LINE` of its largest size, moving away from zero, on each side.
    """
    top = float(np.max(np.abs(course.torque)))
    side = np.where(course.rising, 1.0, -1.0)
    reached = side * course.torque / top
    lines = {}
    for name, sign in (("positive", 1.0), ("negative", -1.0)):
        used = (side == sign) & (reached > LOADING_LINE[0]) & (reached < LOADING_LINE[1])
        weights = np.sqrt(course.count[used])
        lines[name] = np.polyfit(course.torque[used], np.degrees(angle[used]), 1, w=weights)
    return {
        "compliance_positive_deg_per_Nm": digits(float(lines["positive"][0]), 3),
        "compliance_negative_deg_per_Nm": digits(float(lines["negative"][0]), 3),
        "gap_deg": digits(float(lines["positive"][1] - lines["negative"][1]), 3),
    }


def author(folder: Path, stem: str) -> dict[str, float]:
    """Figures of the thesis for one state of the reducer."""
    configuration, phase = stem.split("_")
    with (folder / "author_estimates.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if row["configuration"] != CONFIGURATIONS[configuration]:
                continue
            if row["phase"] == PHASES[phase]:
                return {
                    name: float(row[name])
                    for name in (
                        "play_deg",
                        "compliance_deg_per_Nm",
                        "compliance_pos",
                        "compliance_neg",
                        "coulomb_Nm",
                    )
                }
    raise SystemExit(f"{folder.name}: the thesis's figures do not have {stem}")


def explained(kind: Kind, path: Path, stem: str, quick: bool) -> dict[str, Any]:
    """Run one file."""
    select = None if kind.select is None else parse_select(kind.select)
    loop = hdprog.read_loop(path, columns=parse_columns(kind.columns), select=select)
    outcome = hdprog.explain(loop, seed=0, quick=quick)
    found = outcome.explanation
    assert isinstance(found, Explanation)
    command = kind.command(path.name, quick)
    repeatability = found.repeatability_rad
    entry = {
        "record": stem,
        "file": path.name,
        "command": command,
        "samples": int(loop.torque.size),
        "largest_torque_Nm": digits(float(np.max(np.abs(loop.torque)))),
        "time_used": loop.time is not None,
        "verdict": found.verdict,
        "converged": found.converged,
        "seconds": round(outcome.result.seconds["explain"], 1),
        "noise_floor_urad": micro(found.noise_floor_rad),
        "repeatability_urad": None if repeatability is None else micro(repeatability),
        "before": errors(found.before),
        "after": errors(found.after),
        "carried_by": [
            {
                "coordinate": one.coordinate,
                "fraction": round(one.fraction, 3),
                "p_value": digits(one.p_value, 2),
            }
            for one in found.carried_by[:4]
        ],
        "effects": [effect(one) for one in found.effects],
        "considered": [
            {
                "id": one.id,
                "log_evidence_gain": None
                if one.log_evidence_gain is None
                else digits(one.log_evidence_gain),
                "why_not": one.why_not,
            }
            for one in found.considered[:5]
        ],
        "strained": {name: round(value, 1) for name, value in found.strained.items()},
        "figures_before": figures(found.figures_before),
        "figures_after": figures(found.figures_after),
        "warnings": list(found.warnings),
    }
    course = found.course
    if kind.folder == "torsion-spring":
        entry["branches_urad"] = branches(course, float(stem.split("-")[1]))
    else:
        entry["author"] = author(path.parent, stem)
        entry["loading_lines"] = {
            "record": loading_lines(course, course.angle),
            "model_before": loading_lines(course, course.angle - course.before),
            "model_after": loading_lines(course, course.angle - course.after),
        }
    return entry


def run(data: Path, kinds: Iterable[str], quick: bool) -> None:
    """Run the files and write the JSON after each."""
    for name in kinds:
        kind = KINDS[name]
        for stem in kind.stems:
            paths = sorted((data / kind.folder).glob(f"{stem}*.csv.gz"))
            if not paths:
                sys.exit(f"{kind.folder}: no file {stem}*.csv.gz in the folder given by --data")
            entry = {"kind": name, "quick": quick, **explained(kind, paths[0], stem, quick)}
            keep(entry)
            print(f"{stem}: {entry['verdict']}, {entry['seconds']:.0f} s", flush=True)


def keep(entry: dict[str, Any]) -> None:
    """Put one record's entry into the JSON, in the order of `KINDS`."""
    records = {} if not JSON.is_file() else {one["record"]: one for one in stored()}
    records[entry["record"]] = entry
    order = [stem for kind in KINDS.values() for stem in kind.stems]
    document = {
        "hdprog_version": hdprog.__version__,
        "seed": 0,
        "figures": "5 %, 50 % and 95 % quantiles; the unit ends the name",
        "records": [records[stem] for stem in order if stem in records],
    }
    JSON.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", "utf-8")


def stored() -> list[dict[str, Any]]:
    """Read the entries that were written."""
    records: list[dict[str, Any]] = json.loads(JSON.read_text("utf-8"))["records"]
    return records


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Lay out a table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def arrow(before: float, after: float) -> str:
    """Before and after, in three digits."""
    return f"{short(before)} → {short(after)}"


def short(value: float | None, count: int = 3) -> str:
    """A number in a few digits, without an exponent."""
    if value is None:
        return "none"
    if value == 0.0:
        return "0"
    places = max(0, count - 1 - math.floor(math.log10(abs(value))))
    rounded = round(value, count - 1 - math.floor(math.log10(abs(value))))
    return f"{rounded:.{places}f}"


def named(entry: dict[str, Any]) -> str:
    """Effects that were added, with share and what would do as well."""
    words = []
    for one in entry["effects"]:
        over = f" over {one['coordinate']}" if one["coordinate"] else ""
        instead = one["indistinguishable_from"]
        or_else = f" or {', '.join(instead)}" if instead else ""
        words.append(f"{one['id']}{over}{or_else} ({100 * one['share']:.0f} %)")
    return "; ".join(words).replace("_", " ") or "none"


def effects_table(records: Sequence[dict[str, Any]]) -> str:
    """Verdict, effects and errors of each record."""
    head = ["record", "verdict", "effects (share of the error)", "error", "held-out error"]
    head += ["noise floor", "own cycles differ by", "converged"]
    return markdown(
        head,
        (
            [
                one["record"],
                one["verdict"].replace("_", " "),
                named(one),
                arrow(one["before"]["rmse_urad"], one["after"]["rmse_urad"]),
                arrow(one["before"]["heldout_rmse_urad"], one["after"]["heldout_rmse_urad"]),
                short(one["noise_floor_urad"], 2),
                short(one["repeatability_urad"]),
                "yes" if one["converged"] else "no",
            ]
            for one in records
        ),
    )


def figures_table(records: Sequence[dict[str, Any]]) -> str:
    """Width, lost motion and stiffness before and after; for one loop the measured gap, too."""

    def both(one: dict[str, Any], key: str) -> str:
        before, after = (
            next(v for k, v in one[f"figures_{when}"].items() if k.startswith(key))
            for when in ("before", "after")
        )
        return arrow(before[1], after[1])

    measured = "branches_urad" in records[0]
    head = ["record", "torque, Nm", *(["measured gap, arcmin"] if measured else [])]
    head += ["width, arcmin", "lost motion, arcmin", "secant stiffness, Nm/rad"]
    return markdown(
        head,
        (
            [
                one["record"],
                short(one["largest_torque_Nm"]),
                *([short(gap_below_zero(one))] if measured else []),
                both(one, "hysteresis_width"),
                both(one, "lost_motion"),
                both(one, "secant_stiffness"),
            ]
            for one in records
        ),
    )


def repeats_table(records: Mapping[str, dict[str, Any]]) -> str:
    """How far two repeats differ, and whether their residuals have one shape."""
    rows = []
    for first, second in REPEATS:
        if first not in records or second not in records:
            continue
        one, two = (records[name]["branches_urad"] for name in (first, second))

        def pair(key: str, one: Any = one, two: Any = two) -> tuple[FloatArray, FloatArray]:
            a, b = (np.array(each[key], dtype=float) for each in (one, two))
            both = np.isfinite(a) & np.isfinite(b)
            return a[both] - a[both].mean(), b[both] - b[both].mean()

        a, b = pair("angle")
        before, after = pair("before"), pair("after")
        same = {each["id"] for each in records[first]["effects"]} == {
            each["id"] for each in records[second]["effects"]
        }
        rows.append(
            [
                f"{first}, {second}",
                short(float(np.sqrt(np.mean((a - b) ** 2)))),
                short(float(np.std((a - b)[first_rise(a.size) :]))),
                arrow(*(short_rms(records, first, second, when) for when in ("before", "after"))),
                f"{np.corrcoef(*before)[0, 1]:.2f}",
                f"{np.corrcoef(*after)[0, 1]:.2f}",
                "yes" if same else "no",
            ]
        )
    head = ["repeats", "they differ by", "without the first rise", "error, mean of both"]
    head += ["correlation of residuals, before"]
    return markdown([*head, "after", "same effects named"], rows)


def first_rise(cells: int) -> int:
    """How many of the cells belong to the first rise, which begins at zero torque."""
    return cells // 4


def gap_below_zero(entry: dict[str, Any]) -> float:
    """Angle between the falling and the last rising branch just below zero torque, in arcmin."""
    falling, rising = (
        entry["branches_urad"]["angle"][branch * (BINS.size - 1) + BINS.size // 2 - 1]
        for branch in (1, 2)
    )
    return float(np.degrees((falling - rising) * 1e-6) * 60)


def short_rms(records: Mapping[str, dict[str, Any]], one: str, two: str, when: str) -> float:
    """Root mean square of the errors of two records."""
    values = [records[name][when]["rmse_urad"] for name in (one, two)]
    return float(np.sqrt(np.mean(np.square(values))))


def author_table(records: Sequence[dict[str, Any]]) -> str:
    """The thesis's figures beside the same reading of the record and of the model."""
    rows = []
    for one in records:
        theirs, lines = one["author"], one["loading_lines"]

        def slope(which: str, lines: Any = lines) -> float:
            sides = (
                lines[which][f"compliance_{side}_deg_per_Nm"] for side in ("positive", "negative")
            )
            return float(np.mean(list(sides)))

        width = one["figures_after"]["hysteresis_width_arcmin"][1] / 60
        lost = one["figures_after"]["lost_motion_arcmin"][1] / 60
        rows.append(
            [
                one["record"],
                f"{theirs['compliance_deg_per_Nm']:.3f}",
                *(f"{slope(which):.3f}" for which in ("record", "model_before", "model_after")),
                f"{theirs['play_deg']:.2f}",
                *(f"{lines[which]['gap_deg']:.2f}" for which in ("record", "model_after")),
                f"{lost:.2f}",
                f"{width:.2f}",
            ]
        )
    head = ["record", "compliance: thesis", "record", "model before", "model after"]
    head += ["play: thesis", "gap: record", "gap: model after", "lost motion", "width"]
    return markdown(head, rows)


def tables() -> str:
    """All tables of the guide page."""
    records = stored()
    spring = [one for one in records if one["kind"] == "torsion"]
    reducer = [one for one in records if one["kind"] == "cycloidal"]
    by_name = {one["record"]: one for one in records}
    parts = []
    if spring:
        parts += [effects_table(spring), repeats_table(by_name), figures_table(spring)]
    if reducer:
        parts += [effects_table(reducer), figures_table(reducer), author_table(reducer)]
    return "\n\n".join(parts)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, help="folder of torsion-spring and the other one")
    parser.add_argument("--only", choices=tuple(KINDS), help="run one of the two sets")
    parser.add_argument("--quick", action="store_true", help="fewer draws")
    parser.add_argument("--table", action="store_true", help="print the tables of the guide page")
    options = parser.parse_args()
    if options.data is None and not options.table:
        parser.error("--data or --table is needed")
    # Beside this file stands tests/packaging, which would be imported for the package of that name.
    sys.path[:] = [
        one for one in sys.path if Path(one).resolve() != Path(__file__).resolve().parent
    ]
    if options.data is not None:
        run(options.data, tuple(KINDS) if options.only is None else (options.only,), options.quick)
    if options.table:
        print(tables())


if __name__ == "__main__":
    main()
