"""The beginning of a record that turns more often than the blocks of a fit can follow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hdprog.data.loop import Loop
from hdprog.data.reduce import MOST_BLOCKS

MOST_STRETCHES = 42
"""Twenty cycles, and the way to the first and from the last. With fewer than a dozen blocks on
each stretch a fit hangs on how the model bends inside them, and may settle on a wrong mode."""


def first_stretches(
    loop: Loop, turning_points: NDArray[np.intp]
) -> tuple[Loop, NDArray[np.intp], str | None]:
    """What of a record is fitted, its turning points, and a remark where that is not all of it.

    Parameters
    ----------
    loop : the record
    turning_points : indices of first reading, reversals and last reading
    """
    stretches, samples = turning_points.size - 1, len(loop)
    if stretches <= MOST_STRETCHES or samples <= MOST_BLOCKS:
        return loop, turning_points, None
    kept = turning_points[: MOST_STRETCHES + 1]
    rows = slice(0, int(kept[-1]) + 1)

    def cut(values: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
        return None if values is None else values[rows]

    first = replace(
        loop,
        torque=loop.torque[rows],
        angle=loop.angle[rows],
        time=cut(loop.time),
        temperature=cut(loop.temperature),
        output_angle=cut(loop.output_angle),
    )
    remark = (
        f"The torque turns {stretches - 1} times, more often than a fit can follow in detail: the "
        f"first {MOST_STRETCHES // 2 - 1} cycles, counted by two turns each ({len(first)} of "
        f"{samples} readings), are fitted. "
        "Split the record where the others are wanted, too."
    )
    return first, kept, remark
