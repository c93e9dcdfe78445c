"""What is said of a parameter that the record is silent about."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.comparison.drawn import Drawn
from hdprog.comparison.fitted import _parameters
from hdprog.config import Drive
from hdprog.inference.diagnostics import Diagnostics
from hdprog.inference.fit_other import _described
from hdprog.inference.prepare import prepare
from hdprog.physics.other_models import BY_ID
from tests.comparison.loops import loop_of


@pytest.mark.parametrize("model", ["maxwell_slip", "preisach", "cubic"])
def test_draws_from_the_prior_are_not_informed(model: str) -> None:
    """Weights that must not be negative have a half-normal prior, whose variance is less."""
    rng = np.random.default_rng(1)
    prepared = prepare(loop_of("cubic", rng), Drive(), rng)
    likelihood = _described(prepared, BY_ID[model])
    chains = rng.standard_normal((4, 1000, 1, likelihood.size))
    if likelihood.model.nonnegative:
        chains = np.abs(chains)
    nothing, alike = np.zeros(chains.shape[:3]), np.ones(likelihood.size)
    drawn = Drawn(
        likelihood, (), chains, nothing, nothing, Diagnostics(alike, alike, alike), True, "", {}
    )
    found = [one.contraction for one in _parameters(drawn).values()]
    np.testing.assert_allclose(found, 0.0, atol=0.12)
