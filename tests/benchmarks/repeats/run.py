"""Do fits of repeated cycles agree within their intervals as often as they should?

    python -m tests.benchmarks.repeats.run --data DIR
    python -m tests.benchmarks.repeats.run --summary

DIR holds the folders torsion-spring and cycloidal-torque-ramps; they are no part of the project.
Their records are cut into whole cycles, each is fitted by itself (quick plan): with the drive model
alone and with what `hdprog explain` finds in the repeats of a state together; each with the noise
that the fit finds, and with white noise in spite of it. Simulated repeats with a known truth go
through the same (--control N drives, two records each). Every posterior is a line of
results/fits.jsonl, so that a run that was broken off goes on where it ended. Then
results/summary.json, results/summary.md and the picture reports/guide/repeats.png are made anew.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict
from functools import lru_cache, partial
from pathlib import Path

from hdprog.atomic import atomic_write_text
from hdprog.parallel import prepare_numerics
from tests.benchmarks.code_state import digest, imported_by
from tests.benchmarks.repeats import DRIVE, MODELS, Fit, read_fits
from tests.benchmarks.repeats.control import control_fits, name_of
from tests.benchmarks.repeats.fits import fits_of
from tests.benchmarks.repeats.picture import write_picture
from tests.benchmarks.repeats.records import groups
from tests.benchmarks.repeats.summary import in_words, summary
from tests.benchmarks.rounded import rounded

RESULTS = Path(__file__).parent / "results"
PICTURE = Path(__file__).parents[3] / "reports" / "guide" / "repeats.png"

Job = tuple[str, str, Callable[[], Iterator[Fit]]]


@lru_cache(maxsize=1)
def state_of_code() -> str:
    """Digest of the sources that the fits hang on."""
    here = [f"tests.benchmarks.repeats.{name}" for name in ("control", "fits", "records")]
    return digest(imported_by(*here))


def jobs(data: Path | None, control: int, only: str) -> Iterator[Job]:
    """What there is to do: state, model, and how; a job's fits are written together."""
    code = state_of_code()
    for model in MODELS if data is not None else ():
        for group in groups(data) if data is not None else ():
            if only in group.name:
                yield group.name, model, partial(fits_of, group, model, code)
    for index in range(control):
        if only in name_of(index):
            yield name_of(index), DRIVE, partial(control_fits, index, code)


def run(todo: Iterable[Job], file: Path) -> None:
    """Do what the file does not hold yet and append it."""
    old, unreadable = read_fits(file)
    done = {(one.group, one.model) for one in old}
    others = sum(one.code != state_of_code() for one in old)
    if others:
        print(f"{others} fits of {file} come from another state of the code; delete it to renew")
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("a", encoding="utf-8") as stream:
        if old or unreadable:  # the last line may have been broken off
            stream.write("" if file.read_bytes().endswith(b"\n") else "\n")
        for name, model, work in todo:
            if (name, model) in done:
                continue
            found = list(work())
            stream.writelines(json.dumps(rounded(asdict(one))) + "\n" for one in found)
            stream.flush()
            for one in found:
                print(f"{one.words} ({one.seconds:.1f} s)", flush=True)


def main() -> None:
    """Run what is asked and write the summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, metavar="DIR", help="folder of the measured records")
    parser.add_argument("--control", type=int, default=60, metavar="N", help="simulated drives")
    parser.add_argument("--only", default="", metavar="TEXT", help="states whose name holds it")
    parser.add_argument("--file", type=Path, default=RESULTS / "fits.jsonl")
    parser.add_argument("--picture", type=Path, default=PICTURE)
    parser.add_argument("--summary", action="store_true", help="only make the summary anew")
    asked = parser.parse_args()
    prepare_numerics()
    if not asked.summary:
        run(jobs(asked.data, asked.control, asked.only), asked.file)
    found, unreadable = read_fits(asked.file)
    if not any(one.status == "fitted" for one in found):
        raise SystemExit(f"no fits in {asked.file}")
    result = summary(found, unreadable)
    folder = asked.file.parent
    atomic_write_text(folder / "summary.json", json.dumps(result, indent=1) + "\n")
    atomic_write_text(folder / "summary.md", in_words(result))
    write_picture(found, result, asked.picture)
    print(in_words(result))


if __name__ == "__main__":
    main()
