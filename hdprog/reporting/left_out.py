"""Lasting effects that the figures which limits are held against leave out.

An effect that grows with service hours is the drive's, and a forecast follows it; one that stays
as it is belongs to the rig. Where the tests do not say, or nothing is forecast, figures are without
it, and the reader has to know what it would add.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from hdprog.config import Limit
from hdprog.explanation import UNKNOWN, DriveExplanation, Explanation, Origin
from hdprog.physics.effects import BY_ID
from hdprog.reporting.effect_words import effect_name, effect_said_before
from hdprog.reporting.present import standing, value_words
from hdprog.reporting.words import agree, capital, listed, quantity, threshold_words
from hdprog.results import DriveResult, TestResult, since_replaced

_HALF = 0.5  # of the 90 % interval without the effect: less is not worth a word


def left_out_sentences(result: DriveResult) -> list[str]:
    """Limited figures with effects that nothing else counts, of the last test that shows them."""
    *earlier, last = since_replaced(result.tests)
    said = _sentences(result, last, _left_out(result, last.effects))
    # What the last test cannot show may be there all the same, as it was when it could be seen.
    found, unseen = result.explanation, tuple[str, ...]()
    if isinstance(found, DriveExplanation):
        unseen = found.not_shown_by(last.test_id)
    hidden = _left_out(result, unseen)
    for test in reversed(earlier):
        seen = {name: origin for name, origin in hidden.items() if name in test.effects}
        if seen:
            said += _sentences(result, test, seen)
            break
    return said


def gone_sentences(result: DriveResult) -> list[str]:
    """Effects that a drive had which was replaced, and that no test of the new one shows."""
    found, own = result.explanation, len(since_replaced(result.tests))
    if not isinstance(found, DriveExplanation) or own == len(result.tests):
        return []
    sizes = {effect.id: found.amplitudes.get(effect.id) for effect in found.effects}
    # One that a record cannot show is NaN, and not said to be gone.
    gone = [name for name, size in sizes.items() if size is not None and not size[-own:, 2].any()]
    if not gone:
        return []
    named = listed(map(effect_said_before, gone), "or")
    return [f"No test since the drive was replaced shows {named}."]


def the_drives_own(found: DriveExplanation, test: Explanation) -> str:
    """Say that what a test's lasting effects add is the drive's own, and where it is counted in."""
    shown = {effect.id for effect in test.effects}
    own = [
        effect_name(effect.id)
        for effect in found.effects
        if _is_lasting(effect.id) and effect.id in shown and effect.origin == "wear"
    ]
    if not own:
        return ""
    add, it = agree(len(own), "adds", "add"), agree(len(own), "it", "them")
    return (
        f"Width, loss and lost motion in the table are the drive model's part alone. What "
        f"{listed(own)} {add} to the loop is the drive's own: with {it}, they stand under Tests "
        "(“with lasting effects”)."
    )


def _sentences(
    result: DriveResult, test: TestResult, found: Mapping[str, Origin | None]
) -> list[str]:
    """What a test's limited figures are with effects that it has; nothing where that is little."""
    told = [_told(test, limit) for limit in result.drive.limits if _matters(test, limit.key)]
    if not found or not told:
        return []
    names, many = listed(effect_name(effect) for effect in found), len(found)
    it = agree(many, "it", "them")
    if all(origin == "wear" for origin in found.values()):
        whose = f"{agree(many, 'grows', 'grow')} with wear"
    else:
        source = "from the rig or from wear, which these tests do not tell"
        whose = f"{agree(many, 'comes', 'come')} {source}"
    where = "" if test is result.tests[-1] else f" at {test.test_id}, the last test to show {it},"
    what = "Forecast and limits are held" if result.forecasts else "The limits are held"
    return [
        f"{capital(names)} {whose}. {what} against the drive without {it}; with {it}{where} "
        f"{listed(told)}."
    ]


def _left_out(result: DriveResult, among: Collection[str]) -> dict[str, Origin | None]:
    """Ids and origins of the lasting effects among these, neither followed nor the rig's."""
    explanation = result.explanation
    if explanation is None:
        found: dict[str, Origin | None] = dict.fromkeys(result.tests[-1].effects)
    else:
        found = {effect.id: effect.origin for effect in explanation.effects}
    followed = () if result.trend is None else result.trend.followed
    return {
        name: origin
        for name, origin in found.items()
        if _is_lasting(name) and name in among and name not in followed and origin != "rig"
    }


def _is_lasting(name: str) -> bool:
    """Whether wear can bring an effect, and it is part of the steady cycle of the figures."""
    return name != UNKNOWN and BY_ID[name].lasting and BY_ID[name].static


def _matters(test: TestResult, key: str) -> bool:
    with_it, alone = test.figures_with_effects.get(key), test.figures.get(key)
    if with_it is None or alone is None:
        return False
    return abs(with_it[0.50] - alone[0.50]) > _HALF * (alone[0.95] - alone[0.05])


def _told(test: TestResult, limit: Limit) -> str:
    levels = test.figures_with_effects[limit.key]
    name, value = quantity(limit.key).name, value_words(levels, limit.key)
    its = "its limit"
    if [one.key for one in test.drive.limits].count(limit.key) > 1:
        its = f"the limit {limit.direction} {threshold_words(limit.key, limit.threshold)}"
    return f"{name} is {value}, {standing(levels, limit)} {its}"
