"""Torsion angle of a harmonic drive under any torque history (eqs 15-28).

The wave generator's slip is a play operator: it stays where it is until an envelope pushes it.
All functions work on `(draws, samples)` arrays.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from hdprog.errors import BadInputError
from hdprog.physics.parameters import FloatArray, Parameters
from hdprog.physics.predict_arguments import checked_alpha, checked_draws
from hdprog.physics.tooth_mesh import mesh_angle, mesh_angle_as_printed, mesh_area
from hdprog.physics.torque_path import TorquePath

ToothMesh = Literal["continuum", "as_printed"]


def _column(value: FloatArray) -> FloatArray:
    """A scalar or `(draws,)` array as `(draws, 1)`."""
    return np.reshape(np.asarray(value, dtype=np.float64), (-1, 1))


def elastic_angle(
    path: TorquePath,
    parameters: Parameters,
    tooth_mesh: ToothMesh = "continuum",
    negative: Parameters | None = None,
) -> FloatArray:
    """Cup and tooth-mesh torsion T/K_F + Δθ_T(T), mirrored for negative torque.

    Where samples are block averages, the mesh's curvature times the variance of torque inside
    the block is added, so that the average of the angle is compared with the average. In blocks
    around zero torque, where the mesh may bend within the block, the average is exact.

    Parameters
    ----------
    path : the torque history
    parameters, negative : of the drive, and of its negative side where that has its own

    Returns
    -------
    (draws, samples) angle in rad
    """
    torque = path.torque
    if negative is not None:
        here = elastic_angle(path, parameters, tooth_mesh)
        return np.where(torque < 0, elastic_angle(path, negative, tooth_mesh), here)
    a, b, T_T = (_column(parameters[name]) for name in ("a", "b", "T_T"))
    magnitude = np.abs(torque)
    mesh = mesh_angle if tooth_mesh == "continuum" else mesh_angle_as_printed
    angle = mesh(magnitude, a, b, T_T)
    if path.variance is not None and tooth_mesh == "continuum":
        # Half the curvature a/(a T + b)² is 1/(T √(2a) + b √(2/a))².
        bend = magnitude * np.sqrt(2 * a)
        bend += b * np.sqrt(2 / a)
        bend *= bend
        np.divide(path.variance, bend, out=bend)
        bend *= magnitude < T_T
        angle -= bend
    angle *= np.sign(torque)
    if path.variance is not None and tooth_mesh == "continuum" and path.around_zero.size:
        _average_around_zero(angle, path, a, b, T_T)
    angle += torque * (1 / _column(parameters["K_F"]))
    return angle


def _average_around_zero(
    angle: FloatArray, path: TorquePath, a: FloatArray, b: FloatArray, T_T: FloatArray
) -> None:
    """Put exact averages of the mesh's angle into the blocks (draws, samples) around zero torque.

    Torque is even inside a block, so that its average is a difference of areas.
    """
    at, half = path.around_zero, path.half_width[path.around_zero]
    torque = path.torque[..., at]
    above, below = np.abs(torque + half), np.abs(torque - half)
    average = (mesh_area(above, a, b, T_T) - mesh_area(below, a, b, T_T)) / (2 * half)
    # Of torque by draw, some draws of a block may lie farther off.
    angle[:, at] = np.where(path.is_around_zero(torque, half), average, angle[:, at])


def slip_envelope(pushed: FloatArray, parameters: Parameters, alpha: float) -> FloatArray:
    """Envelope that pushes the slip, seen along the direction of travel (eqs 26, 28).

    With d = ±1 the direction of torque and u = d·T, the slip obeys d·y = max(d·y0, g(u)):
    g(u) is the loading envelope B(u) for u >= 0 and minus the unloading envelope, −U(−u), for
    u < 0. Both come out of one expression, since B's first branch continued to u < 0 is −U.

    Parameters
    ----------
    pushed : (samples,) or (draws, samples) u in Nm
    parameters : c, T_i, mu, K_W, each scalar or (draws,)
    alpha : gear-tooth angle in rad

    Returns
    -------
    (draws, samples) slip in rad of wave-generator travel
    """
    s, k = math.sin(alpha), math.cos(alpha)
    mu, c = _column(parameters["mu"]), _column(parameters["c"])
    T_i, K_W = _column(parameters["T_i"]), _column(parameters["K_W"])
    # mu * T_0 (eq. 16) is -mu * c times what is missing to T_i.
    missing = T_i - np.abs(pushed)
    np.maximum(missing, 0.0, out=missing)
    compliance = 1 / (K_W * (k + mu * s))
    driven = pushed * ((s - mu * k) * compliance)
    missing *= -mu * c * compliance
    driven -= missing
    np.maximum(driven, 0.0, out=driven)
    compliance = 1 / (K_W * (k - mu * s))
    drawn_back = pushed * ((s + mu * k) * compliance)
    missing *= (k + mu * s) / (k - mu * s)
    drawn_back -= missing
    # What draws back is at least what drives wherever it is not negative, and there alone the
    # slip is driven.
    return np.minimum(drawn_back, driven, out=drawn_back)


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
    samples, stretches = path.torque.shape[-1], path.starts.size
    # One call for the samples, the ends of the stretches and both envelopes at the first sample.
    pushed = path.pushing
    envelopes = slip_envelope(pushed, parameters, alpha)
    if negative is not None:
        torque = np.concatenate([path.torque, path.reached, path.torque[..., [0, 0]]], axis=-1)
        envelopes = np.where(torque < 0, slip_envelope(pushed, negative, alpha), envelopes)
    envelope = envelopes[:, :samples]
    at_end = envelopes[:, samples : samples + stretches]
    lower, upper = envelopes[:, -2], -envelopes[:, -1]
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
    # How far the state has come along the direction of travel, turned at each reversal.
    travelled = current if path.rising[0] else -current
    for number, (start, end) in enumerate(zip(path.starts, path.ends, strict=True)):
        if number:
            travelled = np.maximum(at_end[:, number - 1], travelled)
            if falls and path.ends[number - 1] > path.starts[number - 1]:
                travelled = np.maximum(envelope[:, path.ends[number - 1] - 1], travelled)
            if path.rising[number] != path.rising[number - 1]:
                travelled = -travelled
        stretch = envelope[:, start:end]
        if falls:
            np.maximum.accumulate(stretch, axis=1, out=stretch)
        np.maximum(stretch, travelled[:, None], out=stretch)
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
