"""What was traced beside the drive model, in words: names, coordinates, findings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.explanation import (
    UNKNOWN,
    Carrier,
    DriveExplanation,
    Explanation,
    FoundEffect,
    LeftOver,
    ResidualCourse,
    spoken_effect,
)
from hdprog.physics.figures import ARCMIN_PER_RAD
from hdprog.physics.parameters import FloatArray
from hdprog.reporting.error_words import (
    above_noise,
    accounted_for,
    before_and_after,
    errors,
    not_predicted,
)
from hdprog.reporting.pooled import pooled_carriers, tests_with
from hdprog.reporting.reader_units import shown
from hdprog.reporting.rounding import (
    about_middle,
    date_down,
    hours,
    hours_up,
    rounded,
    without_unit,
)
from hdprog.reporting.words import agree, listed, spoken, with_unit

NO_MECHANISM = "something that no known mechanism describes"
SIGNIFICANT = 0.05
"""Largest p-value at which a coordinate is said to carry the residual."""
_LEAST = 0.1  # share of the residual from which a coordinate is said to carry it
_WIDE = 0.6  # part of a coordinate's span from which an unknown term lies "over the whole range"
_MOST = 0.8  # of a wide term's squares
_OUTER = 0.35  # of the largest torque: what begins there is at the ends
_HAS_BRANCHES = ("torque", "branch", "angle", "output_angle", "distance_since_reversal")


@dataclass(frozen=True)
class Coordinate:
    """A coordinate in words: its name, the unit that it is shown in, and that unit per SI unit."""

    name: str
    unit: str
    factor: float = 1.0

    @property
    def axis(self) -> str:
        """Label of an axis."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


_COORDINATES: Mapping[str, Coordinate] = {
    "time": Coordinate("time", "s"),
    "torque": Coordinate("torque", "Nm"),
    "angle": Coordinate("torsion angle", "arcmin", ARCMIN_PER_RAD),
    "rate": Coordinate("loading rate", "Nm/s"),
    "temperature": Coordinate("temperature", "°C"),
    "output_angle": Coordinate("output angle", "°", 180.0 / np.pi),
    "branch": Coordinate("torque, each direction by itself", "Nm"),
    "distance_since_reversal": Coordinate("torque since the last reversal", "Nm"),
    "time_since_reversal": Coordinate("time since the last reversal", "s"),
    "order": Coordinate("the order of the readings", ""),
}


def coordinate(name: str) -> Coordinate:
    """Coordinate in words; one that is not known keeps its name and has no unit."""
    known = _COORDINATES.get(name, Coordinate(spoken(name), ""))
    seen = shown(known.unit)
    return Coordinate(known.name, seen.unit, known.factor * seen.factor)


def effect_name(identifier: str) -> str:
    """Name of an effect for running text; the empirical term is no effect and says so."""
    if identifier == UNKNOWN:
        return "an unknown effect"
    return spoken_effect(identifier)


def effect_said_before(identifier: str) -> str:
    """Name of an effect that the reader has met already."""
    return "the unknown effect" if identifier == UNKNOWN else effect_name(identifier)


def effect_words(effect: FoundEffect) -> str:
    """Name of an effect and what it is: "creep (the angle keeps growing under load)"."""
    if effect.id == UNKNOWN:
        return NO_MECHANISM
    return f"{effect_name(effect.id)} ({effect.words.rstrip('.')})"


def mechanisms(effects: Sequence[FoundEffect]) -> list[FoundEffect]:
    """Effects that are known mechanisms."""
    return [effect for effect in effects if effect.id != UNKNOWN]


def unknown_term(effects: Sequence[FoundEffect]) -> FoundEffect | None:
    """Find the empirical term among the effects; None without one."""
    return next((effect for effect in effects if effect.id == UNKNOWN), None)


def carrier(carried_by: Sequence[Carrier]) -> Carrier | None:
    """Coordinate that carries the residual most, None where none does."""
    found = [c for c in carried_by if c.fraction >= _LEAST and c.p_value <= SIGNIFICANT]
    return max(found, key=lambda c: c.fraction, default=None)


def along(course: ResidualCourse, name: str) -> FloatArray | None:
    """Values (blocks,) of a coordinate in SI; None where the course has none.

    Torque stands for the branch, whose two directions are told apart when they are drawn.
    """
    if name in ("torque", "branch"):
        return course.torque
    return course.coordinates.get(name)


def unknown_place(course: ResidualCourse, name: str) -> str:
    """Where an unknown term is at work: "over torque between 18 and 26 Nm on both branches".

    The place is that where the term is more than half as far from its median as it ever gets.
    """
    at = along(course, name)
    said = coordinate("torque" if name == "branch" else name)
    if course.unknown is None or at is None:
        return f"over {said.name}"
    away = np.abs(course.unknown - np.median(course.unknown))
    inside = away >= 0.5 * away.max()
    low, high = said.factor * float(at[inside].min()), said.factor * float(at[inside].max())
    span = said.factor * float(np.ptp(at))
    if high - low > _WIDE * span:
        return f"over the whole range of {said.name}{_most_of_it(said, at, course.unknown)}"
    step = 0.1 * span
    place = f"between {rounded(low, step)} and {with_unit(rounded(high, step), said.unit)}"
    return f"over {said.name} {place}{_branches(course, inside, name)}"


def _most_of_it(said: Coordinate, at: FloatArray, unknown: FloatArray) -> str:
    """Where most of a wide term of torque is, by its squares about its median; empty if all over.

    On one side of zero torque, or beyond a torque in both directions.
    """
    size = (unknown - np.median(unknown)) ** 2
    if said.name != "torque" or at.min() >= 0.0 or at.max() <= 0.0 or not size.any():
        return ""
    size = size / size.sum()
    above = float(size[at > 0.0].sum())
    if max(above, 1.0 - above) > _MOST:
        return f", most of it at {'positive' if above > 0.5 else 'negative'} torque"
    order = np.argsort(-np.abs(at))
    within = np.searchsorted(np.cumsum(size[order]), _MOST)
    inner, top = np.abs(at[order[within]]), np.abs(at).max()
    if inner < _OUTER * top:
        return ""
    beyond = with_unit(
        rounded(said.factor * float(inner), 0.1 * said.factor * float(top)), said.unit
    )
    return f", most of it beyond {beyond} in both directions"


def _branches(course: ResidualCourse, inside: np.ndarray, name: str) -> str:
    if name not in _HAS_BRANCHES:
        return ""
    rising = float(np.mean(course.rising[inside] > 0))
    if rising > 0.9:
        return " while torque rises"
    return " while torque falls" if rising < 0.1 else " on both branches"


def last_with(tests: Sequence[Explanation], identifier: str) -> Explanation | None:
    """Find the last test that carries an effect; None without one."""
    found = tests_with(identifier, tests)
    return found[-1] if found else None


def place_of_unknown(explanation: Explanation | DriveExplanation) -> str:
    """Where the unknown term is at work, in the last test that carries it."""
    tests = explanation.tests if isinstance(explanation, DriveExplanation) else (explanation,)
    test = last_with(tests, UNKNOWN)
    term = unknown_term((test or explanation).effects)
    if test is None or term is None or term.coordinate is None:
        return "in the record"
    return unknown_place(test.course, term.coordinate)


def found_words(explanation: Explanation | DriveExplanation) -> str | None:
    """Warning that the drive model lacks something; None where nothing was added."""
    known, unknown = mechanisms(explanation.effects), unknown_term(explanation.effects)
    said = []
    if known:
        noun = agree(len(known), "An effect", "Effects")
        verb = agree(len(known), "was", "were")
        named = listed(effect_words(effect) for effect in known)
        said.append(f"{noun} outside the drive model {verb} found: {named}.")
    if unknown is not None:
        rest = "More structure" if known else "Structure"
        said.append(
            f"{rest} remains {place_of_unknown(explanation)}, which is none of the known effects: "
            "what rests on this model may be biased, a forecast too."
        )
    if isinstance(explanation, DriveExplanation):
        said += _not_shown(explanation)
    return " ".join(said) or None


def _not_shown(found: DriveExplanation) -> list[str]:
    """Which tests cannot show an effect of the drive, and what follows for their figures."""
    by_effect: dict[str, list[str]] = {}
    for test in found.tests:
        for identifier in found.not_shown_by(test.test_id):
            by_effect.setdefault(effect_name(identifier), []).append(test.test_id)
    return [
        f"{agree(len(tests), 'Test', 'Tests')} {listed(tests)} cannot show {name}: how far it is "
        f"in {agree(len(tests), 'its', 'their')} figures cannot be told, and to compare them with "
        "those of the other tests may mislead."
        for name, tests in by_effect.items()
    ]


def left_over_words(found: LeftOver) -> str:
    """What remains beside the mechanisms, and why it was not added."""
    return (
        f"{_remains(found)}. It is so small a part of the error that it may also be that what was "
        "found has a slightly different shape, so it was not added; do not take it for absent."
    )


def _remains(found: LeftOver) -> str:
    gain = f"log Bayes factor {rounded(found.log_evidence_gain, 2.0)}"
    if found.id == UNKNOWN:
        what = f"a curve over {coordinate(found.coordinate or '').name} would follow it ({gain})"
    else:
        what = f"{effect_name(found.id)} would carry it best ({gain})"
    return f"More remains than chance leaves: {what}"


def remaining_cells(levels: Mapping[float, float | None]) -> tuple[str, str, str]:
    """Hours left at 5, 50 and 95 %, to the digits that they allow; "later" past the horizon."""
    early, middle, late = (levels.get(level) for level in (0.05, 0.50, 0.95))
    # Where the late end is past the horizon, the wait for the early one bounds its digits.
    spread = math.inf if early is None or late is None else max((late - early) / 2.0, 1.0)
    return (
        "later" if early is None else hours(date_down(early, 0.0, spread)),
        "later" if middle is None else hours(middle, about_middle(middle, early, late)),
        "later" if late is None else hours_up(late, spread),
    )


def remaining_words(levels: Mapping[float, float | None]) -> str:
    """Say the hours left at 90 %, to go on after "remaining life is"."""
    if levels.get(0.95) == 0.0:
        return "used up"
    early, middle, late = remaining_cells(levels)
    if early == "later":
        return "beyond the horizon"
    at_once = without_unit(early) == "0"
    if late == "later":
        chance = "probably" if middle == "later" else "possibly"
        some = f"at least {early} and {chance} beyond the horizon"
        return "anything from none to beyond the horizon" if at_once else some
    return f"at most {late}" if at_once else f"between {without_unit(early)} and {late}"


def moved_words(old: Mapping[float, float | None], new: Mapping[float, float | None]) -> str | None:
    """Say what the effects did to the hours left; None where none are left either way."""
    before, after = remaining_words(old), remaining_words(new)
    if old.get(0.95) == new.get(0.95) == 0.0:
        return None
    if before == after:
        return f"Remaining life (90 %) is {after}, with what was added and without it."
    return f"Without what was added, remaining life (90 %) is {before}; with it, {after}."


def carriers(explanation: Explanation | DriveExplanation) -> tuple[Carrier, ...]:
    """Carriers of the residual, of a drive pooled over its tests."""
    if isinstance(explanation, DriveExplanation):
        return pooled_carriers(explanation.tests)
    return explanation.carried_by


def traced_sentences(explanation: Explanation | DriveExplanation) -> list[str]:
    """Sentences for the verdict: what was added, what it did, and what stays open."""
    if not explanation.effects:
        return []
    most = carrier(carriers(explanation))
    lead = "The drive model alone leaves structure"
    if most is not None:
        lead = f"The residual of the drive model follows {coordinate(most.coordinate).name}"
    names = listed(effect_name(effect.id) for effect in explanation.effects)
    found = errors(explanation)
    said = [f"{lead}; with {names} the error goes {before_and_after(found)}."]
    doubt = not_predicted(found)
    if doubt is not None:
        said.append(doubt)
    if unknown_term(explanation.effects) is not None:
        said.append(
            f"Something acts {place_of_unknown(explanation)} that is none of the known effects: "
            "what is said here may be biased by it."
        )
    if explanation.left_over is not None:
        said.append(f"{_remains(explanation.left_over)}; it was not added.")
    still = None if accounted_for(found) else above_noise(found)
    if still is not None:
        said.append(still)
    if isinstance(explanation, DriveExplanation):
        old, new = explanation.remaining_hours_before, explanation.remaining_hours_after
        moved = None if old is None or new is None else moved_words(old, new)
        if moved is not None:
            said.append(moved)
    return said
