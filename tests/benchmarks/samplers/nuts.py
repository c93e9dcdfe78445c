"""The no-U-turn samplers of NumPyro, BlackJAX and nutpie, with their documented defaults.

Four chains from about the modes, run one after the other: in step, every chain would wait for the
longest trajectory of the four. All three adapt a diagonal mass matrix and aim at an acceptance of
0.8. NumPyro and BlackJAX warm up for 1 000 draws a chain as their guides do, nutpie for as many as
it chooses itself.

The loops over draws of NumPyro and BlackJAX are compiled once for a posterior. NumPyro's own `MCMC`
compiles anew at every call of `run`; here it is driven by its kernel, which costs it less.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from hdprog.physics.parameters import FloatArray
from tests.benchmarks.samplers.log_density import jax_modules, peer
from tests.benchmarks.samplers.measuring import (
    WANTED,
    Effective,
    Found,
    Watch,
    effective_draws,
    points_of,
)
from tests.benchmarks.samplers.posteriors import Target, sampler_seed

CHAINS = 4
WARM_UP = 1000
_ROUND = 100  # draws of each chain between two looks
_NUTPIE_DRAWS = 1000
_NUTPIE_LOOKS = 40

Look = Callable[[FloatArray], FloatArray]


def numpyro_nuts(target: Target, bound: float) -> Found:
    """NumPyro, in ridge coordinates."""
    starts = target.warm_starts(CHAINS)
    return _numpyro(target, target.density.ridge, starts, lambda z: points_of(target, z), bound)


def numpyro_nuts_unconstrained(target: Target, bound: float) -> Found:
    """NumPyro, in the unconstrained coordinates of the parameters."""
    starts = target.posterior.points(target.warm_starts(CHAINS))
    return _numpyro(target, target.density.unconstrained, starts, np.asarray, bound)


def _numpyro(
    target: Target, density: Callable[[Any], Any], starts: FloatArray, points: Look, bound: float
) -> Found:
    jax, jnp = jax_modules()
    numpyro = peer("numpyro.infer")

    watch = Watch()
    kernel = numpyro.NUTS(potential_fn=lambda position: -density(position))

    def begin(key: Any, position: Any) -> Any:
        return kernel.init(key, WARM_UP, position, (), {})

    def advance(state: Any) -> Any:
        def step(state: Any, _: None) -> Any:
            state = kernel.sample(state, (), {})
            return state, (state.z, state.num_steps)

        return jax.lax.scan(step, state, length=_ROUND)

    keys = jax.random.split(jax.random.PRNGKey(sampler_seed(target.index)), CHAINS)
    with watch("compile"):
        start = jax.jit(begin).lower(keys[0], jnp.asarray(starts[0])).compile()
    with watch("run"):
        states = [start(key, jnp.asarray(one)) for key, one in zip(keys, starts, strict=True)]
    with watch("compile"):
        going = jax.jit(advance).lower(states[0]).compile()

    def draw() -> tuple[FloatArray, int]:
        drawn, steps = [], 0
        for chain, state in enumerate(states):
            states[chain], (position, used) = going(state)
            drawn.append(np.asarray(position))
            steps += int(np.asarray(used).sum())
        return np.stack(drawn), steps

    gradients = 0
    with watch("run"):
        for _ in range(WARM_UP // _ROUND):
            gradients += draw()[1]
    return _until_enough(watch, draw, points, gradients, bound)


def blackjax_nuts(target: Target, bound: float) -> Found:
    """BlackJAX with its window adaptation, in ridge coordinates."""
    jax, jnp = jax_modules()
    blackjax = peer("blackjax")

    density, watch = target.density.ridge, Watch()
    adaptation = blackjax.window_adaptation(blackjax.nuts, density)

    def warm_up(key: Any, position: Any) -> Any:
        (state, tuned), details = adaptation.run(key, position, num_steps=WARM_UP)
        return state, tuned, details.info.num_integration_steps.sum()

    def advance(key: Any, state: Any, tuned: Any) -> Any:
        step = blackjax.nuts(density, **tuned).step

        def one(state: Any, key: Any) -> Any:
            state, details = step(key, state)
            return state, (state.position, details.num_integration_steps)

        return jax.lax.scan(one, state, jax.random.split(key, _ROUND))

    keys = jax.random.split(jax.random.PRNGKey(sampler_seed(target.index)), CHAINS)
    starts = target.warm_starts(CHAINS)
    with watch("compile"):
        warming = jax.jit(warm_up).lower(keys[0], jnp.asarray(starts[0])).compile()
    with watch("run"):
        warm = [warming(key, jnp.asarray(one)) for key, one in zip(keys, starts, strict=True)]
        gradients = sum(int(used) for _, _, used in warm)
    states = [state for state, _, _ in warm]
    with watch("compile"):
        going = jax.jit(advance).lower(keys[0], states[0], warm[0][1]).compile()
    rounds = 0

    def draw() -> tuple[FloatArray, int]:
        nonlocal rounds
        rounds += 1
        drawn, steps = [], 0
        for chain, state in enumerate(states):
            key = jax.random.fold_in(keys[chain], rounds)
            states[chain], (position, used) = going(key, state, warm[chain][1])
            drawn.append(np.asarray(position))
            steps += int(np.asarray(used).sum())
        return np.stack(drawn), steps

    def points(ridge: FloatArray) -> FloatArray:
        return points_of(target, ridge)

    return _until_enough(watch, draw, points, gradients, bound)


def _until_enough(
    watch: Watch,
    draw: Callable[[], tuple[FloatArray, int]],
    points: Look,
    gradients: int,
    bound: float,
) -> Found:
    """Draw round after round; counting the effective draws in between takes none of its time."""
    rounds: list[FloatArray] = []
    while True:
        with watch("run"):
            drawn, steps = draw()
        gradients += steps
        rounds.append(drawn)
        reached = points(np.concatenate(rounds, axis=1))
        late = watch.processor["run"] > bound
        if late or len(rounds) % _stride(len(rounds)) == 0:
            effective = effective_draws(reached)
            if late or effective.enough:
                return Found(reached, effective, watch, gradients=gradients)


def _stride(rounds: int) -> int:
    """Look at every round at first and then at every tenth of what there is."""
    return max(1, rounds // 10)


def nutpie_nuts(target: Target, bound: float) -> Found:
    """nutpie through its door for Python functions, in ridge coordinates.

    Each gradient is a call of Python into JAX and back, which costs several times what the gradient
    itself does; gradients per effective draw do not hang on that. A run has a length fixed
    beforehand: it counts up to the first draw at which there were enough, at its mean time a
    gradient, and where it was too short one of the right length takes its place.
    """
    draws = _NUTPIE_DRAWS
    found = _nutpie(target, draws)
    ess = min(found.effective.bulk, found.effective.tail)
    longer = 1.3 * WANTED / max(ess, 1.0)
    if not found.effective.enough and found.watch.processor["run"] * longer < bound:
        found = _nutpie(target, int(draws * longer))
    return found


def _nutpie(target: Target, draws: int) -> Found:
    jax, _ = jax_modules()
    nutpie = peer("nutpie")

    watch, starts = Watch(), target.warm_starts(CHAINS)
    chain_starts = iter(np.tile(starts, (100, 1)))
    called = 0
    with watch("compile"):
        both = jax.jit(jax.value_and_grad(target.density.ridge)).lower(starts[0]).compile()

    def make_density() -> Callable[[FloatArray], tuple[float, FloatArray]]:
        def value_and_gradient(position: FloatArray) -> tuple[float, FloatArray]:
            nonlocal called
            called += 1
            value, gradient = both(position)
            return float(value), np.asarray(gradient, dtype=np.float64)

        return value_and_gradient

    def make_expand(*_: Any) -> Callable[[FloatArray], dict[str, FloatArray]]:
        return lambda position: {"position": np.asarray(position)}

    model = peer("nutpie.compiled_pyfunc").from_pyfunc(
        target.likelihood.size,
        make_density,
        make_expand,
        [np.dtype("float64")],
        [(target.likelihood.size,)],
        ["position"],
        make_initial_point_fn=lambda _: next(chain_starts),
    )
    with watch("run"):
        trace = nutpie.sample(
            model,
            draws=draws,
            chains=CHAINS,
            cores=1,
            seed=sampler_seed(target.index),
            progress_bar=False,
        )
    points = points_of(target, trace.posterior["position"].values)
    steps = np.asarray(trace.sample_stats["n_steps"].values)  # (chains, draws)
    needed, effective = _first_enough(points)
    gradients = called - int(steps[:, needed:].sum())
    watch.scale("run", gradients / called)
    return Found(points[:, :needed], effective, watch, gradients=gradients)


def _first_enough(points: FloatArray) -> tuple[int, Effective]:
    """Draws of each chain after which there were enough, by bisection; else all of them."""
    draws = points.shape[1]
    looks = np.unique(np.linspace(draws / _NUTPIE_LOOKS, draws, _NUTPIE_LOOKS).astype(int))
    low, high = 0, looks.size - 1
    effective = effective_draws(points)
    if not effective.enough:
        return draws, effective
    while low < high:
        middle = (low + high) // 2
        here = effective_draws(points[:, : looks[middle]])
        if here.enough:
            high, effective = middle, here
        else:
            low = middle + 1
    return int(looks[high]), effective


def settle_jax() -> None:
    """Let JAX start up and compile something, which it takes longer over the first time."""
    jax, jnp = jax_modules()
    started = time.process_time()
    jax.jit(lambda x: jnp.log1p(jnp.exp(x)).sum())(jnp.arange(9.0)).block_until_ready()
    print(f"JAX started in {time.process_time() - started:.1f} s, which count for nobody")
