"""Coordinates along what a loop fixes, in which its posterior is nearly straight.

A loop fixes sums and products sharply and their parts hardly at all: the compliance at high
torque, the step of angle that the teeth add below their threshold, the friction at no load. In
the logarithms of the parameters such a posterior is a thin bent sheet. Here each sharp
combination is a coordinate of its own:

    C     = 1/K_F + 1/(a T_m + b) + tan²α/K_W     compliance at high torque
    p_W   = tan²α/(K_W C)                         share of the wave generator in it
    p_F   = (1/K_F)/(C − tan²α/K_W)               share of the cup in the rest
    D     = T_m/(a T_m + b) · log(1 + z/2)        extra angle of the teeth, z = a T_m/b
    m     = |c| μ,  P = m T_i                     fall of friction with torque, and its size
    ξ     = min(m, P/T) − μ cos α                 its mean fall up to the record's largest torque T

T_m = min(T_T, T) is how far the record sees the teeth mesh: a threshold beyond it changes nothing.
Friction falls by m − μ cos α per torque up to T_i, and grows from there on: where T_i lies inside
the record, that record fixes the mean fall, and m only so far as T_i.

They are sampled as log C, logit p_W, logit p_F, log D, the coordinate of T_T, log m, ξ and log P.
D stands for the exact (log(1+z)·(1+z)/z − 1)·T_m/(a T_m + b), which has no inverse in closed form.
"""

from __future__ import annotations

import math

import numpy as np

from hdprog.physics.parameters import FloatArray

_XI_SCALE = 0.02
_LARGEST_LOG = 5.0  # of y = D (a T_m + b)/T_m: z = 2 (exp y − 1) beyond 1e60 is out of any prior


def _log_sigmoid(value: FloatArray) -> FloatArray:
    return np.asarray(-np.logaddexp(0.0, -value))


def to_unconstrained(
    ridge: FloatArray, alpha: float, softplus_scale: float, largest_torque: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Unconstrained parameter coordinates of ridge coordinates, with the Jacobian.

    Parameters
    ----------
    ridge : (draws, 8)
    alpha : gear-tooth angle in rad
    softplus_scale : scale in Nm of the coordinate of T_T
    largest_torque : of the record in Nm; without one T_m = T_T, and ξ is the fall at no load

    Returns
    -------
    (draws, 8) unconstrained coordinates and (draws,) log |det| of their derivative; −inf where
    the ridge coordinates name no parameters
    """
    log_C, logit_W, logit_F, log_D, x_T, log_m, xi, log_P = ridge.T
    log_p_W, log_p_F = _log_sigmoid(logit_W), _log_sigmoid(logit_F)
    log_K_W = 2 * math.log(math.tan(alpha)) - log_p_W - log_C
    log_rest = log_C + (log_p_W - logit_W)  # log of 1 − p_W, as of 1 − p_F below
    log_K_F = -log_p_F - log_rest
    log_mesh = -(log_p_F - logit_F) - log_rest
    log_met = np.log(_met(x_T, softplus_scale, largest_torque))
    log_y = log_D + log_mesh - log_met
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        y = np.exp(np.minimum(log_y, _LARGEST_LOG))
        z = 2 * np.expm1(y)
        log_b = log_mesh - np.log1p(z)
        log_a = np.log(z) + log_b - log_met
        log_mu = np.log(
            (_mean_fall(log_m, log_P, largest_torque) - _XI_SCALE * xi) / math.cos(alpha)
        )
        jacobian = np.log(y) - np.log(-np.expm1(-y)) - log_mu
    coordinates = np.array(
        [log_K_F, log_K_W, log_a, log_b, x_T, log_m - log_mu, log_P - log_m, log_mu]
    ).T
    inside = np.isfinite(coordinates).all(axis=1) & (log_y < _LARGEST_LOG)
    return coordinates, np.where(inside, jacobian, -np.inf)


def _met(x_T: FloatArray, softplus_scale: float, largest_torque: float | None) -> FloatArray:
    """Torque in Nm up to which the teeth are seen to mesh."""
    threshold = softplus_scale * np.logaddexp(0.0, x_T)
    return np.asarray(np.minimum(threshold, math.inf if largest_torque is None else largest_torque))


def _mean_fall(log_m: FloatArray, log_P: FloatArray, largest_torque: float | None) -> FloatArray:
    """Mean of the part of friction's fall that ends at T_i, up to the largest torque."""
    if largest_torque is None:
        return np.asarray(np.exp(log_m))
    return np.asarray(np.exp(np.minimum(log_m, log_P - math.log(largest_torque))))


def from_unconstrained(
    coordinates: FloatArray,
    alpha: float,
    softplus_scale: float,
    largest_torque: float | None = None,
) -> FloatArray:
    """Ridge coordinates (draws, 8) of unconstrained ones; the inverse of `to_unconstrained`."""
    K_F, K_W, a, b = np.exp(coordinates[:, :4]).T
    x_T, log_c, log_T_i, log_mu = coordinates[:, 4:].T
    met = _met(x_T, softplus_scale, largest_torque)
    z = a * met / b
    mesh = b * (1 + z)
    rest = 1 / K_F + 1 / mesh
    wave_generator = math.tan(alpha) ** 2 / K_W
    log_m = log_c + log_mu
    log_P = log_T_i + log_m
    fall = _mean_fall(log_m, log_P, largest_torque)
    return np.column_stack(
        [
            np.log(rest + wave_generator),
            np.log(wave_generator / rest),
            np.log(mesh / K_F),
            np.log(np.log1p(z / 2) * met / mesh),
            x_T,
            log_m,
            (fall - math.cos(alpha) * np.exp(log_mu)) / _XI_SCALE,
            log_P,
        ]
    )
