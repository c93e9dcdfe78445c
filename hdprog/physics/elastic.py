"""Elastic torsion of the cup and the tooth mesh, the part of the angle without a memory."""

from __future__ import annotations

from functools import partial
from typing import Literal

import numpy as np

from hdprog.physics.mesh_polynomials import coefficients, pay, polynomials, within_reach
from hdprog.physics.parameters import FloatArray, Parameters, column
from hdprog.physics.tooth_mesh import mesh_angle, mesh_angle_as_printed, mesh_area
from hdprog.physics.torque_path import TorquePath

ToothMesh = Literal["continuum", "as_printed"]
_COEFFICIENTS = "tooth-mesh coefficients"


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
    K_F, a, b, T_T = _columns(parameters)
    if tooth_mesh == "as_printed":
        teeth = mesh_angle_as_printed(path.magnitude, a, b, T_T) * path.sign
    else:
        averages = path.variance is not None
        follows = torque.ndim == 1 and path.largest > 0
        if follows and pay(len(a), torque.size, averages=averages):
            return _many_draws(path, K_F, a, b, T_T)
        teeth = _teeth(path, a, b, T_T)
    teeth += torque * (1 / K_F)
    return teeth


def _columns(parameters: Parameters) -> list[FloatArray]:
    """K_F, a, b, T_T, (draws, 1) each."""
    columns = [column(parameters[name]) for name in ("K_F", "a", "b", "T_T")]
    alike = len({each.shape for each in columns}) == 1
    return columns if alike else list(np.broadcast_arrays(*columns))


def _teeth(path: TorquePath, a: FloatArray, b: FloatArray, T_T: FloatArray) -> FloatArray:
    """Torsion of the tooth mesh, (draws, samples) in rad, of a, b, T_T (draws, 1)."""
    magnitude = path.magnitude
    angle = mesh_angle(magnitude, a, b, T_T)
    if path.variance is not None:
        # Half the curvature a/(a T + b)² is 1/(T √(2a) + b √(2/a))².
        bend = magnitude * np.sqrt(2 * a)
        bend += b * np.sqrt(2 / a)
        bend *= bend
        np.divide(path.variance, bend, out=bend)
        bend *= magnitude < T_T
        angle -= bend
    angle *= path.sign
    if path.variance is not None and path.around_zero.size:
        average = _average_around_zero(path, a, b, T_T)
        at = path.around_zero
        # Of torque by draw, some draws of a block may lie farther off.
        near = path.is_around_zero(path.torque[..., at], path.half_width[at])
        angle[:, at] = np.where(near, average, angle[:, at])
    return angle


def _average_around_zero(
    path: TorquePath, a: FloatArray, b: FloatArray, T_T: FloatArray
) -> FloatArray:
    """Exact averages of the mesh's torsion in the blocks around zero torque, (draws, blocks).

    Torque is even inside a block, so that its average is a difference of areas.
    """
    torque, half = path.torque[..., path.around_zero], path.half_width[path.around_zero]
    above, below = np.abs(torque + half), np.abs(torque - half)
    return (mesh_area(above, a, b, T_T) - mesh_area(below, a, b, T_T)) / (2 * half)


def _teeth_below(path: TorquePath, ratio: FloatArray) -> FloatArray:
    """F of `mesh_polynomials` at ratios a/b (ratios, 1): the torsion of no end T_T, times b."""
    return _teeth(path, ratio, np.ones_like(ratio), np.full_like(ratio, np.inf))


def _many_draws(
    path: TorquePath, K_F: FloatArray, a: FloatArray, b: FloatArray, T_T: FloatArray
) -> FloatArray:
    """The same as the torsion sample by sample, for many draws along one path."""
    near = within_reach((a / b)[:, 0], path.largest)
    if near.all():
        return _by_polynomials(path, K_F, a, b, T_T)
    angle = np.empty((len(a), path.torque.size))
    far = ~near
    angle[far] = _teeth(path, a[far], b[far], T_T[far]) + path.torque * (1 / K_F[far])
    if near.any():
        angle[near] = _by_polynomials(path, K_F[near], a[near], b[near], T_T[near])
    return angle


def _by_polynomials(
    path: TorquePath, K_F: FloatArray, a: FloatArray, b: FloatArray, T_T: FloatArray
) -> FloatArray:
    """The same as the torsion sample by sample, of draws within the polynomials' reach."""
    if _COEFFICIENTS not in path.worked_out:
        found = coefficients(partial(_teeth_below, path), path.largest)
        path.worked_out[_COEFFICIENTS] = np.vstack([found, path.torque])
    ratio, compliance = a / b, 1 / K_F
    rows = np.concatenate([polynomials(ratio, path.largest) / b, compliance], axis=1)
    angle = np.asarray(rows @ path.worked_out[_COEFFICIENTS])
    # Where a draw's is no number, neither is the least of them; the others' count all the same.
    least = float(T_T.min())
    if not least > path.largest:
        beyond = 1 / (a * T_T + b)
        lag = np.log1p(T_T * ratio) / a - T_T * beyond
        line = np.concatenate([beyond + compliance, lag], axis=1)
        angle = np.where(path.magnitude < T_T, angle, line @ path.torque_and_sign)
    if path.reach_around_zero and not least >= path.reach_around_zero:
        at = path.around_zero
        angle[:, at] = _average_around_zero(path, a, b, T_T) + path.torque[at] * compliance
    return angle
