"""The process that reads uploaded records: one order a line in, one answer a line out.

Run by `hdprog.service.readers` as ``python -m hdprog.service.reader``.
"""

from __future__ import annotations

import json
import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from hdprog.errors import HdprogError
from hdprog.parallel import prepare_numerics
from hdprog.service.readout import ReadOut, read_record, refused

MEMORY = 3 << 30  # bytes of address space that reading one record may take


def main() -> None:
    """Answer orders until the input ends."""
    _limit_memory()
    prepare_numerics()
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what is printed is no answer
    for line in sys.stdin:
        try:
            print(json.dumps(asdict(_answer(json.loads(line)))), file=answers, flush=True)
        except BrokenPipeError:
            os._exit(0)  # the server is gone


def _answer(order: dict[str, Any]) -> ReadOut:
    name = order["name"]
    try:
        return read_record(Path(order["path"]), name, order["content"])
    except HdprogError as error:
        return ReadOut((str(error),), {})
    except MemoryError:
        return refused(
            name,
            "a record that takes more memory to read than the server allows",
            f"one that can be read with {MEMORY >> 30} GiB",
        )
    except Exception as error:
        return refused(
            name, f"a record that stops the reader ({type(error).__name__})", "a loop file"
        )


def _limit_memory() -> None:
    if sys.platform == "win32":
        return
    import resource

    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    ceiling = MEMORY if hard == resource.RLIM_INFINITY else min(MEMORY, hard)
    resource.setrlimit(resource.RLIMIT_AS, (ceiling, hard))


if __name__ == "__main__":
    main()
