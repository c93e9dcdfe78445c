"""Limits on figures of merit, and what their parts mean together."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from hdprog.config.rules import Positive, Torque, check_fields
from hdprog.errors import BadInputError

STIFFNESSES_AT_TORQUE = ("local_stiffness_Nm_per_rad", "secant_stiffness_Nm_per_rad")
CATALOGUE_STIFFNESSES = ("K1_Nm_per_rad", "K2_Nm_per_rad", "K3_Nm_per_rad")
"""Between the torques of makers' catalogues: 0 to T1, to T2, and beyond."""
QUANTITIES = (
    "hysteresis_width_arcmin",
    "hysteresis_loss_J",
    "lost_motion_arcmin",
    "preload_Nm",
    *STIFFNESSES_AT_TORQUE,
    *CATALOGUE_STIFFNESSES,
)
"""Every figure of merit that a limit may be set on."""


@dataclass(frozen=True)
class Limit:
    """A figure of merit and the threshold that it must not cross.

    `threshold` is in the unit that the quantity's name ends in; `direction` is the side that is
    past the limit; `at_torque_Nm` is set for stiffnesses at a torque and None for all others.

    Raises
    ------
    BadInputError
        for a limit that drive.toml could not have either
    """

    quantity: str
    threshold: Positive
    direction: Literal["above", "below"]
    at_torque_Nm: Torque | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        require_quantity(self.quantity, self.at_torque_Nm, "Limit")
        if self.direction not in ("above", "below"):
            raise BadInputError(
                f"direction={self.direction!r}",
                "Limit",
                "above or below, the side that is past the limit",
                "Correct direction.",
            )

    @property
    def key(self) -> str:
        """Key of the figure in summaries, see `figure_key`."""
        return figure_key(self.quantity, self.at_torque_Nm)


def figure_key(quantity: str, at_torque: float | None) -> str:
    """Key of a figure in summaries, e.g. ``secant_stiffness_Nm_per_rad@14Nm``.

    Torques [Nm] that are alike to six digits have one key: no figure tells them apart.
    """
    return quantity if at_torque is None else f"{quantity}@{at_torque:g}Nm"


def require_quantity(quantity: str, at_torque: float | None, where: str) -> None:
    """Refuse a quantity that no limit may be set on, or one that misses its torque.

    Parameters
    ----------
    quantity : as in `QUANTITIES`
    at_torque : in Nm
    where : for the message

    Raises
    ------
    BadInputError
        also for a torque beside a quantity that is at none
    """
    if quantity not in QUANTITIES:
        raise BadInputError(
            f'quantity = "{quantity}"',
            where,
            "one of " + ", ".join(QUANTITIES),
            nearest(str(quantity), QUANTITIES) or "Choose one of these.",
        )
    if (at_torque is None) == (quantity in STIFFNESSES_AT_TORQUE):
        raise BadInputError(
            f"{quantity} {'without' if at_torque is None else 'with'} at_torque_Nm",
            where,
            "at_torque_Nm for " + " and ".join(STIFFNESSES_AT_TORQUE) + ", and for nothing else",
            "Add at_torque_Nm = 14.0 with the torque that the stiffness is read at."
            if at_torque is None
            else "Remove at_torque_Nm.",
        )


def require_rated_torque(quantity: str, rated: float | None, where: str) -> None:
    """Refuse a limit on lost motion in a drive of which no rated torque is known.

    Parameters
    ----------
    quantity : of the limit
    rated : torque in Nm
    where : for the message

    Raises
    ------
    BadInputError
        for such a limit
    """
    if quantity == "lost_motion_arcmin" and rated is None:
        raise BadInputError(
            "a limit on lost_motion_arcmin in a drive without rated_torque_Nm",
            where,
            "the drive's rated torque, as lost motion is read at 4 % of it",
            "Add rated_torque_Nm under [drive].",
        )


def refuse_contradictions(limits: Sequence[Limit], where: str) -> None:
    """Refuse a limit that is there twice, and two that every drive is past from the start.

    Two on one side, an alarm and a stop say, are two limits.

    Parameters
    ----------
    limits : of one drive
    where : for the message

    Raises
    ------
    BadInputError
        for such limits
    """
    seen: set[tuple[str, str, float]] = set()
    lowest: dict[str, float] = {}
    for limit in limits:
        same = (limit.key, limit.direction, limit.threshold)
        if same in seen:
            raise BadInputError(
                f"two limits on {limit.key}, both {limit.direction} = {limit.threshold:g}",
                where,
                "limits that differ",
                "Remove one of them.",
            )
        seen.add(same)
        if limit.direction == "above":
            lowest[limit.key] = min(lowest.get(limit.key, math.inf), limit.threshold)
    for limit in limits:
        above = lowest.get(limit.key, math.inf)
        if limit.direction == "below" and limit.threshold >= above:
            raise BadInputError(
                f"limits on {limit.key}, above = {above:g} and below = {limit.threshold:g}",
                where,
                "room between the two: above and below name the sides that are past the limit",
                "Exchange above and below, or correct the numbers.",
            )


def nearest(word: str, known: Iterable[str]) -> str:
    """Propose the known word that is most like one that is not; empty if none is."""
    matches = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    return f"Did you mean {matches[0]}?" if matches else ""
