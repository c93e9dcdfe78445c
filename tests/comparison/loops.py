"""Short records with known truth, made with any of the models."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from hdprog.data.coordinates import record_course
from hdprog.data.loop import Loop
from hdprog.inference.sampling_plan import SamplingPlan
from hdprog.physics.other_models import BY_ID
from hdprog.physics.other_models.base import Setting
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

TOP = 60.0
NOISE = 1e-5
SHORT = SamplingPlan(
    required_ess=200.0,
    warm_up_steps=(100, 40, 40),
    first_steps=100,
    most_steps=700,
    refits=1,
    stored_steps=40,
)

# Physical values by model; those of sums with weights follow from a rule below.
TRUTHS: dict[str, dict[str, float]] = {
    "catalogue_piecewise": {"K1": 1.1e4, "K2": 1.9e4, "K3": 2.9e4, "T1": 12.0, "T2_T1": 20.0},
    "cubic": {"a1": 1.5e4, "a3": 6.0e8},
    "dhaouadi": {
        "b1": 1.5e4,
        "b2": 4.0e8,
        "b3": 1.0e12,
        "A": 8.0e3,
        "beta": 4.0e3,
        "initial_state": 0.3,
    },
    "zhang": {
        "K_F0": 2.5e4,
        "C_F": 0.02,
        "K_w0": 4.0e4,
        "C_w": 0.01,
        "F_f": 3.0,
        "initial_state": 0.4,
    },
    "seyfferth": {"a1": 1.6e4, "a3": 5.0e8, "T_c": 2.0, "delta": 1.5e-4, "initial_state": -0.2},
    "taghirad": {"a1": 1.6e4, "a3": 4.0e8, "D": 3.0, "p": 1.2, "initial_state": 0.5},
}


def torque_history(samples: int = 280, one_sided: bool = False) -> FloatArray:
    """Two cycles from zero back to zero, about so many readings, one at every reversal, in Nm."""
    turns = [0.0, TOP, 0.0, TOP, 0.0] if one_sided else [0.0, TOP, -TOP, TOP, -TOP, 0.0]
    step = float(np.abs(np.diff(turns)).sum()) / samples
    legs = [
        np.linspace(low, high, max(3, round(abs(high - low) / step)) + 1)[1:]
        for low, high in pairwise(turns)
    ]
    return np.concatenate([[0.0], *legs])


def loop_of(model_id: str, rng: np.random.Generator, *, one_sided: bool = False) -> Loop:
    """A noisy record of a model with its values of `TRUTHS`; "tuttle" has time and position."""
    torque = torque_history(one_sided=one_sided)
    time = np.arange(torque.size) * 0.5
    moving = model_id == "tuttle"
    output = 0.6 + 0.02 * time + 0.2 * np.sin(time / 9) if moving else None
    path, model = TorquePath.exact(torque), BY_ID[model_id]
    angle = torque / 2.0e4
    for _ in range(3):  # priors and elements are laid out for the record that comes out
        course = record_course(Loop(torque, angle, time=time, output_angle=output), path, 0.0)
        setting = Setting.of(course)
        values = {n: np.array([[value]]) for n, value in truth_of(model_id, setting).items()}
        found = model.angle(course, values, setting)[0]
        angle = found if found.any() else angle
    angle = found
    noisy = angle + 4e-4 + NOISE * rng.standard_normal(angle.size)
    return Loop(torque, noisy, time=time, output_angle=output, source=model_id)


def truth_of(model_id: str, setting: Setting) -> dict[str, float]:
    """Physical values by name."""
    if model_id in TRUTHS:
        return TRUTHS[model_id]
    names = [one.name for one in BY_ID[model_id].parameters(setting)]
    if model_id == "tuttle":
        return dict.fromkeys(names, 0.0) | {
            "a1": 1.6e4,
            "a3": 4.0e8,
            "F_c": 2.0,
            "F_s_F_c": 2.0,
            "Omega": 0.02,
            "delta": 1.0,
            "F_v": 10.0,
            "n_1": 6.0,
            "ratio_2": 2.1,
            "ratio_3": 2.9,
            "sine_1": 1.2e-4,
            "cosine_2": 6e-5,
            "sine_3": 3e-5,
        }
    if model_id == "maxwell_slip":
        slipping = {"w_3": 4e-6, "w_6": 5e-6, "w_8": 4e-6}
        return {name: 3e-5 if name.startswith("v") else 0.0 for name in names} | slipping
    if model_id == "preisach":
        wide = {"w_6_2": 1.5e-4, "w_5_4": 2e-4, "w_6_4": 1e-4, "w_4_3": 1.5e-4}
        return {name: 4e-5 if name.startswith("v") else 0.0 for name in names} | wide
    return {}
