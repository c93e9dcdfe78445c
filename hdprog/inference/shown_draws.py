"""A few draws of a test's posterior and of its prior, for pictures."""

from __future__ import annotations

import numpy as np

from hdprog.inference.posterior import Posterior
from hdprog.physics.parameters import in_support
from hdprog.results import ParameterDraws

_POSTERIOR, _PRIOR = 600, 2000


def shown_draws(posterior: Posterior) -> ParameterDraws:
    """Evenly chosen draws of the posterior, and draws of the prior inside the model's support.

    The prior's draws are the same for the same prior, whatever the seed of the fit.
    """
    chosen = posterior.thinned(_POSTERIOR)
    prior = posterior.prior
    drawn = prior.to_physical(prior.sample(_PRIOR, np.random.default_rng(0)))
    inside = in_support(drawn, posterior.operation.alpha)
    return ParameterDraws(
        {name: values[chosen] for name, values in posterior.parameters.items()},
        {name: values[inside] for name, values in drawn.items()},
    )
