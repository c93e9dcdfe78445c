"""What the model lacked: which effect was traced, the error before and after, and the bias."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from hdprog.explanation import UNKNOWN, DriveExplanation, Explanation, FoundEffect
from hdprog.reporting.bias import shifts
from hdprog.reporting.effect_words import (
    SIGNIFICANT,
    carrier,
    carriers,
    coordinate,
    effect_name,
    effect_said_before,
    effect_words,
    moved_words,
)
from hdprog.reporting.error_words import errors, not_predicted
from hdprog.reporting.figures.effect_over_hours import effect_over_hours
from hdprog.reporting.figures.residual_before_after import residual_before_after
from hdprog.reporting.figures.residual_pair import residual_pair
from hdprog.reporting.figures.residual_strip import residual_height
from hdprog.reporting.figures.unknown_course import unknown_course
from hdprog.reporting.left_out import the_drives_own
from hdprog.reporting.rounding import THIN_SPACE, grouped, rounded
from hdprog.reporting.sections import effects_drive_tables as drive_tables
from hdprog.reporting.sections import effects_tables as tables
from hdprog.reporting.sections.effects_lead import lead, left
from hdprog.reporting.sections.table import Table
from hdprog.reporting.style import Picture
from hdprog.reporting.words import capital, listed, parameter_name, tidy

_FAR = 2.0  # standard deviations from which a shift is told in a sentence
_WORTH_SAYING = 0.005  # of a number: less is not called wrong
_HARDLY = 0.01  # of the error: what another effect would take as well
_PICTURED = 3  # tests of a drive
_NOT_PREDICTED = (
    " It describes this record and does not predict the parts of it that were left out: take it as "
    "a drawing of what remains, no more."
)
_OVERCONFIDENT = (
    " The error on left-out data falls, but by less than the model expects of itself: take the "
    "curve for what it shows, and its intervals as too narrow."
)
_ORIGINS = {
    "wear": "It grows with service hours, as wear does and a fault of the rig does not: it "
    "belongs to the drive.",
    "rig": "Its size does not follow service hours: it belongs to the rig or the mounting and says "
    "nothing of the drive's wear.",
    "unclear": "Whether it belongs to the rig or to wear cannot be told from these tests.",
}


@dataclass(frozen=True)
class Part:
    """A heading (or none) with what stands below it, in this order."""

    title: str = ""
    paragraphs: tuple[str, ...] = ()
    pictures: tuple[Picture, ...] = ()
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True)
class Section:
    """The finding, what is left of the error, and parts that show it.

    `doubtful`: a fit did not converge.
    """

    lead: str
    left: str
    doubtful: bool
    parts: tuple[Part, ...]


def effects(explanation: Explanation | DriveExplanation | None) -> Section | None:
    """Section of a record's or a drive's explanation; None where effects were not looked for.

    To be called under `house_style`, as pictures are drawn.
    """
    if explanation is None:
        return None
    if isinstance(explanation, DriveExplanation):
        doubtful = not all(test.converged for test in explanation.tests)
        parts = _drive(explanation)
    else:
        doubtful, parts = not explanation.converged, _record(explanation)
    return Section(lead(explanation), left(explanation), doubtful, parts)


def _record(found: Explanation) -> tuple[Part, ...]:
    doubt = not found.converged
    picture = Part("", _doubt(doubt), (residual_before_after(found),), (tables.error_table(found),))
    rest = _rejected(found)
    if not found.effects:
        return tuple(filter(None, [picture, _strain(found), rest]))
    parameters = tables.parameter_table(found.effects, "", doubtful=doubt)
    added = Part(
        "What was added, and why",
        tuple(text for effect in found.effects for text in _effect(effect, found)),
        (),
        () if parameters is None else (parameters,),
    )
    drawn = unknown_course(found)
    shape = None if drawn is None else Part("The unknown part", (), (drawn,))
    parts = [picture, _carriers(found), added, shape, _bias(found, ""), _strain(found), rest]
    return tuple(filter(None, parts))


def _drive(found: DriveExplanation) -> tuple[Part, ...]:
    doubt = any(not test.converged for test in found.tests)
    first = Part("", _doubt(doubt), (), (drive_tables.tests_table(found),))
    if not found.effects:
        return tuple(filter(None, [first, _rejected(found)]))
    parts: list[Part | None] = [first]
    for effect in found.effects:
        size = found.amplitudes.get(effect.id)
        parameters = tables.parameter_table(
            [effect], " in the last test that carries it", doubtful=doubt
        )
        parts.append(
            Part(
                capital(effect_name(effect.id)),
                _effect(effect, found),
                () if size is None else (effect_over_hours(effect, size),),
                () if parameters is None else (parameters,),
            )
        )
    affected = [test for test in found.tests if test.effects]
    parts += [_remaining(found), _carriers(found)]
    if affected:
        last = affected[-1]
        parts.append(_bias(last, f" in test {last.test_id}", the_drives_own(found, last)))
    # Each picture weighs some 80 kB: the tests that changed most stand for the others.
    most = sorted(affected, key=lambda test: test.after.rmse_rad / test.before.rmse_rad)
    pictured = sorted(most[:_PICTURED], key=found.tests.index)
    common = max((residual_height(test.course) for test in pictured), default=1.0)
    parts += [_test(test, common) for test in pictured]
    parts.append(_rejected(found))
    return tuple(filter(None, parts))


def _test(test: Explanation, common: float) -> Part:
    unknown = unknown_course(test)
    drawn = (residual_pair(test, common), *(() if unknown is None else (unknown,)))
    return Part(f"Residual of test {test.test_id}: {tables.names(test.effects)}", (), drawn)


def _doubt(doubtful: bool) -> tuple[str, ...]:
    if not doubtful:
        return ()
    return (
        "Not every fit behind this section converged (the warnings say which): its numbers are "
        "provisional.",
    )


def _carriers(found: Explanation | DriveExplanation) -> Part | None:
    carried_by = carriers(found)
    if not carried_by:
        return None
    most = carrier(carried_by)
    if most is None:
        said = (
            "No single coordinate carries a tenth of the residual or more in a way that chance "
            f"would not (p of at most {SIGNIFICANT:g})."
        )
    else:
        said = (
            f"The residual of the drive model alone goes most with "
            f"{coordinate(most.coordinate).name}, which carries {_share(most.fraction)} of it."
        )
    over = " Over all tests: mean share, and their p-values joined."
    return Part(
        "What the residual goes with",
        (said + (over if isinstance(found, DriveExplanation) else ""),),
        (),
        (tables.carrier_table(carried_by),),
    )


def _share(fraction: float) -> str:
    return f"{grouped(100.0 * fraction, 0)}{THIN_SPACE}%"


def _effect(effect: FoundEffect, found: Explanation | DriveExplanation) -> tuple[str, ...]:
    """Evidence for an effect, what else it may be, where it comes from and what to do."""
    said = [_evidence(effect) + _doubted(effect, found)]
    if effect.id == UNKNOWN:
        said.append(
            "It stands for no mechanism: it is a smooth curve through what is left, so that its "
            "cause has still to be found."
        )
    elif effect.indistinguishable_from:
        others = listed((effect_name(name) for name in effect.indistinguishable_from), "or")
        text = (
            f"On these data {others} would leave hardly more error and cannot be ruled out; the "
            f"drive's numbers are told as they are beside {effect_said_before(effect.id)}."
        )
        if effect.separating_test:
            text += f" To tell them apart: {_sentence(effect.separating_test)}"
        said.append(text)
    if effect.origin is not None:
        said.append(_ORIGINS[effect.origin])
    if effect.advice:
        said.append(f"To do: {_sentence(effect.advice)}")
    return tuple(said)


def _sentence(text: str) -> str:
    return text if text.endswith((".", "!", "?")) else f"{text}."


def _evidence(effect: FoundEffect) -> str:
    name = "The unknown part" if effect.id == UNKNOWN else capital(effect_words(effect))
    gain = tables.gain_words(effect.elpd_gain, effect.elpd_se)
    carried = f"{_share(effect.share)} of the error that can be explained"
    if effect.share < _HARDLY:
        carried += ", for what else was added would take its part"
    return (
        f"{name} carries {carried}. With it the log evidence "
        f"rises by {rounded(effect.log_evidence_gain, 2.0)}, and the expected log predictive "
        f"density on left-out blocks {'changes' if effect.elpd_gain < 0 else 'rises'} "
        f"by {gain} (one standard error)."
    )


def _doubted(effect: FoundEffect, found: Explanation | DriveExplanation) -> str:
    """What follows where an effect lowers the density on left-out blocks; else nothing."""
    if effect.elpd_gain >= 0:
        return ""
    return _OVERCONFIDENT if not_predicted(errors(found)) is None else _NOT_PREDICTED


def _bias(found: Explanation, note: str, beside: str = "") -> Part:
    moved = [s for s in shifts(found) if s.deviations is not None and abs(s.deviations) > _FAR]
    far = [s for s in moved if s.off_by is None or abs(s.off_by) >= _WORTH_SAYING]
    # By size: a stiffness known to a thousandth is many deviations off while hardly wrong.
    far.sort(key=lambda s: -math.inf if s.off_by is None else -abs(s.off_by))
    if far:
        told = listed(
            f"{tables.shift_name(shift)} ({tables.off_words(shift)})" for shift in far[:3]
        )
        lacking = listed(effect_said_before(effect.id) for effect in found.effects)
        wrong = "these" if len(far) <= 3 else f"{len(far)} numbers"
        most = "" if len(far) <= 3 else ", most of all"
        said = f"Without {lacking} {wrong} came out wrong{note}{most}: {told}."
    elif moved:
        said = (
            f"{capital(listed(map(tables.shift_name, moved)))} moved by more than two standard "
            f"deviations{note}, but by less than half a per cent."
        )
    else:
        said = f"No figure and no parameter moved by more than two standard deviations{note}."
    paragraphs = (said, beside) if beside else (said,)
    return Part("What it did to the numbers", paragraphs, (), (tables.bias_table(found, note),))


def _strain(found: Explanation) -> Part | None:
    """Parameters that the drive model alone had to bend; None where none was."""
    if not found.strained:
        return None
    far = sorted(found.strained.items(), key=lambda item: -abs(item[1]))
    told = listed(f"{parameter_name(name)} by {grouped(abs(value), 1)}" for name, value in far)
    return Part(
        "Strained parameters",
        (
            "To fit without help, the drive model had to take parameters far out in their prior, "
            f"in prior standard deviations: {told}. A drive with such values is unlikely; that "
            "alone hints at something that the model lacks.",
        ),
    )


def _remaining(found: DriveExplanation) -> Part | None:
    table = drive_tables.remaining_table(found)
    before, after = found.remaining_hours_before, found.remaining_hours_after
    if table is None or before is None or after is None:
        return None
    moved = moved_words(before, after)
    if moved is None:
        return None
    said = (
        f"{moved} The hours without it serve to compare: they are reckoned more roughly, loops "
        "and trend not sampled together."
    )
    return Part("What it did to the remaining life", (tidy(said),), (), (table,))


def _rejected(found: Explanation | DriveExplanation) -> Part | None:
    table = tables.considered_table(found.considered)
    said = _not_in_common(found.tests) if isinstance(found, DriveExplanation) else ()
    return None if table is None else Part("Considered and rejected", said, (), (table,))


def _not_in_common(tests: Sequence[Explanation]) -> tuple[str, ...]:
    """What no empirical curve was sought over, as one curve is to follow all tests."""
    each = [set(test.course.coordinates) for test in tests]
    some = sorted(set[str]().union(*each) - each[0].intersection(*each))
    if not some:
        return ()
    names = listed((coordinate(name).name for name in some), "or")
    return (
        f"Structure that no mechanism describes was not looked for over {names}: not all tests "
        "tell of that. A test by itself (hdprog explain LOOP) is searched over all that it has.",
    )
