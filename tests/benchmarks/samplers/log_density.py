"""The log posterior of a loop in JAX: the same numbers as `RidgePosterior`, with a gradient.

The slip's history needs no scan over the samples. Its envelope rises along a stretch between two
reversals, so that what happened before enters through one number, the slip at the stretch's start:
a maximum within each stretch, and a short loop over the stretches that is unrolled.

Nothing here is imported from JAX before a density is made, so that the module can be read without.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property, lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.physics.parameters import FloatArray

_XI_SCALE = 0.02
_LARGEST_LOG = 5.0
_SMALL = 1e-9


def peer(module: str) -> Any:
    """A module of a package that only this benchmark needs.

    Raises SystemExit where it is not installed.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as missing:
        raise SystemExit(
            f"{missing.name} is not installed here: make an environment as "
            f"{Path(__file__).with_name('requirements.txt')} says and run there"
        ) from None


@lru_cache(maxsize=1)
def jax_modules() -> tuple[Any, Any]:
    """`jax` and `jax.numpy`, in double precision."""
    jax = peer("jax")
    jax.config.update("jax_enable_x64", True)
    return jax, peer("jax.numpy")


class JaxPosterior:
    """Log posterior density of one loop with white noise, of one position at a time.

    Parameters
    ----------
    likelihood : without effects, its noise white
    """

    def __init__(self, likelihood: LoopLikelihood) -> None:
        if likelihood.effects or likelihood.noise.whitening is not None:
            raise ValueError("the density is written for white noise and no effects")
        self.likelihood = likelihood
        self.size = likelihood.size

    def ridge(self, position: Any) -> Any:
        """Log density (scalar) at ridge coordinates (9,), with their Jacobian."""
        _, jnp = jax_modules()
        coordinates, log_jacobian, inside = self._unconstrained(position[:COUNT])
        # Where a position names no parameters, the rest is worked out at a place that does: a
        # gradient through NaN would be NaN even where its value is not taken.
        safe = jnp.where(inside, coordinates, self.likelihood.prior.mean)
        density = self._density(safe, position[COUNT])
        return jnp.where(inside, density + log_jacobian, -jnp.inf)

    def unconstrained(self, point: Any) -> Any:
        """Log density (scalar) at a point (9,) of the likelihood."""
        return self._density(point[:COUNT], point[COUNT])

    def log_likelihood(self, point: Any) -> Any:
        """Log likelihood (scalar) at a point (9,); −inf outside the hard support."""
        _, jnp = jax_modules()
        physical, inside = self._physical(point[:COUNT])
        return jnp.where(inside, self._log_likelihood(physical, point[COUNT]), -jnp.inf)

    def _density(self, coordinates: Any, logit: Any) -> Any:
        _, jnp = jax_modules()
        prior = self.likelihood.prior
        physical, inside = self._physical(coordinates)
        deviation = (coordinates - prior.mean) / prior.sd
        log_prior = -0.5 * jnp.sum(deviation**2) - logit - 2 * jnp.logaddexp(0.0, -logit)
        density = log_prior + self._log_likelihood(physical, logit)
        return jnp.where(inside & jnp.isfinite(density), density, -jnp.inf)

    def _unconstrained(self, ridge: Any) -> tuple[Any, Any, Any]:
        """Unconstrained coordinates (8,), log |det| of their derivative, and whether they exist."""
        _, jnp = jax_modules()
        alpha, scale, largest = self.likelihood.ridge_frame
        log_C, logit_W, logit_F, log_D, x_T, log_m, xi, log_P = ridge

        def log_sigmoid(value: Any) -> Any:
            return -jnp.logaddexp(0.0, -value)

        log_K_W = 2 * math.log(math.tan(alpha)) - log_sigmoid(logit_W) - log_C
        log_rest = log_C + log_sigmoid(-logit_W)
        log_K_F = -log_sigmoid(logit_F) - log_rest
        log_mesh = -log_sigmoid(-logit_F) - log_rest
        log_met = jnp.log(jnp.minimum(scale * jnp.logaddexp(0.0, x_T), largest))
        log_y = log_D + log_mesh - log_met
        left = jnp.exp(jnp.minimum(log_m, log_P - math.log(largest))) - _XI_SCALE * xi
        inside = (log_y < _LARGEST_LOG) & (left > 0)
        y = jnp.exp(jnp.where(inside, log_y, 0.0))
        z = 2 * jnp.expm1(y)
        log_b = log_mesh - jnp.log1p(z)
        log_a = jnp.log(z) + log_b - log_met
        log_mu = jnp.log(jnp.where(inside, left, 1.0) / math.cos(alpha))
        log_jacobian = jnp.log(y) - jnp.log(-jnp.expm1(-y)) - log_mu
        coordinates = jnp.stack(
            [log_K_F, log_K_W, log_a, log_b, x_T, log_m - log_mu, log_P - log_m, log_mu]
        )
        return coordinates, log_jacobian, inside & jnp.isfinite(coordinates).all()

    def _physical(self, coordinates: Any) -> tuple[dict[str, Any], Any]:
        """Physical parameters by name, and whether they lie in the hard support."""
        _, jnp = jax_modules()
        K_F, K_W, a, b, _, minus_c, T_i, mu = jnp.exp(coordinates)
        T_T = self.likelihood.prior.softplus_scale * jnp.logaddexp(0.0, coordinates[4])
        alpha, c = self.likelihood.alpha, -minus_c
        inside = (mu < min(math.tan(alpha), 1 / math.tan(alpha))) & (mu > 0) & (c < 0)
        inside &= math.sin(alpha) + mu * (math.cos(alpha) + c) > 0
        inside &= (K_F > 0) & (K_W > 0) & (b > 0)
        named = {"K_F": K_F, "K_W": K_W, "a": a, "b": b, "T_T": T_T, "c": c, "T_i": T_i, "mu": mu}
        return named, inside

    def _log_likelihood(self, physical: dict[str, Any], logit: Any) -> Any:
        _, jnp = jax_modules()
        left = self._angle_measured - self._angle(physical, logit)
        left -= jnp.sum(self._weight * left) / float(self._weight.sum())
        squares = jnp.sum(self._weight * left**2)
        return -0.5 * self.likelihood.degrees * jnp.log(squares)

    @cached_property
    def _angle_measured(self) -> FloatArray:
        return self.likelihood.reduced.angle

    @cached_property
    def _weight(self) -> FloatArray:
        return np.asarray(1 / self.likelihood.noise.sd**2)

    def _angle(self, physical: dict[str, Any], logit: Any) -> Any:
        """Model angle without offset, (blocks,)."""
        path = self.likelihood.reduced.path
        slip = self._slip(physical, logit)
        elastic = self._mesh(physical) + path.torque / physical["K_F"]
        return math.tan(self.likelihood.alpha) * slip + elastic

    def _mesh(self, physical: dict[str, Any]) -> Any:
        """Tooth-mesh torsion, (blocks,)."""
        _, jnp = jax_modules()
        path = self.likelihood.reduced.path
        a, b, T_T = physical["a"], physical["b"], physical["T_T"]
        magnitude = np.abs(path.torque)
        meshing = jnp.minimum(magnitude, T_T)
        small = a * T_T < _SMALL * b
        a_safe = jnp.where(small, 1.0, a)
        angle = jnp.where(small, meshing / b, jnp.log1p(meshing * (a_safe / b)) / a_safe)
        if path.variance is not None:
            stiffness = a * magnitude + b
            angle -= jnp.where(magnitude < T_T, 0.5 * path.variance * a / stiffness**2, 0.0)
        angle = (angle + (magnitude - meshing) / (a * T_T + b)) * np.sign(path.torque)
        if path.variance is None:
            return angle
        at, half = path.around_zero, path.half_width[path.around_zero]
        torque = path.torque[at]
        above = _mesh_area(np.abs(torque + half), a, b, T_T)
        below = _mesh_area(np.abs(torque - half), a, b, T_T)
        return angle.at[at].set((above - below) / (2 * half))

    def _slip(self, physical: dict[str, Any], logit: Any) -> Any:
        """Wave-generator slip, (blocks,)."""
        jax, jnp = jax_modules()
        path = self.likelihood.reduced.path
        samples, stretches = path.torque.size, path.starts.size
        envelopes = self._envelope(path.pushing, physical)
        at_end = envelopes[samples : samples + stretches]
        lower, upper = envelopes[-2], -envelopes[-1]
        # Travel d·y that each stretch begins with; its samples are at least as far.
        current = lower + jax.nn.sigmoid(logit) * (upper - lower)
        begins = []
        for number, rising in enumerate(path.rising):
            sign = 1.0 if rising else -1.0
            begins.append(sign * current)
            current = sign * jnp.maximum(at_end[number], sign * current)
        behind = self._stretch_of_block @ jnp.stack(begins)
        return path.direction * jnp.maximum(envelopes[:samples], behind)

    @cached_property
    def _stretch_of_block(self) -> FloatArray:
        """(blocks, stretches) one where a block lies on a stretch.

        A product with it costs less to differentiate and to compile than slices.
        """
        path = self.likelihood.reduced.path
        stretch = np.repeat(np.arange(path.starts.size), path.ends - path.starts)
        return np.asarray(np.eye(path.starts.size)[stretch])

    def _envelope(self, pushed: FloatArray, physical: dict[str, Any]) -> Any:
        """Envelope that pushes the slip along the direction of travel, shape of `pushed`."""
        _, jnp = jax_modules()
        s, k = math.sin(self.likelihood.alpha), math.cos(self.likelihood.alpha)
        mu, K_W = physical["mu"], physical["K_W"]
        friction = jnp.maximum(mu * physical["c"] * (np.abs(pushed) - physical["T_i"]), 0.0)
        back = jnp.minimum(pushed * (s + mu * k) - friction, 0.0) / (K_W * (k - mu * s))
        driven = jnp.maximum(pushed * (s - mu * k) - friction, 0.0) / (K_W * (k + mu * s))
        return back + driven


def batched(density: Callable[[Any], Any], rows: int) -> Callable[[FloatArray], FloatArray]:
    """A compiled density of positions (any number, size) in batches of fixed size.

    JAX compiles anew for every shape, and an ensemble asks for as many positions as its slices
    still want: they are filled up to `rows`.
    """
    jax, _ = jax_modules()
    compiled = jax.jit(jax.vmap(density))

    def call(positions: FloatArray) -> FloatArray:
        count = len(positions)
        values = np.empty(count)
        for start in range(0, count, rows):
            part = positions[start : start + rows]
            filled = np.vstack([part, np.repeat(part[:1], rows - len(part), axis=0)])
            values[start : start + rows] = np.asarray(compiled(filled))[: len(part)]
        return values

    return call


def _mesh_area(magnitude: FloatArray, a: Any, b: Any, T_T: Any) -> Any:
    """Integral of the tooth-mesh torsion from zero torque, (blocks,)."""
    _, jnp = jax_modules()
    meshing = jnp.minimum(magnitude, T_T)
    small = a * T_T < _SMALL * b
    a_safe = jnp.where(small, 1.0, a)
    bent = meshing * (a_safe / b)
    few = jnp.minimum(bent, 1e-3)
    series = few**2 * (1 / 2 - few * (1 / 6 - few * (1 / 12 - few / 20)))
    area = jnp.where(bent < 1e-3, series, (1 + bent) * jnp.log1p(bent) - bent) * (b / a_safe**2)
    area = jnp.where(small, meshing**2 / (2 * b), area)
    at_end = jnp.where(small, meshing / b, jnp.log1p(bent) / a_safe)
    beyond = magnitude - meshing
    return area + beyond * (at_end + 0.5 * beyond / (a * T_T + b))
