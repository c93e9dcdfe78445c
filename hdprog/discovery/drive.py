"""The tests of one drive together: which effects they share, and whether these grow."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

import numpy as np

from hdprog.discovery.considered import cannot_be_told, why_not
from hdprog.discovery.explain import Closed
from hdprog.discovery.found import advice_on, choosing_step, effect_size
from hdprog.discovery.search import Traced
from hdprog.discovery.separating import indistinguishable, separating_test
from hdprog.discovery.sharing import gain_of_steps, sharing_effect
from hdprog.discovery.verdict import verdict_of
from hdprog.explanation import (
    UNKNOWN,
    ConsideredEffect,
    DriveExplanation,
    Explanation,
    FoundEffect,
    Origin,
    Verdict,
)
from hdprog.inference.effect_starts import unmet
from hdprog.inference.posterior import Posterior
from hdprog.physics.effects import BY_ID
from hdprog.physics.effects.base import Effect
from hdprog.physics.parameters import FloatArray
from hdprog.results import DEVIATIONS_IN_90, lives

_FEWEST_TESTS = 3
_GROWN = 1.5  # times over the tests: less may be the scatter of remounting
_SCATTER = 0.15  # of an effect's size from test to test that is no growth
_CLEAR = 3.0  # standard errors of the slope
_ON_A_LINE = 2.5  # the same where sizes lie along the line rather than on two levels
_NONE = 2.0
_TAKEN_APART = ("regreased", "reassembled")
_COMMON = 0.8  # share of the tests that carry an effect of the rig


def explain_drive(
    traced: Sequence[Traced], closed: Sequence[Closed], events: Sequence[str | None]
) -> DriveExplanation:
    """Pool the explanations of a drive's tests.

    Parameters
    ----------
    traced, closed : one a test, by service hours
    events : before each test, as declared
    """
    tests = tuple(one.explanation for one in closed)
    names = dict.fromkeys(effect.id for test in tests for effect in test.effects)
    after, hours = [one.after for one in closed], [test.service_hours for test in tests]
    sizes = {
        name: _sizes_of_unknown(tests) if name == UNKNOWN else _sizes_shown(name, after, hours)
        for name in names
    }
    found = [_pooled_effect(name, traced, closed, sizes[name], events) for name in names]
    found.sort(key=lambda effect: (effect.id == UNKNOWN, -effect.share))
    return DriveExplanation(
        verdict=_verdict(names, tests),
        effects=tuple(found),
        considered=_considered(traced, closed, set(names)),
        amplitudes=sizes,
        tests=tests,
    )


def _verdict(names: Collection[str], tests: Sequence[Explanation]) -> Verdict:
    """Verdict on all tests together."""

    def pooled(each: Iterable[float]) -> float:
        return float(np.sqrt(np.mean(np.square(list(each)))))

    return verdict_of(
        names,
        pooled(test.before.rmse_rad for test in tests),
        pooled(test.after.rmse_rad for test in tests),
        pooled(test.noise_floor_rad for test in tests),
        left_over=any(test.left_over is not None for test in tests),
    )


def lasting_effects(posteriors: Sequence[Posterior]) -> tuple[Effect, ...]:
    """Lasting effects of the steady cycle that the tests of a drive have."""
    found = dict.fromkeys(name for one in posteriors for name in one.effects)
    mechanisms = [BY_ID[name] for name in found if name != UNKNOWN]
    return tuple(effect for effect in mechanisms if effect.lasting and effect.static)


def brought_by_wear(
    posteriors: Sequence[Posterior], hours: Sequence[float], events: Sequence[str | None]
) -> tuple[Effect, ...]:
    """Lasting effects of the steady cycle that grow over the tests of a drive.

    Those that came as it was taken apart or regreased among them: the trend has a step there.

    Parameters
    ----------
    posteriors, hours : one a test, by service hours
    events : before each test, as declared
    """
    found = []
    for effect in lasting_effects(posteriors):
        sizes = _sizes_shown(effect.id, posteriors, hours)
        if any(_along_hours(life) == "wear" for life, _ in _lives(sizes, events)):
            found.append(effect)
    return tuple(found)


def _sizes_shown(
    name: str, posteriors: Sequence[Posterior], hours: Sequence[float | None]
) -> FloatArray:
    """(tests, 4) service hours and 5 %, 50 %, 95 % of the angle that an effect moves, in rad.

    NaN where a record cannot show the effect: it does not say that it is absent.
    """
    rows = np.zeros((len(posteriors), 4))
    for row, posterior, when in zip(rows, posteriors, hours, strict=True):
        row[0] = np.nan if when is None else when
        if name in posterior.effects:
            row[1:] = np.quantile(effect_size(posterior, name), (0.05, 0.5, 0.95))
        elif unmet(BY_ID[name], posterior.likelihood.reduced.course):
            row[1:] = np.nan
    return rows


def _sizes_of_unknown(tests: Sequence[Explanation]) -> FloatArray:
    """The same of the empirical term, whose size is that of its course."""
    rows = np.zeros((len(tests), 4))
    for row, test in zip(rows, tests, strict=True):
        row[0] = np.nan if test.service_hours is None else test.service_hours
        if test.course.unknown is not None:
            row[1:] = np.std(test.course.unknown)
    return rows


def origin_of(sizes: FloatArray, events: Sequence[str | None]) -> Origin:
    """Whether an effect belongs to the rig (the same in all tests) or grows with wear.

    Wear is what grows over the tests of one and the same drive: where a drive was replaced, an
    effect that the new one has and the old one had not did not grow. Nor did what came as the drive
    was taken apart or regreased: whether that is the drive's, the tests do not tell.

    Parameters
    ----------
    sizes : (tests, 4) service hours and 5 %, 50 %, 95 % of the effect's size; NaN where a test
        cannot show the effect
    events : before each test, as declared
    """
    lives = _lives(sizes, events)
    if any(_along_hours(life) == "wear" and not _came_with(life, done) for life, done in lives):
        return "wear"
    whole = _along_hours(sizes)
    return "unclear" if whole == "wear" else whole


def _lives(
    sizes: FloatArray, events: Sequence[str | None]
) -> list[tuple[FloatArray, list[str | None]]]:
    """Sizes and events of each drive that was there, one after the other."""
    return [(sizes[tests], list(events[tests])) for tests in lives(events)]


def _along_hours(sizes: FloatArray) -> Origin:
    """What the tests of one drive say by themselves.

    A line through the sizes over service time, weighted by their errors and a scatter of 15 % from
    test to test: growth by half at more than three standard errors is wear, at more than two and a
    half where no two levels, one after the other, are nearer to the sizes; no slope, in at least
    four of five tests, is the rig. A test without the effect says that it is absent no better than
    the others say how large it is, and one that cannot show it says nothing.
    """
    if not np.isfinite(sizes[:, 0]).all():
        return "unclear"
    sizes = sizes[np.isfinite(sizes[:, 2])]
    if len(sizes) < _FEWEST_TESTS or np.ptp(sizes[:, 0]) == 0:
        return "unclear"
    hours, size = sizes[:, 0] / sizes[:, 0].max(), sizes[:, 2]
    present = size > 0
    if not present.any():
        return "unclear"
    error = _errors(sizes)
    (level, slope), covariance, left = _fitted(_line(hours), size, error)
    first, last = max(level + slope * hours[0], 0.0), level + slope * hours[-1]
    clear = slope / np.sqrt(covariance[1, 1])
    if last > _GROWN * first and (
        clear > _CLEAR or (clear > _ON_A_LINE and left < _left_by_levels(size, error))
    ):
        return "wear"
    if present.mean() >= _COMMON and abs(clear) < _NONE:
        return "rig"
    return "unclear"


def _left_by_levels(size: FloatArray, error: FloatArray) -> float:
    """Sum of squares left by the best two levels, one after the other."""
    after = np.arange(len(size))[:, None] >= np.arange(1, len(size))
    steps = (np.column_stack([~late, late]).astype(float) for late in after.T)
    return min(_fitted(design, size, error)[2] for design in steps)


def _came_with(sizes: FloatArray, events: Sequence[str | None]) -> bool:
    """Whether levels that change where something was done to a drive say more than a line does.

    By Schwarz's criterion: a level between each two events against level and slope.
    """
    done = [at > 0 and event in _TAKEN_APART for at, event in enumerate(events)]
    shown = np.isfinite(sizes[:, 2])
    stretches, stretch = np.unique(np.cumsum(done)[shown], return_inverse=True)
    if stretches.size < 2:
        return False
    sizes = sizes[shown]
    levels, line = np.eye(stretches.size)[stretch], _line(sizes[:, 0] / sizes[:, 0].max())
    stepped, grown = (
        _fitted(design, sizes[:, 2], _errors(sizes))[2] + design.shape[1] * np.log(len(sizes))
        for design in (levels, line)
    )
    return bool(stepped < grown)


def _line(hours: FloatArray) -> FloatArray:
    return np.column_stack([np.ones_like(hours), hours])


def _errors(sizes: FloatArray) -> FloatArray:
    """(tests,) standard deviations of the sizes about their course, remounting among them."""
    size, present = sizes[:, 2], sizes[:, 2] > 0
    error = np.hypot((sizes[:, 3] - sizes[:, 1]) / DEVIATIONS_IN_90, _SCATTER * size)
    error[~present] = np.median(error[present])
    return np.asarray(np.maximum(error, 0.3 * np.median(size[present])))


def _fitted(
    design: FloatArray, size: FloatArray, error: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """Weighted least squares: coefficients, their covariance, and the sum of squares left."""
    weighted = design / error[:, None]
    covariance = np.linalg.inv(weighted.T @ weighted)
    coefficients = covariance @ weighted.T @ (size / error)
    left = float(np.sum(((size - design @ coefficients) / error) ** 2))
    return coefficients, np.asarray(covariance), left


def _pooled_effect(
    name: str,
    traced: Sequence[Traced],
    closed: Sequence[Closed],
    sizes: FloatArray,
    events: Sequence[str | None],
) -> FoundEffect:
    carried = [
        (effect, record)
        for one, record in zip(closed, traced, strict=True)
        for effect in one.explanation.effects
        if effect.id == name
    ]
    last = carried[-1][0]
    others: tuple[str, ...] = ()
    advice = last.advice
    gain = sum(effect.log_evidence_gain for effect, _ in carried)
    if name != UNKNOWN:
        found = (choosing_step(record.steps, name) for _, record in carried)
        steps = [step for step in found if step is not None]
        shared = sharing_effect([record.final for _, record in carried], name)
        worth = np.mean([step.before.worth for step in steps] or [1.0])
        gain += float(worth) * max(shared, 0.0)
        others = indistinguishable(steps, name)
        advice = advice_on(BY_ID[name], steps)
        named = {identifier for record in traced for identifier in record.final.ids}
        others = tuple(other for other in others if other not in named)
    return replace(
        last,
        log_evidence_gain=gain,
        elpd_gain=sum(effect.elpd_gain for effect, _ in carried),
        elpd_se=float(np.sqrt(sum(effect.elpd_se**2 for effect, _ in carried))),
        share=float(np.mean([effect.share for effect, _ in carried])),
        indistinguishable_from=others,
        separating_test=separating_test({name, *others}),
        advice=advice,
        origin=origin_of(sizes, events),
    )


def _considered(
    traced: Sequence[Traced], closed: Sequence[Closed], found: set[str]
) -> tuple[ConsideredEffect, ...]:
    """What was looked at and not added, best first, then what no test can show."""
    if len(closed) == 1:  # there is nothing to pool
        return closed[0].explanation.considered
    gains = [
        {name: gain_of_steps(name, stage)[0] for name in {n for step in stage for n in step.models}}
        for stage in zip(*(record.steps for record in traced), strict=True)
    ]
    taken = {name for record in traced for name in record.mechanisms.ids}
    left = sorted({name for record in traced for name in record.final.ids})
    seen = {
        effect.id: effect
        for one in closed
        for effect in one.explanation.considered
        if effect.id not in found
    }
    lacking = {name: [record.missing.get(name, ()) for record in traced] for name in seen}

    def why(name: str) -> str:
        if name not in gains[0]:
            return cannot_be_told(lacking[name])
        said = why_not(name, gains, taken, left, UNKNOWN in found, decided=True)
        hidden = sum(map(bool, lacking[name]))
        return f"{said}; {hidden} of {len(traced)} tests cannot show it" if hidden else said

    looked_at = sorted(gains[0].items(), key=lambda item: (-item[1], item[0]))
    names = [name for name, _ in looked_at if name in seen]
    names += [name for name in seen if name not in gains[0]]
    return tuple(
        ConsideredEffect(name, seen[name].words, gains[0].get(name), None, None, why(name))
        for name in names
    )
