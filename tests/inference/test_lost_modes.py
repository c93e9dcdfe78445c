"""A mode that the proposal has lost is noticed and found again; one that has no mass is let be."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from hdprog.inference import fit_loop, until_converged
from hdprog.inference.lost_modes import lost_modes
from hdprog.inference.mixture_proposal import fit_mixture
from hdprog.inference.sampler import EnsembleState, fresh_random_state
from hdprog.inference.sampling_plan import SamplingPlan
from hdprog.inference.starting_points import StartingPoint
from hdprog.inference.until_converged import sample_until_converged

SIZE = 4
CENTRES = np.array([np.zeros(SIZE), 25.0 * np.ones(SIZE)])
SDS = np.array([1.0, 0.5])
SHARE = 0.3  # of the second


@dataclass(frozen=True)
class TwoGaussians:
    """A target of two modes too far apart to hop, in place of a loop's posterior."""

    share: float = SHARE
    temperature: float = 1.0
    likelihood: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(size=SIZE, ridge=False, block_degrees=99.0)
    )

    def __call__(self, position: np.ndarray) -> np.ndarray:
        squares = ((position[:, None, :] - CENTRES) ** 2).sum(axis=-1) / SDS**2
        logs = np.log([1 - self.share, self.share]) - SIZE * np.log(SDS) - 0.5 * squares
        return np.logaddexp.reduce(logs, axis=1) / self.temperature

    def points(self, position: np.ndarray) -> np.ndarray:
        return position

    def position(self, point: np.ndarray) -> np.ndarray:
        return point

    @property
    def modes(self) -> list[StartingPoint]:
        deviances = -2 * self(CENTRES)
        found = zip(CENTRES, SDS, deviances, strict=True)
        return [
            StartingPoint(at, sd**2 * np.eye(SIZE), float(value), 1.0) for at, sd, value in found
        ]


def drawn(counts: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    each = zip(CENTRES, SDS, counts, strict=True)
    return np.concatenate([at + sd * rng.standard_normal((count, SIZE)) for at, sd, count in each])


@pytest.mark.parametrize(
    ("target", "seen", "lost"),
    [
        (TwoGaussians(), (4000, 0), True),
        (TwoGaussians(), (3990, 10), True),  # their share is far from what the posterior has there
        (TwoGaussians(), (2800, 1200), False),
        (TwoGaussians(share=0.003), (4000, 0), False),
    ],
)
def test_lost_is_what_has_mass_beyond_the_proposal(
    target: TwoGaussians, seen: tuple[int, int], *, lost: bool
) -> None:
    rng = np.random.default_rng(3)
    chains = drawn(seen, rng)
    fitted = chains if seen[1] > 10 else chains[: seen[0]]
    state = fresh_random_state(rng)
    found = lost_modes(
        target, fit_mixture(fitted, 2, rng), chains[None, :, None], target.modes, state
    )
    assert (found is not None) == lost
    if found is not None:
        assert np.abs(found - CENTRES[1]).max() < 6 * SDS[1]


@pytest.mark.parametrize("told", [True, False])
def test_sampling_goes_on_until_the_mode_has_its_share(*, told: bool) -> None:
    target, rng = TwoGaussians(), np.random.default_rng(4)
    walkers = drawn((96, 0), rng).reshape(4, 24, SIZE)
    states = [EnsembleState(walkers, fresh_random_state(rng))]
    plan = SamplingPlan(required_ess=400.0, warm_up_steps=(40, 20, 20), components=(2, 2, 2))
    chains, _, sampling, converged = sample_until_converged(
        target, states, plan, rng, modes=target.modes if told else ()
    )
    assert converged
    share = (chains[..., 0] > 10.0).mean(axis=(1, 2))
    # Untold, the diagnostics pass without it: all that they see is one well-sampled mode.
    np.testing.assert_allclose(share, SHARE if told else 0.0, atol=0.1)
    assert (sampling["warm_up_steps"] > 80) == told


def test_a_run_that_has_lost_nothing_is_left_as_it_is() -> None:
    target = TwoGaussians()
    runs = []
    for modes in (target.modes, ()):
        rng = np.random.default_rng(5)
        walkers = drawn((66, 30), rng)[rng.permutation(96)].reshape(4, 24, SIZE)
        states = [EnsembleState(walkers, fresh_random_state(rng))]
        plan = SamplingPlan(required_ess=400.0, warm_up_steps=(40, 20, 20), components=(2, 2, 2))
        chains = sample_until_converged(target, states, plan, rng, modes=modes)[0]
        runs.append((chains, rng.integers(1 << 30)))
    np.testing.assert_array_equal(runs[0][0], runs[1][0])
    assert runs[0][1] == runs[1][1]


def test_a_run_that_cannot_find_its_mode_again_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its R-hat and effective draws are good: the words must name what is amiss."""
    target, rng = TwoGaussians(), np.random.default_rng(6)
    missing = drawn((0, 400), rng)
    monkeypatch.setattr(until_converged, "lost_modes", lambda *_: missing)
    states = [EnsembleState(drawn((96, 0), rng).reshape(4, 24, SIZE), fresh_random_state(rng))]
    plan = SamplingPlan(
        required_ess=100.0,
        lengths=5.0,
        warm_up_steps=(40, 20, 20),
        components=(2, 2, 2),
        most_steps=100,
        further_steps=0,
    )
    _, diagnostics, sampling, converged = sample_until_converged(
        target, states, plan, rng, modes=target.modes
    )
    assert not converged
    said = fit_loop._not_converged(sampling, diagnostics)
    assert "but a mode that the search found is missing from the draws)" in said
    del sampling["lost_mode"]
    assert "a mode" not in fit_loop._not_converged(sampling, diagnostics)
