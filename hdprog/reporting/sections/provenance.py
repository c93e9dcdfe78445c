"""What is needed to make the same report again."""

from __future__ import annotations

from collections.abc import Mapping

from hdprog.reporting.sections.table import Row, Table
from hdprog.results import Provenance


def provenance(made: Provenance, seconds: Mapping[str, float]) -> tuple[Table, Table]:
    """List the run with the time that its parts took, and the files that it read."""
    run = [
        Row("hdprog", (made.hdprog_version,)),
        Row("command", (made.command,)),
        Row("seed", ("a generator was handed in" if made.seed is None else str(made.seed),)),
        Row("draws", ("quick" if made.quick else "full",)),
        Row("made at", (made.created,)),
        *(Row(name, (version,)) for name, version in sorted(made.versions.items())),
    ]
    if seconds:
        spent = ", ".join(f"{name} {value:.1f} s" for name, value in seconds.items())
        run.append(Row("time spent", (spent,)))
    files = [Row(name, (digest or "not from a file",)) for name, digest in made.files.items()]
    return (
        Table.flat("The run.", ("what", "value"), run),
        Table.flat("The files read.", ("file", "SHA-256"), files),
    )
