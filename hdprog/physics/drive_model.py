"""Torsion angle of a harmonic drive under any torque history (eqs 15-28).

The wave generator's slip is a play operator: it stays where it is until an envelope pushes it.
All functions work on `(draws, samples)` arrays.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from hdprog.errors import BadInputError
from hdprog.physics.elastic import ToothMesh, elastic_angle
from hdprog.physics.parameters import FloatArray, Parameters
from hdprog.physics.predict_arguments import checked_alpha, checked_draws
from hdprog.physics.torque_path import TorquePath, line_basis


def slip_envelope(
    pushed: FloatArray, parameters: Parameters, alpha: float, basis: FloatArray | None = None
) -> FloatArray:
    """Envelope that pushes the slip, seen along the direction of travel (eqs 26, 28).

    With d = ±1 the direction of torque and u = d·T, the slip obeys d·y = max(d·y0, g(u)):
    g(u) is the loading envelope B(u) for u >= 0 and minus the unloading envelope, −U(−u), for
    u < 0. Both come out of one expression, since B's first branch continued to u < 0 is −U.

    Parameters
    ----------
    pushed : (samples,) or (draws, samples) u in Nm
    parameters : c, T_i, mu, K_W, each scalar or (draws,)
    alpha : gear-tooth angle in rad
    basis : u, |u| and 1, (3, samples) or (draws, 3, samples), where they are known

    Returns
    -------
    (draws, samples) slip in rad of wave-generator travel
    """
    s, k = math.sin(alpha), math.cos(alpha)
    mu, c, T_i, K_W = (np.ravel(parameters[name]) for name in ("mu", "c", "T_i", "K_W"))
    # Up to T_i, a branch bends by mu·c·(T_i − |u|), the preload that is left (eq. 16): a line in u
    # and |u|, where it lies below the line in u alone that it ends in.
    driving, drawing = 1 / (K_W * (k + mu * s)), 1 / (K_W * (k - mu * s))
    preload = -mu * c
    if basis is None:
        basis = line_basis(pushed)
    driven = _lower_of_lines((s - mu * k) * driving, preload * driving, T_i, basis)
    np.maximum(driven, 0.0, out=driven)
    # What draws back is at least what drives wherever it is not negative, and there alone the
    # slip is driven.
    drawn_back = _lower_of_lines((s + mu * k) * drawing, preload * drawing, T_i, basis)
    return np.minimum(drawn_back, driven, out=drawn_back)


def _lower_of_lines(
    slope: FloatArray, bend: FloatArray, until: FloatArray, basis: FloatArray
) -> FloatArray:
    """Lower of slope·u and slope·u + bend·(|u| − until): (draws, samples) of (draws,) each.

    `basis` is u, |u| and 1, (3, samples) or (draws, 3, samples). Matrix products: by far the
    fastest way to a line for each draw.
    """
    line = np.zeros((np.broadcast(slope, bend, until).size, 3))
    line[:, 0] = slope
    straight = _times(line, basis)
    line[:, 1], line[:, 2] = bend, -bend * until
    return np.minimum(straight, _times(line, basis), out=straight)


def _times(rows: FloatArray, basis: FloatArray) -> FloatArray:
    """Sums over `basis`, (k, samples) or (draws, k, samples), by `rows` (draws, k)."""
    if basis.ndim == 2:
        return np.asarray(rows @ basis)
    return np.asarray(rows[:, None, :] @ basis)[:, 0]


def slip(
    path: TorquePath,
    parameters: Parameters,
    alpha: float,
    initial_slip: FloatArray | float = 0.0,
    initial_fraction: FloatArray | None = None,
    negative: Parameters | None = None,
) -> FloatArray:
    """Wave-generator slip y along a torque path: a play operator between its envelopes.

    Parameters
    ----------
    path : the torque history
    parameters : by name, each scalar or (draws,)
    alpha : gear-tooth angle in rad
    initial_slip : scalar or (draws,) y before the first sample, clipped to the envelopes there
    initial_fraction : (draws,) instead of it, y as a fraction of the way from the lower to the
        upper envelope at the first torque
    negative : parameters of the side of negative torque, where that has its own

    Returns
    -------
    (draws, samples) slip in rad
    """
    # One call for the samples, the ends of the stretches and both envelopes at the first sample.
    pushed, basis = path.pushing, path.pushing_basis
    envelopes = slip_envelope(pushed, parameters, alpha, basis)
    if negative is not None:
        torque = np.concatenate([path.torque, path.reached, path.torque[..., [0, 0]]], axis=-1)
        envelopes = np.where(torque < 0, slip_envelope(pushed, negative, alpha, basis), envelopes)
    envelope, at_end, lower, upper = path.parted(envelopes)
    if initial_fraction is None:
        initial = np.asarray(initial_slip, dtype=np.float64)
        current = np.minimum(np.maximum(initial, lower), upper)
    else:
        current = lower + initial_fraction * (upper - lower)
    return play(path, envelope, at_end, current, falls=negative is not None)


def play(
    path: TorquePath,
    envelope: FloatArray,
    at_end: FloatArray,
    current: FloatArray,
    *,
    falls: bool = False,
) -> FloatArray:
    """Carry a state along a torque path: it stays where it is until an envelope pushes it.

    Parameters
    ----------
    path : the torque history
    envelope : (draws, samples) envelope that pushes, along the direction of travel; overwritten
    at_end : (draws, stretches) the same at the end of each stretch
    current : (draws,) state before the first sample, between the envelopes there
    falls : whether the envelope may fall along a stretch, as where the sides of torque differ

    Returns
    -------
    (draws, samples) state
    """
    at_end = at_end.T.copy()
    if falls:
        for reached, start, end in zip(at_end, path.starts, path.ends, strict=True):
            stretch = envelope[:, start:end]
            np.maximum.accumulate(stretch, axis=1, out=stretch)
            if end > start:
                np.maximum(reached, stretch[:, -1], out=reached)
    # How far the state has come along the direction of travel before each stretch, turned at each
    # reversal.
    travelled = np.empty_like(at_end)
    travelled[0] = current if path.rising[0] else -current
    for before, after in pairwise(range(path.starts.size)):
        np.maximum(at_end[before], travelled[before], out=travelled[after])
        if path.rising[after] != path.rising[before]:
            np.negative(travelled[after], out=travelled[after])
    np.maximum(envelope, np.repeat(travelled.T, path.lengths, axis=1), out=envelope)
    envelope *= path.direction
    return envelope


def torsion_angle(
    path: TorquePath,
    parameters: Parameters,
    alpha: float,
    tooth_mesh: ToothMesh = "continuum",
    initial_slip: FloatArray | float = 0.0,
    initial_fraction: FloatArray | None = None,
    negative: Parameters | None = None,
) -> FloatArray:
    """Torsion angle Δθ = T/K_F + Δθ_T(T) + tan(alpha)·y (21).

    Parameters as in `slip`; nothing is checked here (see `predict`).

    Returns
    -------
    (draws, samples) angle in rad
    """
    angle = slip(path, parameters, alpha, initial_slip, initial_fraction, negative)
    angle *= math.tan(alpha)
    angle += elastic_angle(path, parameters, tooth_mesh, negative)
    return angle


def predict(
    torque: FloatArray,
    parameters: Parameters,
    alpha: float = math.radians(30.0),
    tooth_mesh: ToothMesh = "continuum",
    initial_slip: FloatArray | float = 0.0,
) -> FloatArray:
    """Torsion angle of the drive along a torque history, input locked.

    Parameters
    ----------
    torque : (samples,) torque in Nm, in order of time
    parameters : mapping of K_F [Nm/rad], K_W [Nm/rad], a [1/rad], b [Nm/rad], T_T [Nm], c [-],
        T_i [Nm], mu [-]; scalars, or (draws,) arrays
    alpha : gear-tooth angle in rad
    tooth_mesh : "continuum" (the integral of dT/K_T) or "as_printed" (the sum of eq. 19)
    initial_slip : y before the first sample, clipped to the envelope like every other; a scalar,
        or a (draws,) array

    Returns
    -------
    (samples,) torsion angle in rad, or (draws, samples) if a parameter or the slip is an array

    Raises
    ------
    BadInputError
        if a parameter is missing or outside the hard support, arrays do not belong to the same
        draws, torque is not a finite series, alpha is no angle in rad between 0 and a right angle,
        or initial_slip is no number
    """
    alpha = checked_alpha(alpha, "argument alpha")
    if tooth_mesh not in ("continuum", "as_printed"):
        raise BadInputError(
            found=f"tooth_mesh={tooth_mesh!r}",
            where="argument tooth_mesh",
            expected='"continuum" or "as_printed"',
            advice="choose one of the two forms",
        )
    values, before = checked_draws(parameters, initial_slip, alpha)
    path = TorquePath.exact(torque)
    angle = torsion_angle(path, values, alpha, tooth_mesh, before.ravel())
    return angle[0] if before.ndim == 0 else angle
