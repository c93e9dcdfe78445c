"""Waves by a polynomial against the library's sine and cosine."""

from __future__ import annotations

import numpy as np

from hdprog.physics.periodic import wave


def test_a_wave_is_the_sine_and_cosine_that_it_is_made_of() -> None:
    rng = np.random.default_rng(0)
    turns = np.concatenate(
        [rng.uniform(-80, 80, (50, 400)), np.linspace(-1, 1, 20_000).reshape(50, 400)]
    )
    sine, cosine = rng.standard_normal((2, 100, 1))
    expected = sine * np.sin(2 * np.pi * turns) + cosine * np.cos(2 * np.pi * turns)
    assert np.abs(wave(turns, sine, cosine) - expected).max() < 2e-12


def test_a_wave_without_amplitude_is_none() -> None:
    turns = np.linspace(-2, 2, 11)[None]
    assert np.array_equal(wave(turns, np.zeros((1, 1)), np.zeros((1, 1))), np.zeros((1, 11)))
