"""What is needed to make the same report again."""

from __future__ import annotations

from hdprog.reporting.sections.table import Row, Table
from hdprog.results import Provenance


def provenance(made: Provenance) -> tuple[Table, Table]:
    """List the run and the files that it read: the same again from the same seed, the date aside.

    The time that it took is not among it: it differs from run to run and says nothing of the drive.
    """
    run = [
        Row("hdprog", (made.hdprog_version,)),
        Row("command", (made.command,)),
        Row("seed", ("a generator was handed in" if made.seed is None else str(made.seed),)),
        Row("draws", ("quick" if made.quick else "full",)),
        Row("made at", (made.created,)),
        *(Row(name, (version,)) for name, version in sorted(made.versions.items())),
    ]
    files = [Row(name, (digest or "not from a file",)) for name, digest in made.files.items()]
    return (
        Table.flat("The run.", ("what", "value"), run),
        Table.flat("The files read.", ("file", "SHA-256"), files),
    )
