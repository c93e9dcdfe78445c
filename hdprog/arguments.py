"""Arguments of the Python API that cannot be meant: refused with words before the work."""

from __future__ import annotations

import operator
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.random.bit_generator import ISpawnableSeedSequence

from hdprog.config import Drive, require_drive
from hdprog.data.doubts import scale_doubts
from hdprog.data.loop import Loop
from hdprog.data.quality import assess, secant_stiffness
from hdprog.errors import UsageError, shown_argument
from hdprog.seeds import LARGEST_SEED


def checked_record(loop: object, drive: object) -> tuple[Loop, Drive]:
    """Record and drive, if they were read; one of arrays is looked at as the readers do.

    Of a record that was read only its scale is compared with the drive, which may not have been
    given to the reader: a second look at everything takes seconds for long records.

    Parameters
    ----------
    loop : the record; it gains the warnings that it lacks
    drive : what is declared of the drive; nothing if None

    Raises
    ------
    UsageError
        for paths of files, which the readers take, and whatever else was not read
    BadInputError
        for arrays that hold no loop
    """
    if not isinstance(loop, Loop):
        raise UsageError(
            f"loop: found {shown_argument(loop)}, expected a record that was read. Give what "
            "hdprog.read_loop makes of the file, or hdprog.Loop of arrays."
        )
    drive = require_drive(drive) or Drive.default()
    if loop.sha256:
        found = tuple(scale_doubts(loop, secant_stiffness(loop), drive))
    else:
        found = assess(loop, drive).warnings
    return loop if set(found) <= set(loop.warnings) else loop.with_warnings(found), drive


def as_path(given: object, name: str, expected: str) -> Path:
    """A path that was given as text or as a path.

    Raises
    ------
    UsageError
        for anything else
    """
    if isinstance(given, str | os.PathLike):
        return Path(given)
    raise UsageError(
        f"{name}: found {shown_argument(given)}, expected {expected}. Give a path as text or as a "
        "pathlib.Path."
    )


def randomness(
    rng: np.random.Generator | None, seed: int | None
) -> tuple[np.random.Generator, int | None]:
    """Source of randomness, and the seed to record: None where that would not repeat it.

    Raises
    ------
    UsageError
        for what is no generator or no seed
    """
    if rng is None and seed is None:
        return np.random.default_rng(), None
    if rng is None:
        seed = checked_seed(seed)
        return np.random.default_rng(seed), seed
    if not isinstance(rng, np.random.Generator):
        raise UsageError(
            f"rng: found {shown_argument(rng)}, expected a numpy.random.Generator. Give "
            "numpy.random.default_rng(0), or seed=0 instead."
        )
    if not isinstance(rng.bit_generator.seed_seq, ISpawnableSeedSequence):
        # One made of a legacy RandomState has no streams of its own for parts of the work.
        rng = np.random.default_rng(rng.integers(0, 2**32, size=8, dtype=np.uint32))
    return rng, None


def checked_seed(seed: int | None) -> int:
    """Seed as a plain integer, which files can hold.

    Raises
    ------
    UsageError
        for what is no whole number from 0 to `LARGEST_SEED`
    """
    try:
        whole = operator.index(seed)  # type: ignore[arg-type]
    except TypeError:
        whole = -1
    if not 0 <= whole <= LARGEST_SEED:
        raise UsageError(
            f"seed: found {shown_argument(seed)}, expected a whole number from 0 to "
            f"{LARGEST_SEED}. Give seed=0, say."
        )
    return whole


def require_ids(effects: Sequence[str]) -> None:
    """Refuse ids of effects that are not in a sequence.

    Raises
    ------
    UsageError
        so they are
    """
    if isinstance(effects, str) or not hasattr(effects, "__iter__"):
        raise UsageError(
            f"effects: found {shown_argument(effects)}, expected ids in a tuple or a list. Write "
            'effects=("creep",), or leave it out for none.'
        )
