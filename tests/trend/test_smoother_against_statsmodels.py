"""The filter and smoother against statsmodels on the linear-Gaussian case."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from statsmodels.tsa.statespace.kalman_smoother import KalmanSmoother

from hdprog.inference.information import Linearised
from hdprog.trend.kalman_filter import log_evidence
from hdprog.trend.observation import Observations
from hdprog.trend.smoother import smooth
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.wear_coordinates import StatePrior
from hdprog.trend.wear_prior import read_wear_prior

WEAR_PRIOR = read_wear_prior()
STATE = StatePrior(np.linspace(-1.0, 1.0, 8), np.linspace(0.5, 2.0, 8))
AGE = np.array([0.0, 120.0, 700.0, 700.0, 1900.0, 0.0, 40.0, 800.0])  # replaced after the fifth
BEGINS = np.array([True, False, False, False, False, True, False, False])
RANKS = (8, 5, 8, 0, 2, 8, 8, 3)
COUNT, CARRIED, TIMES, DRAWS = 8, 10, AGE.size, 4


class Case:
    """Tests of differing rank at irregular times, with a regreasing and a replacement."""

    def __init__(self) -> None:
        rng = np.random.default_rng(23)
        variance = np.zeros((TIMES, COUNT))
        variance[3] = WEAR_PRIOR.event_variance("regreased")
        deviates = 0.7 * rng.standard_normal((DRAWS, len(HYPERPARAMETERS)))
        values = Hyperparameters.of(deviates, WEAR_PRIOR)
        self.scatter = values.scatter
        self.steps = Steps.of(Timeline(AGE, BEGINS, variance), values, STATE, WEAR_PRIOR)
        self.sensitivity = [20.0 * rng.standard_normal((rank, COUNT)) for rank in RANKS]
        self.seen = [
            one @ (STATE.mean + rng.standard_normal(COUNT)) + rng.standard_normal(len(one))
            for one in self.sensitivity
        ]
        loops = [
            Linearised(one.T @ one, one.T @ seen, 0.0)
            for one, seen in zip(self.sensitivity, self.seen, strict=True)
        ]
        self.observed = Observations.of(loops, WEAR_PRIOR.scales)

    def transitions(self, number: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Transition matrix, intercept and covariance into each time, states and carried joined."""
        steps = self.steps
        first_mean = np.concatenate(
            [steps.initial_mean, steps.loading_mean[0], [steps.running_in[0], 0.0]]
        )
        first_variance = np.concatenate(
            [steps.initial_variance, steps.loading_variance, [steps.running_in[1], 0.0]]
        )
        m = steps.direction
        for time in range(TIMES):
            matrix = np.eye(COUNT + CARRIED)
            matrix[:COUNT, COUNT : 2 * COUNT] = steps.wear[number, time] * np.eye(COUNT)
            matrix[:COUNT, -2] = steps.settled[number, time] * m
            gone, change = steps.passed[number, time], steps.departure[number, time]
            matrix[:COUNT, -1] = gone * m
            noise = np.zeros_like(matrix)
            # A walk and its integral over the same stretch.
            along = steps.shared[number, time] + change * gone**2 / 3
            walk, wear = steps.loading_walk[number, time], steps.wear[number, time]
            own = steps.own[number, time] + walk * wear**2 / 3
            noise[:COUNT, :COUNT] = along * np.outer(m, m) + np.diag(own)
            noise[:COUNT, COUNT : 2 * COUNT] = np.diag(walk * wear / 2)
            noise[COUNT : 2 * COUNT, :COUNT] = np.diag(walk * wear / 2)
            noise[COUNT : 2 * COUNT, COUNT : 2 * COUNT] = np.diag(walk)
            noise[:COUNT, -1] = noise[-1, :COUNT] = change * gone / 2 * m
            noise[-1, -1] = change
            if BEGINS[time]:
                yield (
                    np.zeros_like(matrix),
                    matrix @ first_mean,
                    noise + matrix * first_variance @ matrix.T,
                )
            else:
                yield matrix, np.zeros(COUNT + CARRIED), noise

    def peer(self, number: int) -> KalmanSmoother:
        """The same model for one draw of the hyperparameters."""
        size = COUNT + CARRIED
        data = np.full((TIMES, COUNT), np.nan)
        design, errors = np.zeros((COUNT, size, TIMES)), np.zeros((COUNT, COUNT, TIMES))
        scattered = np.diag((self.scatter[number] * WEAR_PRIOR.scales) ** 2)
        for time, (one, seen) in enumerate(zip(self.sensitivity, self.seen, strict=True)):
            rank = len(one)
            data[time, :rank] = seen
            design[:rank, :COUNT, time] = one
            errors[..., time] = np.eye(COUNT)
            errors[:rank, :rank, time] += one @ scattered @ one.T
        into = list(self.transitions(number))
        model = KalmanSmoother(k_endog=COUNT, k_states=size, k_posdef=size)
        model.bind(data)
        model["design"], model["obs_cov"] = design, errors
        model["selection"] = np.eye(size)
        after = [*into[1:], into[-1]]
        model["transition"] = np.stack([matrix for matrix, _, _ in after], axis=-1)
        model["state_intercept"] = np.stack([intercept for _, intercept, _ in after], axis=-1)
        model["state_cov"] = np.stack([noise for _, _, noise in after], axis=-1)
        model.initialize_known(into[0][1], into[0][2])
        return model


@pytest.fixture(scope="module")
def case() -> Case:
    return Case()


def test_states_are_those_of_statsmodels(case: Case) -> None:
    precision, information, _ = case.observed.behind_scatter(case.scatter)
    found = smooth(case.steps, precision, information)
    for number in range(DRAWS):
        wanted = case.peer(number).smooth().smoothed_state
        np.testing.assert_allclose(found.states[number], wanted[:COUNT].T, rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(found.carried[number], wanted[COUNT:, -1], rtol=1e-8, atol=1e-8)
        # The last drive's first test is when it is new: its loadings have not walked yet.
        began = wanted[COUNT : 2 * COUNT, np.flatnonzero(BEGINS)[-1]]
        np.testing.assert_allclose(found.loadings[number], began, rtol=1e-8, atol=1e-8)


def test_the_evidence_is_the_likelihood_of_statsmodels(case: Case) -> None:
    found = log_evidence(case.steps, case.scatter, case.observed)
    data = np.concatenate(case.seen)
    constant = -0.5 * (data @ data + data.size * np.log(2 * np.pi))
    wanted = [case.peer(number).filter().llf for number in range(DRAWS)]
    np.testing.assert_allclose(found + constant, wanted, rtol=1e-8)
