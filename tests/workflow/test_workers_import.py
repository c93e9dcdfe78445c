"""Workers begin with emcee, without the libraries that it needs for what hdprog does not use."""

from __future__ import annotations

import json
import subprocess
import sys

# A process of its own: one that has loaded these libraries hands them on to its workers.
SCRIPT = """
import json, sys
from hdprog.parallel import process_executor

def loaded(after):
    for name in after:
        __import__(name)
    return [name for name in ("emcee", "scipy.stats", "h5py") if name in sys.modules]

if __name__ == "__main__":
    with process_executor(2) as executor:
        at_first = executor.submit(loaded, ()).result()
        afterwards = executor.submit(loaded, ("scipy.stats", "h5py")).result()
    print(json.dumps([at_first, afterwards, loaded(())]))
"""


def test_workers_import_what_the_sampler_uses_and_the_rest_when_asked() -> None:
    command = [sys.executable, "-c", SCRIPT]
    found = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    at_first, afterwards, here = json.loads(found)
    assert at_first == ["emcee"]
    assert afterwards == ["emcee", "scipy.stats", "h5py"]
    assert here == [], "nothing is loaded in the process that the workers serve"
