"""The filter and smoother against a dense Gaussian solution written out independently."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.inference.information import Linearised
from hdprog.trend.kalman_filter import log_evidence
from hdprog.trend.observation import Observations
from hdprog.trend.relinearise import JointPrior
from hdprog.trend.smoother import draw, smooth
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.wear_coordinates import StatePrior
from hdprog.trend.wear_prior import read_wear_prior

WEAR_PRIOR = read_wear_prior()
STATE = StatePrior(np.linspace(-1.0, 1.0, 8), np.linspace(0.5, 2.0, 8))
AGE = np.array([0.0, 300.0, 300.0, 800.0, 0.0, 500.0])
BEGINS = np.array([True, False, False, False, True, False])
FINE = 2000


def model(draws: int, rng: np.random.Generator) -> tuple[Steps, np.ndarray]:
    """Steps over six tests with a regreasing at the second and a replacement at the fifth."""
    variance = np.zeros((6, 8))
    variance[1] = WEAR_PRIOR.event_variance("regreased")
    timeline = Timeline(AGE, BEGINS, variance)
    deviates = 0.7 * rng.standard_normal((draws, len(HYPERPARAMETERS)))
    values = Hyperparameters.of(deviates, WEAR_PRIOR)
    return Steps.of(timeline, values, STATE, WEAR_PRIOR), values.scatter


def loops(rng: np.random.Generator) -> list[Linearised]:
    """Loops of differing rank: from one that says nothing to one that says all."""
    found = []
    for rank in (8, 3, 8, 0, 8, 5):
        sensitivity = rng.standard_normal((rank, 8)) * 20.0
        seen = sensitivity @ (STATE.mean + rng.standard_normal(8))
        found.append(Linearised(sensitivity.T @ sensitivity, sensitivity.T @ seen, 0.0))
    return found


def dense(steps: Steps, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance of all states, by adding up the sources of randomness one by one.

    Every source is a matrix from independent unit Gaussians to the (6·8) stacked states.
    """
    mean, parts = np.zeros((6, 8)), []
    for start, end in ((0, 4), (4, 6)):
        wear = np.cumsum(steps.wear[number, start:end])
        passed = np.cumsum(steps.passed[number, start:end])
        mean[start:end] = steps.initial_mean + wear[:, None] * steps.loading_mean[0]
        initial, loading = np.zeros((2, 6, 8, 8))
        initial[start:end] = np.diag(np.sqrt(steps.initial_variance))
        loading[start:end] = wear[:, None, None] * np.diag(np.sqrt(steps.loading_variance))
        settled = np.cumsum(steps.settled[number, start:end])
        mean[start:end] += steps.running_in[0] * settled[:, None] * steps.direction
        running_in = np.zeros((6, 8, 1))
        running_in[start:end, :, 0] = np.outer(settled, steps.direction)
        parts += [initial, loading, np.sqrt(steps.running_in[1]) * running_in]
        # The rate's departure and the loadings' walks: integrals as fine sums over a walk's
        # increments, whose variance is spread evenly over what passes between two times.
        for time in range(start, end):
            reach = fine_reach(passed, time - start) * np.sqrt(steps.departure[number, time])
            integral = np.zeros((6, 8, FINE))
            integral[start:end] = reach[:, None, :] * steps.direction[:, None]
            parts.append(integral)
            reach = fine_reach(wear, time - start)
            for place, variance in enumerate(steps.loading_walk[number, time]):
                walk = np.zeros((6, 8, FINE))
                walk[start:end, place] = np.sqrt(variance) * reach
                parts.append(walk)
        for time in range(start, end):
            shared, own = np.zeros((6, 8, 1)), np.zeros((6, 8, 8))
            shared[time:end, :, 0] = np.sqrt(steps.shared[number, time]) * steps.direction
            own[time:end] = np.diag(np.sqrt(steps.own[number, time]))
            parts += [shared, own]
    factor = np.concatenate([part.reshape(48, -1) for part in parts], axis=1)
    return mean.ravel(), factor @ factor.T


def fine_reach(course: np.ndarray, time: int) -> np.ndarray:
    """(times, FINE) how far a unit walk's increments before a time reach along a rising course."""
    before = course[time - 1] if time else 0.0
    middles = before + (np.arange(FINE) + 0.5) / FINE * (course[time] - before)
    return np.maximum(course[:, None] - middles, 0.0) / np.sqrt(FINE)


def block_diagonal(blocks: np.ndarray) -> np.ndarray:
    whole = np.zeros((48, 48))
    for number, block in enumerate(blocks):
        whole[8 * number : 8 * number + 8, 8 * number : 8 * number + 8] = block
    return whole


@pytest.fixture(scope="module")
def case() -> tuple[Steps, np.ndarray, list[Linearised]]:
    rng = np.random.default_rng(11)
    steps, scatter = model(3, rng)
    return steps, scatter, loops(rng)


def test_smoothed_states_equal_the_dense_solution(case) -> None:
    steps, scatter, seen = case
    precision, information, _ = Observations.of(seen, WEAR_PRIOR.scales).behind_scatter(scatter)
    states = smooth(steps, precision, information).states
    for number in range(3):
        mean, covariance = joint_prior(steps, number)
        whole = block_diagonal(precision[number])
        gain = np.linalg.solve(np.eye(48) + covariance @ whole, covariance)
        expected = mean + gain @ (information[number].ravel() - whole @ mean)
        assert np.allclose(states[number].ravel(), expected, rtol=0, atol=1e-8)


def joint_prior(steps: Steps, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance of the states from the closed form that relinearisation uses."""
    one = steps.rows(np.array([number]))
    joint = JointPrior.of(one, 1e-3, np.ones(8))
    return joint.mean.ravel(), np.linalg.inv(joint.precision) - 1e-6 * np.eye(48)


def test_the_closed_form_covariance_is_the_sum_of_its_sources(case) -> None:
    steps, _, _ = case
    for number in range(3):
        mean, covariance = dense(steps, number)
        closed_mean, closed = joint_prior(steps, number)
        assert np.allclose(closed_mean, mean, atol=1e-12)
        # The fine sum of the rate's walk is good to about 1e-7 of its variance.
        assert np.allclose(closed, covariance, atol=1e-5 * np.abs(covariance).max())


def test_evidence_is_the_density_of_the_data(case) -> None:
    """Differences of log evidence equal those of dense Gaussian densities of pseudo-data."""
    steps, scatter, seen = case
    found = log_evidence(steps, scatter, Observations.of(seen, WEAR_PRIOR.scales))
    expected = []
    for number in range(3):
        mean, covariance = joint_prior(steps, number)
        covariance = covariance + block_diagonal(
            np.tile(np.diag((scatter[number] * WEAR_PRIOR.scales) ** 2), (6, 1, 1))
        )
        whole = block_diagonal(np.stack([loop.precision for loop in seen]))
        information = np.concatenate([loop.information for loop in seen])
        matrix = np.eye(48) + whole @ covariance
        surprise = information - whole @ mean
        value = -0.5 * np.linalg.slogdet(matrix)[1]
        value += 0.5 * surprise @ covariance @ np.linalg.solve(matrix, surprise)
        value += 0.5 * (surprise + information) @ mean
        expected.append(value)
    assert np.allclose(found, expected, rtol=0, atol=1e-6)


def test_draws_have_the_dense_mean_and_covariance(case) -> None:
    """2 000 draws; bounds of 4.5 standard errors over 96 numbers: one false alarm in 1 000."""
    steps, scatter, seen = case
    one = steps.rows(np.zeros(2000, dtype=np.intp))
    observed = Observations.of(seen, WEAR_PRIOR.scales)
    states = draw(one, observed, np.repeat(scatter[:1], 2000), np.random.default_rng(5)).states
    mean, covariance = joint_prior(steps, 0)
    precision, information, _ = observed.behind_scatter(scatter[:1])
    whole = block_diagonal(precision[0])
    gain = np.linalg.solve(np.eye(48) + covariance @ whole, covariance)
    expected = mean + gain @ (information[0].ravel() - whole @ mean)
    spread = np.sqrt(np.diag(gain))
    flat = states.reshape(2000, -1)
    assert np.all(np.abs(flat.mean(axis=0) - expected) < 4.5 * spread / np.sqrt(2000))
    assert np.all(np.abs(flat.std(axis=0) / spread - 1) < 4.5 / np.sqrt(4000))
