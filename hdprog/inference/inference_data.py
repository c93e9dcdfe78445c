"""A loop's posterior as an ArviZ InferenceData, for storage and for checks of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hdprog.inference.lazy_arviz import arviz
from hdprog.inference.likelihood import COUNT, LoopLikelihood, sigmoid
from hdprog.inference.posterior import Posterior
from hdprog.physics.parameters import BY_NAME, NAMES, FloatArray, in_support

if TYPE_CHECKING:
    from arviz import InferenceData

_POINTWISE_STEPS = 8
_PRIOR_DRAWS = 2000
_DIMS = ("ensemble", "walker", "step")
_COARSE = ("ensemble", "walker", "coarse_step")


def inference_data(
    posterior: Posterior, rng: np.random.Generator, provenance: Mapping[str, object]
) -> InferenceData:
    """Posterior, prior, log-likelihood, observed data and posterior predictive of a loop.

    The draws keep the dimensions (ensemble, walker, step). The groups with a value a block hold
    every few steps only (`coarse_step`), to stay small. A fit that is kept to least squares has no
    group log_likelihood: its draws are not those of a density of its blocks.

    Parameters
    ----------
    posterior : of one loop
    rng : for the prior and predictive draws
    provenance : attributes of every group, e.g. file hash, version, seed
    """
    import xarray

    chains = posterior.chains.transpose(0, 2, 1, 3)  # ensemble, walker, step, quantity
    offset = posterior.offset.transpose(0, 2, 1)
    scale = posterior.noise_scale.transpose(0, 2, 1)
    attributes = {**provenance, "alpha_rad": posterior.drive.alpha, "prior": posterior.prior.name}

    def dataset(variables: dict[str, Any], **extra: object) -> Any:
        return xarray.Dataset(variables, attrs={**attributes, **extra})

    every = max(1, chains.shape[2] // _POINTWISE_STEPS)
    few = slice(None, None, every)
    by_block = (posterior.likelihood, chains[:, :, few], offset[:, :, few], scale[:, :, few])
    groups = {}
    if posterior.likelihood.least_squares is None:
        groups["log_likelihood"] = dataset({"angle": ((*_COARSE, "block"), _pointwise(*by_block))})
    predicted = _predicted(*by_block, rng)
    reduced = posterior.likelihood.reduced
    prior_draws = posterior.prior.sample(_PRIOR_DRAWS, rng)
    prior_values = posterior.prior.to_physical(prior_draws)
    inside = in_support(prior_values, posterior.drive.alpha)
    block = ("block",)
    stored: InferenceData = arviz().InferenceData(
        posterior=dataset(
            _draws(posterior, chains, offset, scale),
            converged=int(posterior.converged),
            noise_model=posterior.likelihood.noise.words,
        ),
        prior=dataset(
            {name: (("draw",), prior_values[name][inside], _units(name)) for name in NAMES}
        ),
        posterior_predictive=dataset(
            {"angle": ((*_COARSE, "block"), predicted, {"units": "rad"})},
        ),
        observed_data=dataset(
            {
                "angle": (block, reduced.angle, {"units": "rad"}),
                "noise_sd": (block, posterior.likelihood.noise.scatter, {"units": "rad"}),
            }
        ),
        constant_data=dataset(
            {
                "torque": (block, reduced.path.torque, {"units": "Nm"}),
                "readings": (block, reduced.count, {"units": "1"}),
                "position": (block, reduced.position, {"units": "1"}),
            }
        ),
        warn_on_custom_groups=False,
        **groups,
    )
    return stored


def _draws(
    posterior: Posterior, chains: FloatArray, offset: FloatArray, scale: FloatArray
) -> dict[str, Any]:
    """Everything that is drawn, in physical units, (ensemble, walker, step) each."""
    physical = posterior.prior.to_physical(chains[..., :COUNT])
    draws = {name: (_DIMS, physical[name], _units(name)) for name in NAMES}
    for effect, parameter in posterior.likelihood.effect_set.parameters:
        index = len(draws) - len(NAMES) + COUNT + 1
        draws[f"{effect.id}.{parameter.name}"] = (
            _DIMS,
            parameter.value(chains[..., index]),
            {"units": parameter.unit, "long_name": parameter.meaning},
        )
    draws["angle_offset"] = (_DIMS, offset, {"units": "rad"})
    draws["noise_scale"] = (
        _DIMS,
        scale,
        {"units": "1", "long_name": "factor on the noise of observed_data.noise_sd"},
    )
    draws["initial_slip_fraction"] = (_DIMS, sigmoid(chains[..., COUNT]), {"units": "1"})
    return draws


def _units(name: str) -> dict[str, str]:
    parameter = BY_NAME[name]
    unit = "1" if parameter.unit == "-" else parameter.unit
    return {"units": unit, "long_name": parameter.meaning, "source": parameter.equation}


def _pointwise(
    likelihood: LoopLikelihood, chains: FloatArray, offset: FloatArray, scale: FloatArray
) -> NDArray[np.float32]:
    """Log-likelihood by block, (ensemble, walker, step, block)."""
    flat = chains.reshape(-1, chains.shape[-1])
    found = likelihood.pointwise(flat, offset.ravel(), scale.ravel())
    return found.reshape(*chains.shape[:3], -1).astype(np.float32)


def _predicted(
    likelihood: LoopLikelihood,
    chains: FloatArray,
    offset: FloatArray,
    scale: FloatArray,
    rng: np.random.Generator,
) -> NDArray[np.float32]:
    """Predictive draws by block, (ensemble, walker, step, block) in rad."""
    fitted = likelihood.angle(chains.reshape(-1, chains.shape[-1])) + offset.reshape(-1, 1)
    fitted = fitted + likelihood.noise.smooth_part(likelihood.reduced.angle - fitted)
    noise = likelihood.noise.scatter * scale.reshape(-1, 1)
    found = fitted + noise * rng.standard_normal(fitted.shape)
    return found.reshape(*chains.shape[:3], -1).astype(np.float32)
