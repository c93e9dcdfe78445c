"""The search on loops of an independent simulator, whose effects have shapes of their own.

One fixed loop a case, chosen for its short search: these tests show that the parts work together.
How often the search is right over many loops is measured by tests/benchmarks/effects.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.drive_folder import read_drive_folder, read_test_loop
from hdprog.data.loop import Loop
from hdprog.discovery import forward_step, search
from hdprog.discovery.candidates import refits
from hdprog.discovery.model import Model
from hdprog.discovery.pooling import THRESHOLD, pooled, share
from hdprog.discovery.search import Traced, base_model, trace
from hdprog.discovery.unknown import term_gains
from hdprog.inference.prepare import Prepared, prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID, EFFECTS
from hdprog.physics.effects.base import Effect
from tests.independent.loops import LoopKind, random_loop
from tests.make_undeclared_effect import CASES, write_case
from tests.physics.table2 import POST_TEST

DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
PRIOR = read_prior_file("csf-25-80").prior(None)

SOME = tuple(BY_ID[name] for name in ("torque_offset", "slip_jump", "creep", "backlash"))

# Kind of loop, its seed, and the size of each effect in rad (root mean square).
LOOPS: dict[str, tuple[LoopKind, int, Mapping[str, float]]] = {
    "clean": ("two-sided", 13, {}),
    "creep": ("multi-rate", 15, {"creep": 5e-5}),
    "torque_offset": ("two-sided", 15, {"torque_offset": 1.5e-4}),
    "tooth_damage": ("one-sided", 13, {"tooth_damage": 8e-5}),
    "off the list": ("two-sided", 13, {"stick_slip_teeth": 5e-5}),
    "two at once": ("two-sided", 15, {"slip_jump": 8e-5, "torque_offset": 1.2e-4}),
}


@lru_cache
def traced(case: str) -> Traced:
    return trace([prepared(case)], [np.random.SeedSequence(1)])[0]


def prepared(case: str) -> Prepared:
    kind, seed, sizes = LOOPS[case]
    record = random_loop(np.random.default_rng(seed), kind, effects=sizes, samples=150)
    loop = Loop(record.torque, record.angle, record.time, record.temperature, record.output_angle)
    return prepare(loop, DRIVE, np.random.default_rng(0), prior=PRIOR)


def test_nothing_is_found_on_a_clean_loop() -> None:
    """At most one clean loop in twenty may get an effect; this one must not."""
    found = traced("clean")
    assert found.final is found.base
    assert (found.final.ids, found.final.term) == ((), None)
    assert len(found.steps) == 1
    assert max(found.steps[0].gains.values()) < THRESHOLD
    assert max(term.gain for term in found.steps[0].terms.values()) < THRESHOLD


@pytest.mark.parametrize("name", ["creep", "torque_offset", "tooth_damage"])
def test_one_effect_is_named_and_nothing_else(name: str) -> None:
    found = traced(name)
    assert found.final.ids == (name,)
    assert found.final.term is None
    assert found.mechanisms is found.final
    assert found.final.log_evidence > found.base.log_evidence + 2 * THRESHOLD
    assert found.final.misfit < 0.8 * found.base.misfit
    gains = found.steps[0].gains
    assert max(gains, key=lambda other: gains[other]) == name
    # The second step looked at all the others and added none.
    assert len(found.steps) == 2
    assert name not in found.steps[1].gains
    assert max(found.steps[1].gains.values(), default=0.0) < max(gains.values())


def test_what_is_on_no_list_is_called_unknown() -> None:
    """Saw teeth on the falling branch: an empirical term over the branch, and no mechanism."""
    found = traced("off the list")
    assert found.final.ids == ()
    assert found.final.term is not None
    assert found.final.term.coordinate == "branch"
    assert found.final.misfit < 0.5 * found.base.misfit


def test_two_effects_at_once_are_both_named() -> None:
    found = traced("two at once")
    assert set(found.final.ids) == {"slip_jump", "torque_offset"}
    assert found.final.term is None
    assert len(found.steps) == 3


@pytest.mark.parametrize("enough", [True, False])
def test_a_small_effect_is_added_where_it_keeps_a_free_curve_out(
    enough: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def curve_unless_all(
        bases: Sequence[Model], models: Sequence[Model], *_: Any
    ) -> Sequence[Model]:
        return models if enough and len(models[0].ids) == 2 else bases

    for name in ("FURTHER_SHARE", "CLEARING_SHARE"):
        monkeypatch.setattr(search, name, np.inf)
    monkeypatch.setattr(search, "CLEAR_EVIDENCE", np.inf)
    monkeypatch.setattr(search, "with_unknown", curve_unless_all)
    seeds = [np.random.SeedSequence(1)]
    found = trace([prepared("two at once")], seeds, SOME)[0]
    assert len(found.steps) == 2
    assert set(found.final.ids) == ({"slip_jump", "torque_offset"} if enough else set())
    assert len(found.mechanisms.ids) == (2 if enough else 1)


def test_effects_that_a_record_cannot_show_are_not_tried() -> None:
    found = traced("tooth_damage")
    assert found.missing["kinematic_error"] == ("output angle",)
    for name in ("torque_offset", "backlash", "asymmetry"):
        assert found.missing[name] == ("both signs of torque",)
    assert not set(found.steps[0].gains) & set(found.missing)
    tried = set(found.steps[0].gains) | set(found.missing)
    assert tried == {effect.id for effect in EFFECTS}


def test_candidates_can_be_chosen_and_the_same_seed_finds_the_same() -> None:
    record = traced("clean").prepared
    candidates = (BY_ID["tooth_damage"], BY_ID["torque_offset"])
    found = [trace([record], [np.random.SeedSequence(2)], candidates)[0] for _ in range(2)]
    assert set(found[0].steps[0].gains) == {"tooth_damage", "torque_offset"}
    assert found[0].steps[0].gains == found[1].steps[0].gains
    np.testing.assert_array_equal(found[0].final.start.point, found[1].final.start.point)


def test_tests_of_a_drive_are_traced_alike_here_and_in_other_processes() -> None:
    """What is sent to a process is a copy: the copy's random numbers are not missed here."""

    def elsewhere(function: Callable[..., Any], *jobs: Iterable[Any]) -> Iterable[Any]:
        return [copy.deepcopy(function(*copy.deepcopy(job))) for job in zip(*jobs, strict=True)]

    records = [prepared("two at once"), prepared("torque_offset")]
    seeds = np.random.SeedSequence(1).spawn(2)
    here, away = (trace(records, seeds, SOME, spread) for spread in (map, elsewhere))
    assert here[0].final.ids
    assert here[1].final.ids
    for one, other in zip(here, away, strict=True):
        assert one.final.ids == other.final.ids
        np.testing.assert_array_equal(one.final.start.point, other.final.start.point)
        assert one.steps[-1].gains == other.steps[-1].gains


def test_a_record_that_keeps_its_model_is_not_searched_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    searched: list[Model] = []

    def watched(model: Model, effects: Sequence[Effect], *spread: Any) -> Mapping[str, Model]:
        searched.append(model)
        return refits(model, effects, *spread)

    monkeypatch.setattr(forward_step, "refits", watched)
    records = [prepared("torque_offset"), prepared("clean")]
    candidates = [BY_ID[name] for name in ("torque_offset", "slip_jump")]
    found = trace(records, np.random.SeedSequence(1).spawn(2), candidates)
    assert [one.final.ids for one in found] == [("torque_offset",), ()]
    assert [sum(model.ids == ids for model in searched) for ids in ((), ("torque_offset",))] == [
        2,
        1,
    ]
    assert set(found[1].steps[-1].gains) == {"slip_jump"}


def test_what_no_test_shows_alone_is_found_in_all_tests_that_share_it(tmp_path: Path) -> None:
    """Creep of seven tenths of the noise of a single reading, the same in five tests."""
    write_case(tmp_path / "drive", replace(CASES[0], amplitudes={"creep": 7e-6}), 7, 5)
    folder = read_drive_folder(tmp_path / "drive")
    loops = [read_test_loop(folder, test) for test in folder.tests]
    records = [prepare(one, DRIVE, np.random.default_rng(0), prior=PRIOR) for one in loops]
    found = trace(records, np.random.SeedSequence(1).spawn(5), SOME)
    gains = [one.steps[0].gains["creep"] for one in found]
    assert pooled(gains) < THRESHOLD
    assert [one.final.ids for one in found] == 5 * [("creep",)]


def test_pooled_evidence() -> None:
    assert pooled([-2.0]) == -2.0
    # Of two tests, each has it as soon as not: log of the mean of 1 and the Bayes factor.
    wanted = np.log((1 + np.exp(3.0)) / 2) + np.log((1 + np.exp(-1.0)) / 2)
    assert pooled([3.0, -1.0]) == pytest.approx(wanted)
    # However much a test speaks against it, it may simply not have it yet.
    assert pooled([20.0, -1e6]) == pytest.approx(20.0 - 2 * np.log(2.0), abs=1e-6)


def test_share_of_the_explained_error() -> None:
    def fits(*misfits: float) -> list[Model]:
        return [cast(Model, SimpleNamespace(misfit=misfit)) for misfit in misfits]

    bases, before, after = fits(9.0, 5.0), fits(5.0, 5.0), fits(3.0, 1.0)
    assert share(bases, before, after) == pytest.approx(6.0 / 10.0)
    assert share(bases, bases, after) == 1.0
    # Where nothing is explained nothing has a share.
    assert share(bases, before, fits(9.0, 6.0)) == 0.0


@pytest.mark.parametrize("seed", [0, 1, 6])
def test_a_short_record_is_not_drawn_through_its_noise(seed: int) -> None:
    """Forty-nine readings: a free curve could pass through every one of them."""
    quarter = np.linspace(0, 63, 13)
    torque = np.concatenate([quarter, quarter[-2::-1], -quarter[1:], -quarter[-2::-1]])
    noise = np.random.default_rng(seed).standard_normal(torque.size)
    loop = Loop(torque, predict(torque, POST_TEST) + 1e-5 * noise)
    found = base_model(prepare(loop, DRIVE, np.random.default_rng(0)), np.random.default_rng(0))
    assert max(term.gain for term in term_gains(found).values()) < THRESHOLD
