"""The least that a record must hold: below it, it is refused."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hdprog.data.loop import Loop
from hdprog.data.turning_points import smallest_swing
from hdprog.errors import BadInputError

__all__ = ["branch_coverage", "require_numbers", "require_usable", "side_coverage"]

_FEWEST_SAMPLES = 20
# A loading or unloading counts as full from here on; 1 would refuse a record that stops a little
# above the torque at which it began.
_FULL_SHARE = 2.0 / 3.0
_FALLING = -0.7  # correlation of torque and angle
_COLDEST = -273.15  # °C
_SMALLEST, _LARGEST = 1e-100, 1e100  # Nm and rad: beyond them squares leave what floats hold
_SIDE_SHARE = 0.2  # of the largest torque: less on a side is noise or overshoot


def require_numbers(loop: Loop) -> None:
    """Refuse a record of too few samples, or of numbers that no loop can be computed from.

    Parameters
    ----------
    loop : Loop
        The record.

    Raises
    ------
    BadInputError
        Fewer than 20 samples, constant torque or angle, or numbers beyond what any drive can have.
    """
    if len(loop) < _FEWEST_SAMPLES:
        raise BadInputError(
            f"{len(loop)} sample{'' if len(loop) == 1 else 's'}",
            loop.source,
            f"at least {_FEWEST_SAMPLES}, and some hundred for a useful fit",
            "Record more samples a loop.",
        )
    for name, values, unit in (("torque", loop.torque, "Nm"), ("angle", loop.angle, "rad")):
        if np.abs(values).max() > _LARGEST or 0 < np.ptp(values) < _SMALLEST:
            raise BadInputError(
                f"{name} from {values.min():.6g} to {values.max():.6g} {unit}",
                f"{loop.source}, {name}",
                f"{name} that a drive can have",
                "Check that the right column is read, with --columns, and its unit.",
            )
        if np.ptp(values) == 0:
            raise BadInputError(
                f"the same {name} of {values[0]:.6g} {unit} in all {len(loop)} samples",
                f"{loop.source}, {name}",
                f"{name} that changes",
                "Check that the right column is read, with --columns, and that its sensor is on.",
            )


def require_usable(loop: Loop, turns: NDArray[np.intp]) -> None:
    """Refuse a record from which no loop can be seen.

    Parameters
    ----------
    loop : Loop
        The record.
    turns : ndarray of int
        Its turning points.

    Raises
    ------
    BadInputError
        Less than one full loading and unloading, an angle that falls as the torque rises, or a
        temperature below absolute zero.
    """
    low, high = float(loop.torque.min()), float(loop.torque.max())
    if high - low < smallest_swing(loop.torque, loop.time):
        raise BadInputError(
            f"a torque that stays between {low:.4g} and {high:.4g} Nm and changes no more than "
            "its noise",
            f"{loop.source}, torque",
            "at least one full loading and unloading",
            "Check that the right column is read, with --columns, and record a whole loop.",
        )
    rise, fall = branch_coverage(loop.torque[turns])
    if min(rise, fall) < _FULL_SHARE:
        start, end = loop.torque[0], loop.torque[-1]
        raise BadInputError(
            f"torque that begins at {start:.4g} Nm, ends at {end:.4g} Nm and stays within "
            f"{low:.4g} to {high:.4g} Nm: the loading covers {rise:.0%} of that side and the "
            f"unloading {fall:.0%}",
            f"{loop.source}, torque",
            "at least one full loading and unloading",
            "Record until the torque is back where it began; check that the rows are in the order "
            "of recording and that --select keeps all rows of a cycle.",
        )
    turned = np.abs(np.diff(loop.angle)).max() > np.pi  # by the encoder, which is told elsewhere
    if not turned and np.corrcoef(loop.torque, loop.angle)[0, 1] < _FALLING:
        raise BadInputError(
            "an angle that falls while the torque rises",
            loop.source,
            "torque and angle counted in the same direction",
            "Change the sign of one of the two columns in the record.",
        )
    if loop.temperature is not None and loop.temperature.min() < _COLDEST:
        raise BadInputError(
            f"{loop.temperature.min():.6g} °C",
            f"{loop.source}, temperature",
            f"no temperature below {_COLDEST} °C, absolute zero",
            "Check the sensor, or leave the column out.",
        )


def branch_coverage(turns: NDArray[np.float64]) -> tuple[float, float]:
    """Tell how much of a side of the loop was loaded and unloaded.

    Parameters
    ----------
    turns : ndarray, shape (k,)
        Torque at the turning points, in order.

    Returns
    -------
    rise, fall : float
        Those of `side_coverage` on the side where the smaller of both is largest.
    """
    found = side_coverage(turns).values()
    return max(found, key=lambda shares: (min(shares), max(shares)), default=(0.0, 0.0))


def side_coverage(turns: NDArray[np.float64]) -> dict[str, tuple[float, float]]:
    """Tell how much of each side of the loop that was loaded at all was loaded and unloaded.

    Parameters
    ----------
    turns : ndarray, shape (k,)
        Torque at the turning points, in order.

    Returns
    -------
    dict of side to (rise, fall)
        Largest rise and largest fall of the torque's size, as shares of its range on the side.
        Minor loops on the way do not interrupt a rise or a fall.
    """
    found: dict[str, tuple[float, float]] = {}
    sides: dict[str, NDArray[np.float64]] = {"positive": turns, "negative": -turns}
    for name, torque in sides.items():
        side = np.maximum(torque, 0.0)
        span = float(np.ptp(side))
        if span == 0.0 or side.max() < _SIDE_SHARE * np.abs(turns).max():
            continue
        rise = float((side - np.minimum.accumulate(side)).max()) / span
        fall = float((np.maximum.accumulate(side) - side).max()) / span
        found[name] = rise, fall
    return found
