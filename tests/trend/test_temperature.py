"""Temperature as a covariate against a dense Gaussian written out independently."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from hdprog.errors import BadInputError
from hdprog.inference.information import Linearised
from hdprog.shipped import shipped
from hdprog.trend.kalman_filter import at_reference, log_evidence, per_step_of_warmth
from hdprog.trend.relinearise import JointPrior
from hdprog.trend.smoother import draw, smooth
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.temperature import SeenTests, Temperatures
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior
from hdprog.trend.wear_prior import FILE, read_wear_prior

COUNT, DRAWS = 8, 3
WEAR_PRIOR = read_wear_prior()
STATE = StatePrior(np.linspace(-1.0, 1.0, COUNT), np.linspace(0.5, 2.0, COUNT))
HOURS = (0.0, 300.0, 300.0, 800.0, 1200.0, 1700.0)
EVENTS = (None, None, "regreased", None, "replaced", None)
RANKS = (8, 3, 8, 0, 8, 5)
ALL_KNOWN = (15.0, 35.0, 20.0, 31.0, 12.0, 28.0)
SOME_KNOWN = (15.0, None, 20.0, 31.0, None, 28.0)


def drive(temperatures: tuple[float | None, ...]) -> list[SimpleNamespace]:
    """Tests without a loop: hours, events and temperatures alone."""
    return [
        SimpleNamespace(service_hours=hours, event=event, load_hours=None, temperature_C=warm)
        for hours, event, warm in zip(HOURS, EVENTS, temperatures, strict=True)
    ]


class Case:
    """Loops of differing rank, from one that says nothing to one that says all."""

    def __init__(self, temperatures: tuple[float | None, ...]) -> None:
        rng = np.random.default_rng(11)
        self.tests, self.given = drive(temperatures), temperatures
        timeline, _ = Timeline.of(self.tests, ServiceClock.of(self.tests), WEAR_PRIOR)
        deviates = 0.7 * rng.standard_normal((DRAWS, len(HYPERPARAMETERS)))
        values = Hyperparameters.of(deviates, WEAR_PRIOR)
        self.scatter = values.scatter
        self.steps = Steps.of(timeline, values, STATE, WEAR_PRIOR)
        self.sensitivity = [20.0 * rng.standard_normal((rank, COUNT)) for rank in RANKS]
        self.readings = [
            one @ (STATE.mean + rng.standard_normal(COUNT)) + rng.standard_normal(len(one))
            for one in self.sensitivity
        ]
        loops = [
            Linearised(one.T @ one, one.T @ seen, 0.0)
            for one, seen in zip(self.sensitivity, self.readings, strict=True)
        ]
        self.seen = SeenTests.of(loops, self.tests, WEAR_PRIOR)

    def warmth(self) -> np.ndarray:
        given = np.array([np.nan if one is None else one for one in self.given])
        return np.nan_to_num((given - np.nanmean(given)) / 10.0)

    def doubt(self) -> np.ndarray:
        given = np.array([np.nan if one is None else one for one in self.given])
        return np.where(np.isnan(given), np.nanstd(given) / 10.0, 0.0)


@dataclass
class Affine:
    """A vector that is `mean` plus `factor` times independent standard normals."""

    mean: np.ndarray
    factor: np.ndarray

    def __add__(self, other: Affine) -> Affine:
        return Affine(self.mean + other.mean, self.factor + other.factor)

    def times(self, matrix: np.ndarray) -> Affine:
        return Affine(matrix @ self.mean, matrix @ self.factor)


class Sources:
    """Hands out Gaussian vectors, each of its own standard normals."""

    def __init__(self) -> None:
        self.used, self.most = 0, 400

    def draw(self, mean: np.ndarray, root: np.ndarray) -> Affine:
        factor = np.zeros((len(mean), self.most))
        factor[:, self.used : self.used + root.shape[1]] = root
        self.used += root.shape[1]
        assert self.used <= self.most
        return Affine(np.asarray(mean, dtype=float), factor)

    def diagonal(self, mean: np.ndarray, sd: np.ndarray) -> Affine:
        return self.draw(mean, np.diag(sd))


def dense(case: Case, number: int) -> tuple[list[Affine], list[Affine]]:
    """What each test met without its scatter, x + βδ, and what its loop met, as affine maps.

    The last of the former is the last drive's β.
    """
    steps, sources, m = case.steps, Sources(), case.steps.direction[:, None]
    scalar, nothing = np.zeros(1), np.zeros(COUNT)
    states, met = [], []
    for time, (warmth, doubt) in enumerate(zip(case.warmth(), case.doubt(), strict=True)):
        if time in (0, 4):  # a new drive
            x = sources.diagonal(STATE.mean, STATE.sd)
            loading = sources.diagonal(WEAR_PRIOR.loading_mean, WEAR_PRIOR.loading_sd)
            beta = sources.diagonal(WEAR_PRIOR.warmer_mean, WEAR_PRIOR.warmer_sd)
            run_in = sources.diagonal(
                np.array([WEAR_PRIOR.running_in.mean]), np.array([WEAR_PRIOR.running_in.sd])
            )
            rate = sources.diagonal(scalar, scalar)
        gone = steps.passed[number, time]
        turn = np.sqrt(steps.departure[number, time])
        # A walk over the stretch, and its mean there: v + turn·(z₁/2 + z₂/√12).
        both = sources.draw(np.zeros(2), turn * np.array([[1.0, 0.0], [0.5, np.sqrt(1 / 12)]]))
        walk = np.sqrt(steps.loading_walk[number, time])
        turned = sources.diagonal(nothing, walk)
        lead = sources.diagonal(nothing, walk / np.sqrt(12))
        pace = loading + turned.times(0.5 * np.eye(COUNT)) + lead
        x = x + pace.times(steps.wear[number, time] * np.eye(COUNT))
        loading = loading + turned
        x = x + run_in.times(steps.settled[number, time] * m)
        x = x + (rate + both.times(np.array([[0.0, 1.0]]))).times(gone * m)
        x = x + sources.draw(nothing, np.sqrt(steps.shared[number, time]) * m)
        x = x + sources.diagonal(nothing, np.sqrt(steps.own[number, time]))
        rate = rate + both.times(np.array([[1.0, 0.0]]))
        states.append(x + beta.times(warmth * np.eye(COUNT)))
        size = case.scatter[number] * WEAR_PRIOR.scales
        scattered = states[-1] + sources.diagonal(nothing, size)
        # A δ that is not known: its part has the second moment of β times the variance of δ.
        root = np.column_stack([WEAR_PRIOR.warmer_mean, np.diag(WEAR_PRIOR.warmer_sd)])
        met.append(scattered + sources.draw(nothing, doubt * root))
    return [*states, beta], met


def stacked(parts: list[Affine]) -> Affine:
    return Affine(
        np.concatenate([one.mean for one in parts]), np.concatenate([one.factor for one in parts])
    )


def readings(case: Case, number: int) -> tuple[Affine, Affine, Affine, np.ndarray]:
    """States and β, what was met, what was read without its noise, and the readings."""
    states, met = dense(case, number)
    read = [one.times(h) for one, h in zip(met, case.sensitivity, strict=True)]
    return stacked(states), stacked(met), stacked(read), np.concatenate(case.readings)


def given_readings(of: Affine, read: Affine, data: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance of an affine map given the readings."""
    covariance = read.factor @ read.factor.T + np.eye(data.size)
    gain = np.linalg.solve(covariance, read.factor @ of.factor.T).T
    mean = of.mean + gain @ (data - read.mean)
    return mean, of.factor @ of.factor.T - gain @ read.factor @ of.factor.T


@pytest.fixture(scope="module", params=[ALL_KNOWN, SOME_KNOWN], ids=["known", "some known"])
def case(request: pytest.FixtureRequest) -> Case:
    return Case(request.param)


def log_density(case: Case, number: int) -> float:
    _, _, read, data = readings(case, number)
    covariance = read.factor @ read.factor.T + np.eye(data.size)
    return float(multivariate_normal(read.mean, covariance).logpdf(data))


def test_evidence_is_the_density_of_the_readings(case: Case) -> None:
    """Up to a constant, which all draws of the hyperparameters share."""
    found = log_evidence(case.steps, case.scatter, case.seen.observations)
    expected = np.array([log_density(case, number) for number in range(DRAWS)])
    np.testing.assert_allclose(np.diff(found), np.diff(expected), rtol=1e-10, atol=1e-8)


def test_smoothed_states_and_their_change_by_warmth_are_those_of_the_dense_solution(
    case: Case,
) -> None:
    precision, information, _ = case.seen.observations.behind_scatter(case.scatter)
    course = smooth(case.steps, precision, information)
    warmer = per_step_of_warmth(case.steps, course.carried)
    for number in range(DRAWS):
        both, _, read, data = readings(case, number)
        expected, _ = given_readings(both, read, data)
        found = np.concatenate([course.states[number].ravel(), warmer[number]])
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)


def test_a_state_at_the_reference_is_without_what_its_warmth_adds(case: Case) -> None:
    """By the dense solution's x + βδ and β, δ from the temperatures as given."""
    precision, information, _ = case.seen.observations.behind_scatter(case.scatter)
    course, last = smooth(case.steps, precision, information), len(HOURS) - 1
    found = at_reference(case.steps, course.states[:, last], course.carried, last)
    for number in range(DRAWS):
        both, _, read, data = readings(case, number)
        mean, _ = given_readings(both, read, data)
        met, beta = mean[-2 * COUNT : -COUNT], mean[-COUNT:]
        np.testing.assert_allclose(found[number], met - case.warmth()[last] * beta, atol=1e-8)
        assert np.abs(case.warmth()[last] * beta).max() > 1e-3


def test_the_joint_prior_is_that_of_what_was_met(case: Case) -> None:
    for number in range(DRAWS):
        one = case.steps.rows(np.array([number]))
        joint = JointPrior.of(one, float(case.scatter[number]), WEAR_PRIOR.scales)
        _, met, _, _ = readings(case, number)
        np.testing.assert_allclose(joint.mean.ravel(), met.mean, rtol=0, atol=1e-12)
        covariance = met.factor @ met.factor.T
        np.testing.assert_allclose(
            joint.precision @ covariance, np.eye(len(covariance)), rtol=0, atol=1e-6
        )


@pytest.mark.parametrize("fault", ["sign", "late"])
def test_a_wrong_temperature_would_show(case: Case, fault: str) -> None:
    """Planted faults: δ with the wrong sign, and that of the test before."""
    warming = case.steps.warming
    assert warming is not None
    warmed = -warming.warmed if fault == "sign" else np.roll(warming.warmed, 1)
    wrong = replace(case.steps, warming=replace(warming, warmed=warmed))
    found = log_evidence(wrong, case.scatter, case.seen.observations)
    expected = np.array([log_density(case, number) for number in range(DRAWS)])
    assert np.abs(np.diff(found) - np.diff(expected)).max() > 1e-3


def test_draws_of_what_was_met_have_the_dense_mean_and_spread(case: Case) -> None:
    """4 000 draws; 5 standard errors over 96 numbers: one false alarm in 10 000."""
    many = 4000
    steps = case.steps.rows(np.zeros(many, dtype=np.intp))
    rng, scatter = np.random.default_rng(5), np.repeat(case.scatter[:1], many)
    states = draw(steps, case.seen.observations, scatter, rng).states
    found = case.seen.draw_measured(states, scatter, rng).reshape(many, -1)
    _, met, read, data = readings(case, 0)
    mean, covariance = given_readings(met, read, data)
    spread = np.sqrt(np.diag(covariance))
    assert np.all(np.abs(found.mean(axis=0) - mean) < 5 * spread / np.sqrt(many))
    assert np.all(np.abs(found.std(axis=0) / spread - 1) < 5 / np.sqrt(2 * many))


@pytest.mark.parametrize("given", [(None,) * 6, (21.5,) * 6, (None, 21.5, None, 21.5, None, None)])
def test_temperatures_that_do_not_differ_do_not_count(given: tuple[float | None, ...]) -> None:
    assert Temperatures.of(drive(given)) is None
    none, same = Case((None,) * 6), Case(given)
    assert same.steps.warming is None
    assert same.steps.carried == COUNT + 2
    assert same.seen.unknown_part is None
    np.testing.assert_array_equal(
        log_evidence(same.steps, same.scatter, same.seen.observations),
        log_evidence(none.steps, none.scatter, none.seen.observations),
    )


def test_the_reference_is_the_mean_of_those_that_are_given() -> None:
    found = Temperatures.of(drive(SOME_KNOWN))
    assert found is not None
    assert found.reference_C == pytest.approx(23.5)
    np.testing.assert_allclose(found.warmth, [-0.85, 0.0, -0.35, 0.75, 0.0, 0.45])
    np.testing.assert_array_equal(found.unknown, [False, True, False, False, True, False])


def test_amplitudes_of_effects_have_their_own_entry() -> None:
    followed = WEAR_PRIOR.following(2)
    effect = WEAR_PRIOR.temperature["effect"]
    np.testing.assert_array_equal(followed.warmer_sd[:COUNT], WEAR_PRIOR.warmer_sd)
    assert followed.warmer_mean[COUNT:].tolist() == [effect.mean] * 2
    assert followed.warmer_sd[COUNT:].tolist() == [effect.sd] * 2


def test_what_temperature_does_leaves_the_deviates_of_a_fleet_comparable() -> None:
    changed = WEAR_PRIOR.temperature | {"mu": WEAR_PRIOR.temperature["c"]}
    other = WEAR_PRIOR.model_copy(update={"temperature": changed})
    assert other.identity == WEAR_PRIOR.identity


@pytest.mark.parametrize(("table", "entry"), [("temperature", "effect"), ("worn_out", "T_i")])
def test_a_wear_prior_without_an_entry_is_refused(tmp_path: Path, table: str, entry: str) -> None:
    shipped_text = (shipped("priors") / FILE).read_text("utf-8")
    before, heading, after = shipped_text.partition(f"[{table}]\n")
    path = tmp_path / FILE
    path.write_text(before + heading + after.replace(f"{entry} =", "misspelt =", 1), "utf-8")
    with pytest.raises(BadInputError, match=f"no entry for {entry}"):
        read_wear_prior(path)
