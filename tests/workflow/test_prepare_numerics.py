"""Arrays as a fit makes them are not mapped anew every time."""

from __future__ import annotations

import platform
import subprocess
import sys

import pytest

ROUNDS = 200
SCRIPT = f"""
import resource, sys
import numpy as np
from hdprog.parallel import prepare_numerics

def round_of_arrays():
    kept = [np.full((96, 460), float(number)) for number in range(6)]
    return sum(kept)

if sys.argv[1] == "prepared":
    prepare_numerics()
for _ in range(20):
    round_of_arrays()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range({ROUNDS}):
    round_of_arrays()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def pages_mapped(how: str) -> int:
    command = [sys.executable, "-c", SCRIPT, how]
    return int(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="a setting of glibc's")
def test_memory_is_used_again() -> None:
    assert pages_mapped("as it is") > 10 * ROUNDS, "nothing to gain here"
    assert pages_mapped("prepared") < ROUNDS
