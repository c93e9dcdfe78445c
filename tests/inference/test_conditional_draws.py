"""Effects' coordinates are drawn from what their log density says, with tails along each axis."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.inference import conditional_effects
from hdprog.inference.conditional_effects import _At, _drawn, _precision
from hdprog.inference.pareto_weights import worth
from hdprog.physics.parameters import FloatArray

DRAWS, SIZE = 40_000, 6


def weights(wider: float, rng: np.random.Generator) -> FloatArray:
    """Of a Gaussian that is wider on one axis of the precision than what is drawn from."""
    slopes = np.broadcast_to(rng.standard_normal((SIZE, 20)), (DRAWS, SIZE, 20))
    at = np.zeros((DRAWS, SIZE))
    effects, log_density = _drawn(_At(at, np.zeros((DRAWS, 20)), at[:, 0]), slopes, rng)
    values, axes = np.linalg.eigh(_precision(slopes[:1])[0])
    values[0] /= wider**2
    normal = effects @ axes * np.sqrt(values)
    target = 0.5 * np.log(values).sum() - 0.5 * np.sum(normal**2, axis=1)
    return np.asarray(np.exp(target - log_density))


@pytest.mark.parametrize("wider", [0.5, 1.0, 2.0])
def test_the_log_density_is_that_of_the_draws(wider: float) -> None:
    """Weights of a density that is normed have a mean of one; by chance none is 4 errors off."""
    found = weights(wider, np.random.default_rng(5))
    error = found.std() / np.sqrt(found.size)
    assert abs(found.mean() - 1.0) < 4 * error
    assert error < 0.02


def test_one_long_tail_among_many_axes_is_covered(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(6)
    found = weights(2.0, rng)
    assert worth(found / found.sum()) > 0.25 * DRAWS
    monkeypatch.setattr(conditional_effects, "_FAR_SHARE", 1e-9)
    without = weights(2.0, rng)
    assert without.max() / without.mean() > 10 * found.max() / found.mean()
