"""What a record must have for an effect, and planted effects found from the drive model's modes."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.coordinates import record_course
from hdprog.data.loop import Loop
from hdprog.errors import BadInputError
from hdprog.inference.effect_starts import effect_starts, require, search_widely, unmet
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.prepare import prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.starting_points import StartingPoint, descend
from hdprog.physics.course import Course
from hdprog.physics.effects import BY_ID, EFFECTS
from hdprog.physics.effects.model import EffectSet
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath
from tests.inference.inverse import coordinates_of
from tests.physics.table2 import POST_TEST

ALPHA = math.radians(30)
DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
PRIOR = read_prior_file("csf-25-80").prior(None)
NOISE = 1e-5


def history(*corners: float, seconds: tuple[float, ...], samples: int = 221) -> FloatArray:
    """Time and torque (2, samples) of straight ramps that last so long each."""
    at = np.cumsum([0.0, *seconds])
    time = np.unique(np.concatenate([np.linspace(0, at[-1], samples), at]))
    return np.array([time, np.interp(time, at, corners)])


def course_of(time: FloatArray | None, torque: FloatArray, output: FloatArray | None) -> Course:
    loop = Loop(torque, torque / 1.5e4, time, output_angle=output)
    return record_course(loop, TorquePath.exact(torque), 0.0)


TWO_RATES = history(0, 60, -60, 60, -60, seconds=(20, 40, 10, 10))
ONE_RATE = history(0, 60, -60, 60, -60, seconds=(10, 20, 20, 20))
ONE_SIGN = history(0, 60, 0, 60, -3, seconds=(20, 20, 5, 5.25))
ONE_WAY = history(-60, 10, 60, seconds=(20, 5))


def test_a_full_record_can_show_every_effect() -> None:
    time, torque = TWO_RATES
    course = course_of(time, torque, 0.1 * time)
    assert {effect.id for effect in EFFECTS if unmet(effect, course)} == set()


@pytest.mark.parametrize(
    ("need", "course"),
    [
        ("both signs of torque", course_of(ONE_SIGN[0], ONE_SIGN[1], ONE_SIGN[0])),
        ("several loading rates", course_of(ONE_RATE[0], ONE_RATE[1], ONE_RATE[0])),
        ("output angle", course_of(TWO_RATES[0], TWO_RATES[1], None)),
        ("reversal", course_of(ONE_WAY[0], ONE_WAY[1], ONE_WAY[0])),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_one_thing_that_a_record_lacks(need: str, course: Course) -> None:
    concerned = [effect for effect in EFFECTS if need in effect.needs]
    assert concerned
    for effect in EFFECTS:
        assert unmet(effect, course) == ((need,) if effect in concerned else ())


def test_an_untimed_record_has_no_time_and_no_rate() -> None:
    course = course_of(None, TWO_RATES[1], TWO_RATES[0])
    for effect in EFFECTS:
        wanted = effect.needs & {"time", "several loading rates"}
        assert unmet(effect, course) == tuple(sorted(wanted))
    assert unmet(BY_ID["viscous_friction"], course) == ("several loading rates", "time")


def test_a_still_output_shows_no_kinematic_error() -> None:
    time, torque = TWO_RATES
    course = course_of(time, torque, np.full(time.size, 0.7))
    assert unmet(BY_ID["kinematic_error"], course) == ("output angle",)


def test_an_effect_that_a_record_cannot_show_is_refused() -> None:
    course = course_of(None, TWO_RATES[1], None)
    require(BY_ID["backlash"], course, "loop.csv")
    with pytest.raises(BadInputError) as refused:
        require(BY_ID["viscous_friction"], course, "loop.csv")
    for word in ("loop.csv", "without several loading rates and time", "viscous_friction needs"):
        assert word in str(refused.value)


# Physical values, and how far from them the mode may be (in the same unit).
PLANTED: dict[str, dict[str, tuple[float, float]]] = {
    "creep": {
        "amplitude": (8e-5, 3e-5),
        "time_constant": (6.0, 4.0),
        "quick_share": (0.5, 0.4),
        "left_before": (0.1, 0.15),
    },
    "backlash": {"play": (3e-4, 1e-4), "width": (0.7, 0.5), "centre": (0.0, 0.5)},
    "angle_ripple": {
        "cycles": (1100.0, 11.0),
        "sine": (1.5e-5, 6e-6),
        "cosine": (-1e-5, 6e-6),
        "second_sine": (4e-6, 5e-6),
        "second_cosine": (3e-6, 5e-6),
    },
    "slip_jump": {"step": (4e-5, 1e-5), "instant": (0.43, 0.01), "duration": (0.004, 0.01)},
    "tooth_damage": {"height": (4e-5, 1.2e-5), "centre": (38.0, 1.5), "width": (4.0, 1.5)},
}


@lru_cache(maxsize=1)
def planted(name: str) -> tuple[LoopLikelihood, list[StartingPoint], FloatArray]:
    """Likelihood with the effect, modes without it, and the true point."""
    rng = np.random.default_rng(1)
    time, torque = history(0, 80, -80, 0, 80, -80, seconds=(20, 40, 10, 10, 30))
    course = record_course(Loop(torque, torque / 1.5e4, time), TorquePath.exact(torque), 0.0)
    effects = EffectSet((BY_ID[name],), course.scales)
    values = {name: {key: np.array([[value]]) for key, (value, _) in PLANTED[name].items()}}
    drive = {key: np.array([value]) for key, value in POST_TEST.items()}
    angle = effects.angle(course, drive, values, ALPHA, np.array([0.5]))[0]
    loop = Loop(torque, angle + NOISE * rng.standard_normal(time.size), time)
    prepared = prepare(loop, DRIVE, rng, prior=PRIOR)
    likelihood = replace(prepared.likelihood, effects=(BY_ID[name],))
    parameters = BY_ID[name].parameters(likelihood.reduced.course.scales)
    truth = np.concatenate(
        [
            coordinates_of(PRIOR, POST_TEST),
            [0.0],
            [one.coordinate(PLANTED[name][one.name][0]) for one in parameters],
        ]
    )
    return likelihood, prepared.starts, truth


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_effect_is_found(name: str) -> None:
    """From the drive model's modes, the mode that a descent from the truth reaches.

    Values may be off by 4 standard deviations of the mode's Gaussian and by no more than stated.
    For Gaussian modes that is a false alarm of 6e-5 a value, 1e-3 over all of them.
    """
    likelihood, without, truth = planted(name)
    modes = effect_starts(likelihood, without)
    found = search_widely(likelihood, modes, np.random.default_rng(2))
    best = found[0]
    assert [start.deviance for start in found] == sorted(start.deviance for start in found)
    from_truth = descend(likelihood, truth, 100)
    assert from_truth is not None
    assert best.deviance < from_truth.deviance + 0.5
    sd = np.sqrt(np.diag(best.covariance))
    parameters = BY_ID[name].parameters(likelihood.reduced.course.scales)
    for index, parameter in enumerate(parameters, start=COUNT + 1):
        value, tolerance = PLANTED[name][parameter.name]
        found_value = float(parameter.value(best.point[index]))
        assert found_value == pytest.approx(value, abs=tolerance), parameter.name
        assert abs(best.point[index] - truth[index]) < 4 * sd[index], parameter.name


@pytest.mark.parametrize("name", PLANTED)
def test_the_best_shapes_alone_show_a_planted_effect(name: str) -> None:
    """Without draws of the prior the mode may lie elsewhere, but the effect is not overlooked."""
    likelihood, without, _ = planted(name)
    found = effect_starts(likelihood, without)
    assert found[0].deviance < without[0].deviance - 10.0


def test_an_effect_that_is_not_there_stays_small() -> None:
    """Tooth damage on a loop that only slips once: below a third of the noise of a reading."""
    likelihood, without, _ = planted("slip_jump")
    jumped = effect_starts(likelihood, without)
    both = replace(likelihood, effects=(BY_ID["slip_jump"], BY_ID["tooth_damage"]))
    found = effect_starts(both, jumped)[0]
    # χ² with 3 over about 40 places for a bump: false alarm 1e-3.
    assert found.deviance > jumped[0].deviance - 24.0
    bumps = found.point.copy()
    bumps[likelihood.size] = 0.0
    change = np.diff(both.angle(np.stack([bumps, found.point])), axis=0)
    assert np.std(change) < 0.33 * NOISE
