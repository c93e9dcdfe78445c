"""What in a usable record deserves a second look, each in one plain sentence."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.noise_level import channel_noise, quantisation_step
from hdprog.data.usable import side_coverage
from hdprog.physics.figures import LOST_MOTION_SHARE

__all__ = ["doubts", "scale_doubts"]

# Smallest to largest strain wave gears, with room to spare. Stiffness and torque go with the cube
# of the size: a size 100 has 3.6 times the 1e6 Nm/rad of a CSG-65, and 64 times the 332 Nm of
# momentary peak torque of a CSG-25 (Harmonic Drive catalogues).
_STIFFNESS_RANGE = (1e2, 5e6)  # Nm/rad
_LARGEST_TORQUE = 3e4  # Nm
_TWIST_RANGE = (3e-5, 0.3)  # rad at rated torque or at a record's largest, for every size
_RATED_SHARE = (0.01, 6.0)  # of rated torque; momentary peak torque is 3 to 6 times as much
_REACHED = 1.05  # times the largest torque: up to there a torque counts as reached
_COARSER = 30.0  # a rig that records means of 1000 readings is finer than its steps by that much
_RELATED = 0.3  # correlation of torque and angle; wide loops of worn drives have 0.9
_BACKWARDS = (0.005, 6.0)  # of the angle's span and times its noise: of branches in wrong order
_STANDSTILL = 0.12  # of the torque's span; rigs that stick and slip stand still for half of it
_CUT_OFF = 1.5  # times that: what an end of the encoder's range hides lies on both sides of a turn
_FULL_ENOUGH = 0.9
_BY_STEPS = 0.5  # of the torque's way
_FEWER = 5.0


def doubts(
    loop: Loop,
    turns: NDArray[np.intp],
    stiffness: float,
    drive: Drive | None = None,
) -> Iterator[str]:
    """Yield warnings about a record.

    Parameters
    ----------
    loop : Loop
        The record.
    turns : ndarray of int
        Its turning points.
    stiffness : float
        Its secant stiffness [Nm/rad], negative where the angle falls as the torque rises.
    drive : Drive or None
        What is declared about the drive.

    Yields
    ------
    str
        One sentence or two, with what to do.
    """
    # A jump back by a turn outweighs the slope of a whole record.
    turned = np.abs(np.diff(loop.angle)).max() > np.pi
    related = float(np.corrcoef(loop.torque, loop.angle)[0, 1])
    if abs(related) < _RELATED and not turned:
        yield (
            f"The angle hardly goes with the torque (correlation {related:.2f}): noise or "
            "something else moves it, and what a fit says of the drive is worth little. Check "
            "that the right column is read, with --columns, and that the encoder is on."
        )
    elif stiffness < 0 and not turned:
        yield (
            "The angle falls while the torque rises: one of the two has the wrong sign. Change it "
            "in the record; a fit of this one means nothing."
        )
    elif not turned:
        yield from _backwards(loop, turns)
    yield from scale_doubts(loop, stiffness, drive)
    if drive is not None:
        yield from _resolution(loop, drive)
    yield from _new_turns(loop)
    yield from _clipping(loop, stiffness)
    yield from _standstill(loop)
    yield from _gaps(loop, turns)
    yield from _short_branches(loop, turns)


def scale_doubts(loop: Loop, stiffness: float, drive: Drive | None) -> Iterator[str]:
    """Compare torque, stiffness and twist with what drives can have: mistaken units are 1000 off.

    Stiffness (1/1000 to 1000 times) shows either channel's mistake on drives of middle size, twist
    that of the angle on every drive. Torque at the input is less by the ratio, 30 to 320.

    Parameters and results are those of `doubts`.
    """
    stiffness = abs(stiffness)
    rated = drive.rated_torque if drive is not None else None
    largest = float(np.abs(loop.torque).max())
    check = (
        "Check the units of torque and angle: 1000 is the step from Nm to kNm, from mNm or Nmm to "
        "Nm, and from mrad to rad."
    )
    at_output = ""
    if rated is not None and largest < rated:
        at_output = " The torque has to be that at the output, not the motor's at the input."
    if rated is not None and not _RATED_SHARE[0] <= largest / rated <= _RATED_SHARE[1]:
        yield (
            f"The largest torque, {largest:.3g} Nm, is {largest / rated:.3g} times the drive's "
            f"rated torque of {rated:g} Nm. {check}{at_output}"
        )
    elif rated is not None and _REACHED * largest < LOST_MOTION_SHARE * rated:
        yield (
            f"The largest torque, {largest:.3g} Nm, is {largest / rated:.3g} times the drive's "
            f"rated torque of {rated:g} Nm: less than lost motion is read at, ±"
            f"{LOST_MOTION_SHARE:.0%} of it. Check that it is the torque at the output, not the "
            "motor's at the input, and its unit; else load the drive further."
        )
    elif rated is None and largest > _LARGEST_TORQUE:
        yield (
            f"The largest torque is {largest:.3g} Nm; no strain wave gear bears more than "
            f"{_LARGEST_TORQUE:g} Nm. {check}"
        )
    found = f"The secant stiffness of the record is {stiffness:.3g} Nm/rad"
    where, torque = ("rated", rated) if rated is not None else ("largest", largest)
    if rated is None and not _STIFFNESS_RANGE[0] <= stiffness <= _STIFFNESS_RANGE[1]:
        yield (
            f"{found}; drives have {_STIFFNESS_RANGE[0]:.0e} to {_STIFFNESS_RANGE[1]:.0e}. {check}"
        )
    elif not _TWIST_RANGE[0] <= torque / stiffness <= _TWIST_RANGE[1]:
        yield (
            f"{found}, a twist of {torque / stiffness:.2g} rad at the {where} torque of "
            f"{torque:.3g} Nm: drives twist {_TWIST_RANGE[0]:g} to {_TWIST_RANGE[1]:g} rad. {check}"
        )


def _resolution(loop: Loop, drive: Drive) -> Iterator[str]:
    """Compare the declared resolution with the record's noise: degrees for rad are 57 times off."""
    for name, values, resolution, unit in (
        ("torque", loop.torque, drive.noise.torque_Nm, "Nm"),
        ("angle", loop.angle, drive.noise.angle_rad, "rad"),
    ):
        if resolution is None:
            continue
        noise = channel_noise(values, loop.time)
        # A load of dead weights has no noise, and large steps; both have to be small.
        step = float(np.median(np.diff(np.unique(values))))
        if _COARSER * max(noise, step) < resolution:
            yield (
                f"The {name} resolution of {resolution:.3g} {unit} in drive.toml is far coarser "
                f"than what the record shows, noise of {noise:.2g} {unit}: errors of the model "
                "would pass for noise. Check its unit, or leave it out: it is then found from the "
                "record."
            )


def _new_turns(loop: Loop) -> Iterator[str]:
    """Look for encoders that pass from 360° to 0°: what is averaged or divided there is nowhere."""
    channels = (
        ("angle", loop.angle, "Unwrap the angle before a fit."),
        (
            "output angle",
            loop.output_angle,
            "Unwrap the output angle before a fit, or leave it out with --columns output_angle=.",
        ),
    )
    for name, values, advice in channels:
        jump = 0.0 if values is None else float(np.abs(np.diff(values)).max())
        if jump > np.pi:
            yield (
                f"The {name} jumps by {jump:.3g} rad between two samples: the encoder seems to "
                f"begin a new turn there. {advice}"
            )


def _clipping(loop: Loop, stiffness: float) -> Iterator[str]:
    """Look for torque that stays at its extreme while the load goes on.

    A hold also stays, but there the angle only creeps one way, or the torque keeps its noise. Noise
    may also come in behind what clips.
    """
    torque, angle = loop.torque, loop.angle
    fewest = _fewest(loop)
    # Within one step of the torque's resolution the angle may go on and come back unseen.
    unseen = (0.005 + (quantisation_step(torque) or 0.0) / float(np.ptp(torque))) * np.ptp(angle)
    unseen += 6.0 * loop.angle_scatter
    about = 6.0 * loop.torque_scatter
    by_noise = unseen + 3.0 * about / abs(stiffness)
    for name, extreme in (("largest", torque.max()), ("smallest", torque.min())):
        clipped = [
            run
            for run in _runs(torque == extreme)
            if run.size >= fewest and (_returns(angle, run, unseen) or _noise_vanishes(torque, run))
        ] or [
            run
            for run in _runs(np.abs(torque - extreme) < about)
            if run.size >= fewest and _returns(angle, run, by_noise)
        ]
        if clipped:
            samples = sum(run.size for run in clipped)
            yield (
                f"The torque seems to clip at its {name} value, {extreme:.4g} Nm, in {samples} "
                "samples: the true torque there is not known. Leave those samples out, or widen "
                "the sensor's range."
            )


def _fewest(loop: Loop) -> int:
    """How many neighbouring samples alike are no chance."""
    return max(5, len(loop) // 500)


def _runs(where: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """Neighbouring samples together; one empty run where there is none."""
    found = np.flatnonzero(where)
    return np.split(found, np.flatnonzero(np.diff(found) > 1) + 1)


def _standstill(loop: Loop) -> Iterator[str]:
    """Look for an angle that stays where it is while the torque goes on.

    At its extreme an angle that is noisy elsewhere need not stay long.
    """
    torque, angle = loop.torque, loop.angle
    per_torque = float(np.ptp(angle)) / float(np.ptp(torque))
    enough = max(
        _STANDSTILL * float(np.ptp(torque)), 3 * (quantisation_step(angle) or 0.0) / per_torque
    )
    noise = 6.0 * loop.torque_scatter
    enough += noise
    fewest = _fewest(loop)
    begins = np.append(0, np.flatnonzero(np.diff(angle)) + 1)
    ends = np.append(begins[1:], len(loop))
    long = ends - begins >= fewest
    still = [
        (start, end)
        for start, end in zip(begins[long].tolist(), ends[long].tolist(), strict=True)
        if np.ptp(torque[start:end]) > enough
        or _there_and_back(torque[start:end]) > _CUT_OFF * enough
    ]
    still += [
        (int(run[0]), int(run[-1]) + 1)
        for extreme in (angle.max(), angle.min())
        for run in _runs(angle == extreme)
        if run.size >= fewest and np.ptp(torque[run]) > noise and _noise_vanishes(angle, run)
    ]
    still = sorted(set(still))
    if still:
        start, end = max(still, key=lambda run: run[1] - run[0])
        samples = sum(end - start for start, end in still)
        yield (
            f"The angle stays at {angle[start]:.6g} rad after sample {start + 1} while the torque "
            f"moves by {np.ptp(torque[start:end]):.3g} Nm: the encoder seems to stand still or to "
            f"be at its end, in {samples} samples. Leave those out, or measure anew; a fit of this "
            "record takes them for stiffness."
        )


def _backwards(loop: Loop, turns: NDArray[np.intp]) -> Iterator[str]:
    """Look for loops that give back more work than they take: unloading lies below loading."""
    torque, angle = loop.torque, loop.angle
    gaps, points = [], []
    for first, middle, last in zip(turns[:-2], turns[1:-1], turns[2:], strict=True):
        there, back = slice(first, middle + 1), slice(middle, last + 1)
        low = max(torque[there].min(), torque[back].min())
        high = min(torque[there].max(), torque[back].max())
        levels = np.linspace(low, high, 66)[1:-1]
        angles = [_over_torque(torque[part], angle[part], levels) for part in (there, back)]
        falls = -1.0 if torque[middle] < torque[first] else 1.0
        gaps.append(falls * float(np.mean(angles[1] - angles[0])))
        points.append(last - first)
    least = _BACKWARDS[0] * float(np.ptp(angle))
    if not gaps:
        return
    noise = loop.angle_scatter / np.sqrt(np.median(points))
    gap = float(np.median(gaps))
    if gap < -max(least, _BACKWARDS[1] * noise):
        yield (
            f"The loop runs backwards: unloading lies {-gap:.2g} rad below loading on average, as "
            "if the drive gave back more work than it took. Torque and angle may be swapped, the "
            "rows in reverse order, or one of the two filtered or late; width, loss and lost "
            "motion of this record mean nothing."
        )


def _there_and_back(torque: NDArray[np.float64]) -> float:
    """How far a stretch of torque goes to its farthest reading and comes back from there."""
    first, last = torque[0], torque[-1]
    return float(max(2 * torque.max() - first - last, first + last - 2 * torque.min()))


def _over_torque(
    torque: NDArray[np.float64], angle: NDArray[np.float64], levels: NDArray[np.float64]
) -> NDArray[np.float64]:
    order = np.argsort(torque, kind="stable")
    return np.interp(levels, torque[order], angle[order])


def _returns(angle: NDArray[np.float64], run: NDArray[np.intp], unseen: float) -> bool:
    """Tell whether the angle goes on and comes back within a run of equal torque."""
    stretch = angle[run[0] : run[-1] + 1]
    ends = stretch[[0, -1]]
    beyond = max(stretch.max() - ends.max(), ends.min() - stretch.min())
    return bool(beyond > unseen)


def _noise_vanishes(values: NDArray[np.float64], run: NDArray[np.intp]) -> bool:
    """Tell whether a channel that is noisy elsewhere, and not coarse, is the same along a run."""
    elsewhere = values[values != values[run[0]]]
    steps, bends = np.diff(elsewhere), np.diff(elsewhere, 2)
    noisy = np.abs(bends) > 1e-6 * np.ptp(values)  # not by rounding
    return bool(
        steps.size >= 20
        # Noise turns the slope at most samples, and never leaves the torque where it was.
        and np.mean(steps == 0) < 0.01
        and np.mean(noisy[1:] & (bends[1:] * bends[:-1] < 0)) > 0.4
    )


def _gaps(loop: Loop, turns: NDArray[np.intp]) -> Iterator[str]:
    steps = np.abs(np.diff(loop.torque))
    span = float(np.ptp(loop.torque))
    usual = max(20.0 * float(np.median(steps)), 8.0 * loop.torque_scatter, 0.05 * span)
    jumps = np.flatnonzero(steps > usual)
    # A spike jumps out and back; what stays away is a gap.
    lasting = [
        int(jump)
        for jump in jumps
        if abs(np.median(loop.torque[jump + 1 : jump + 4]) - loop.torque[jump]) > usual
        and abs(np.median(loop.torque[max(jump - 2, 0) : jump + 1]) - loop.torque[jump + 1]) > usual
    ]
    if loop.time is not None:
        intervals = np.diff(loop.time)
        longest = int(np.argmax(intervals))
        limit = max(10.0 * float(np.median(intervals)), 0.02 * float(loop.time[-1]))
        gaps = np.count_nonzero(intervals > limit)
        if gaps:
            yield (
                f"{gaps} {'gap' if gaps == 1 else 'gaps'} in time, the longest of "
                f"{intervals[longest]:.3g} s after sample {longest + 1}, where samples usually "
                f"come every {np.median(intervals):.3g} s: what happened there is not known."
            )
            return
    # Torque that goes nearly all its way by jumps is loaded in steps.
    way = float(np.abs(np.diff(loop.torque[turns])).sum())
    if lasting and steps[lasting].sum() < _BY_STEPS * way:
        first, times = lasting[0], len(lasting)
        yield (
            f"The torque jumps {'' if times == 1 else f'{times} times, first '}from "
            f"{loop.torque[first]:.4g} to {loop.torque[first + 1]:.4g} Nm after sample "
            f"{first + 1}: samples seem to be missing there."
        )


def _short_branches(loop: Loop, turns: NDArray[np.intp]) -> Iterator[str]:
    sides = side_coverage(loop.torque[turns])
    for side, (rise, fall) in sides.items():
        if min(rise, fall) < _FULL_ENOUGH:
            shorter = "unloading" if fall < rise else "loading"
            where = f" on the {side} side" if len(sides) > 1 else ""
            yield (
                f"The {shorter}{where} is much shorter than the other branch: it covers "
                f"{min(rise, fall):.0%} of the torque. The loop is not closed, so friction and "
                "stiffness are less certain."
            )
    counts = {True: 0, False: 0}
    for start, end in pairwise(turns.tolist()):
        counts[bool(loop.torque[end] > loop.torque[start])] += end - start
    fewer, more = sorted(counts.values())
    if fewer * _FEWER < more:
        scarce = "rising" if counts[True] < counts[False] else "falling"
        yield (
            f"The branches with {scarce} torque have {fewer} samples and the others {more}: one "
            "branch is much shorter than the other and weighs less in a fit."
        )
    low, high = sorted(np.abs((loop.torque.min(), loop.torque.max())))
    if loop.torque.min() < 0 < loop.torque.max() and 0.2 * high < low < 0.5 * high:
        yield (
            f"The torque reaches {loop.torque.max():.3g} Nm on one side and "
            f"{loop.torque.min():.3g} Nm on the other: one side is much shorter than the other."
        )
