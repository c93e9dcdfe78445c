"""Evidence of effects that tests have in common, on Gaussian cases whose answers are known."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from hdprog.discovery.drive import _pooled_effect
from hdprog.discovery.explain import Closed
from hdprog.discovery.forward_step import Step
from hdprog.discovery.model import Model, gain_over
from hdprog.discovery.pooling import THRESHOLD, pooled
from hdprog.discovery.search import Traced
from hdprog.discovery.sharing import (
    SCATTERS,
    Said,
    common_evidence,
    gain_together,
    sharing_effect,
)
from hdprog.explanation import FoundEffect
from hdprog.inference.likelihood import COUNT
from hdprog.physics.course import Scales
from hdprog.physics.effects import BY_ID
from hdprog.physics.effects.model import EffectSet

NAME = "coulomb_friction"
NOISE = 0.05  # of a coordinate that a test says something of, in prior standard deviations


def said(seen: np.ndarray, columns: np.ndarray) -> Said:
    """Readings y = columns · x + e with e ~ N(0, NOISE²)."""
    constant = multivariate_normal(np.zeros(seen.size), NOISE**2 * np.eye(seen.size)).logpdf(seen)
    return Said(columns.T @ columns / NOISE**2, columns.T @ seen / NOISE**2, float(constant))


def scales(angle: float) -> Scales:
    return Scales(torque=60.0, angle=angle, duration=100.0, rate=1.0, sweep=None, readings=200)


def model(
    angle: float, mode: np.ndarray, sd: np.ndarray, log_evidence: float = 0.0, name: str = NAME
) -> Model:
    """A model of which only the mode counts, its effect at coordinates `mode` with errors `sd`."""
    effects = EffectSet((BY_ID[name],), scales(angle))
    variance = np.concatenate([np.ones(COUNT + 1), sd**2])
    return cast(
        Model,
        SimpleNamespace(
            ids=(name,),
            log_evidence=log_evidence,
            likelihood=SimpleNamespace(
                effect_set=effects,
                reduced=SimpleNamespace(course=SimpleNamespace(scales=effects.scales)),
            ),
            start=SimpleNamespace(
                point=np.concatenate([np.zeros(COUNT + 1), mode]), covariance=np.diag(variance)
            ),
        ),
    )


def size_of(name: str) -> int:
    return len(BY_ID[name].parameters(scales(2e-3)))


def test_evidence_is_that_of_all_readings_together() -> None:
    rng = np.random.default_rng(1)
    columns = [rng.standard_normal((4, 2)) for _ in range(3)]
    seen = [one @ [0.7, -0.3] + NOISE * rng.standard_normal(4) for one in columns]
    tests = [said(*one) for one in zip(seen, columns, strict=True)]
    own = 0.0
    for readings, matrix in zip(seen, columns, strict=True):
        covariance = matrix @ matrix.T + NOISE**2 * np.eye(4)
        own += float(multivariate_normal(np.zeros(4), covariance).logpdf(readings))
    assert sum(one.log_evidence for one in tests) == pytest.approx(own, abs=1e-9)
    stacked, found = np.vstack(columns), []
    for scatter in SCATTERS:
        covariance = stacked @ stacked.T + NOISE**2 * np.eye(12)
        for at, matrix in enumerate(columns):
            rows = slice(4 * at, 4 * at + 4)
            covariance[rows, rows] += scatter**2 * matrix @ matrix.T
        together = multivariate_normal(np.zeros(12), covariance)
        found.append(float(together.logpdf(np.concatenate(seen))))
    wanted = logsumexp(found) - np.log(len(found))
    assert common_evidence(tests) == pytest.approx(wanted, abs=1e-8)


def test_a_test_that_says_nothing_changes_nothing() -> None:
    some = [said(np.array([0.4, 0.5]), np.ones((2, 1))) for _ in range(2)]
    silent = Said(np.zeros((1, 1)), np.zeros(1))
    assert common_evidence([*some, silent]) == pytest.approx(common_evidence(some), abs=1e-12)
    assert common_evidence([silent, silent]) == pytest.approx(0.0, abs=1e-12)


def test_sharing_is_seen_where_it_is_and_hardly_ever_where_it_is_not() -> None:
    """Of 2 000 drives with four tests of their own each, at most exp(−5) may seem to share."""
    rng = np.random.default_rng(2)
    tests, columns = 4, np.eye(2)

    def gain(truths: np.ndarray) -> float:
        seen = truths + NOISE * rng.standard_normal((tests, 2))
        each = [said(one, columns) for one in seen]
        return common_evidence(each) - sum(one.log_evidence for one in each)

    own = [gain(rng.standard_normal((tests, 2))) for _ in range(2000)]
    assert np.mean(np.array(own) > THRESHOLD) < np.exp(-THRESHOLD)
    shared = [gain(np.tile(rng.standard_normal(2), (tests, 1))) for _ in range(200)]
    assert min(shared) > THRESHOLD
    scattered = [
        gain(rng.standard_normal(2) + 0.1 * rng.standard_normal((tests, 2))) for _ in range(200)
    ]
    assert np.mean(np.array(scattered) > 0.0) > 0.95


def test_modes_of_records_of_other_scales_are_compared_in_physical_units() -> None:
    """The same angle is another coordinate where the prior suits a record of twice the angle."""
    count = size_of(NAME)
    sd = np.full(count, 0.05)
    small, large = (EffectSet((BY_ID[NAME],), scales(angle)).parameters for angle in (2e-3, 4e-3))
    mode = np.full(count, 0.3)
    same = np.array(
        [
            other.coordinate(float(one.value(np.asarray(0.3))))
            for (_, one), (_, other) in zip(small, large, strict=True)
        ]
    )
    assert not np.allclose(same, mode)
    alike = sharing_effect([model(2e-3, mode, sd), model(4e-3, same, sd)], NAME)
    equal = sharing_effect([model(2e-3, mode, sd), model(2e-3, mode, sd)], NAME)
    assert alike == pytest.approx(equal, abs=0.5)
    unlike = sharing_effect([model(2e-3, mode, sd), model(4e-3, mode, sd)], NAME)
    assert unlike < alike - THRESHOLD


def test_what_the_prior_of_another_test_cannot_have_drawn_is_not_shared() -> None:
    """No number then, and no warning either."""
    count = size_of(NAME)
    small = model(2e-3, np.full(count, -5.9), np.full(count, 0.1))
    large = model(2e3, np.full(count, 5.9), np.full(count, 0.1))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert sharing_effect([small, large], NAME) == -np.inf


def gained(modes: Sequence[float], gains: Sequence[float], sd: float) -> tuple[float, bool]:
    count = size_of(NAME)
    before = [cast(Model, SimpleNamespace(log_evidence=0.0, worth=1.0)) for _ in modes]
    after = [
        model(2e-3, np.full(count, one), np.full(count, sd), gain)
        for one, gain in zip(modes, gains, strict=True)
    ]
    return gain_together(NAME, before, after)


def test_what_all_tests_have_alike_is_found_though_none_shows_it_alone() -> None:
    gain, common = gained([0.5, 0.51, 0.49, 0.5], [-1.0, 2.0, 1.5, -0.5], 0.03)
    assert common
    assert gain > THRESHOLD
    gain, common = gained([0.5, -0.9, 1.3, -0.2], [-1.0, 2.0, 1.5, -0.5], 0.03)
    assert not common
    assert gain == pooled([-1.0, 2.0, 1.5, -0.5])


def test_one_test_has_nothing_in_common() -> None:
    assert gained([0.5], [3.0], 0.03) == (3.0, False)


def test_tests_that_cannot_show_an_effect_do_not_count() -> None:
    count: Any = size_of(NAME)
    before = [cast(Model, SimpleNamespace(log_evidence=0.0, worth=1.0)) for _ in range(3)]
    shown = [model(2e-3, np.full(count, 0.5), np.full(count, 0.03), gain) for gain in (1.0, 2.0)]
    assert gain_together(NAME, before, [*shown, None]) == gain_together(NAME, before[:2], shown)


@pytest.mark.parametrize("worth", [1.0, 0.3])
def test_a_drive_s_effect_gains_what_the_search_saw_it_gain(worth: float) -> None:
    """Also where an angle's wide steps make readings worth less: sharing counts for less, too."""
    count = size_of(NAME)
    before = [cast(Model, SimpleNamespace(log_evidence=0.0, worth=worth)) for _ in range(3)]
    after = [
        model(2e-3, np.full(count, mode), np.full(count, 0.03), gain)
        for mode, gain in ((0.5, 8.0), (0.51, 12.0), (0.49, 9.0))
    ]
    wanted, common = gain_together(NAME, before, after)
    assert common
    assert wanted > worth * (8.0 + 12.0 + 9.0) + 1.0
    found = FoundEffect(
        id=NAME,
        words="",
        coordinate=None,
        log_evidence_gain=0.0,
        elpd_gain=0.0,
        elpd_se=0.0,
        share=0.5,
        parameters={},
        units={},
        indistinguishable_from=(),
        separating_test=None,
        advice="",
    )
    traced, closed = [], []
    for one, two in zip(before, after, strict=True):
        effect = replace(found, log_evidence_gain=gain_over(one, two))
        traced.append(SimpleNamespace(final=two, steps=(Step(one, {NAME: two}, {}),)))
        closed.append(SimpleNamespace(explanation=SimpleNamespace(effects=(effect,))))
    sizes, nothing = np.full((3, 4), 1e-5), [None] * 3
    pooled_effect = _pooled_effect(
        NAME, cast(Sequence[Traced], traced), cast(Sequence[Closed], closed), sizes, nothing
    )
    assert pooled_effect.log_evidence_gain == pytest.approx(wanted)
