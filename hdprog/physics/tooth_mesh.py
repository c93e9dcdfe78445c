"""Torsion of the tooth mesh under torque, whose stiffness rises as teeth engage (eqs 17, 19)."""

from __future__ import annotations

import math

import numpy as np

from hdprog.physics.parameters import FloatArray


def mesh_angle(magnitude: FloatArray, a: FloatArray, b: FloatArray, T_T: FloatArray) -> FloatArray:
    """Tooth-mesh torsion at torque magnitudes: the integral of dT/K_T (eqs 17, 19).

    Parameters
    ----------
    magnitude : (samples,) or (draws, samples) torque magnitude in Nm
    a, b, T_T : (draws, 1) in 1/rad, Nm/rad, Nm

    Returns
    -------
    (draws, samples) angle in rad
    """
    meshing = np.minimum(magnitude, T_T)
    # Below this, log1p(z)/a loses its digits; the series keeps them and covers a = 0.
    small = a * T_T < 1e-9 * b
    any_small = bool(small.any())
    a_safe = np.where(small, 1.0, a) if any_small else a
    angle = meshing * (a_safe / b)
    np.log1p(angle, out=angle)
    angle *= 1 / a_safe
    if any_small:
        angle = np.where(small, meshing / b, angle)
    beyond = np.subtract(magnitude, meshing, out=meshing)
    beyond *= 1 / (a * T_T + b)
    angle += beyond
    return angle


def mesh_angle_as_printed(
    magnitude: FloatArray, a: FloatArray, b: FloatArray, T_T: FloatArray
) -> FloatArray:
    """Tooth-mesh torsion by the printed sum (19): a staircase, tied to torque in Nm.

    Shapes and units as in `mesh_angle`. Serves to reproduce the paper.
    """
    magnitude = np.broadcast_to(magnitude, np.broadcast_shapes(magnitude.shape, a.shape))
    steps = np.arange(1, max(1, math.ceil(float(magnitude.max()))) + 1)
    sums = np.concatenate([np.zeros_like(a), np.cumsum(1.0 / (a * steps + b), axis=1)], axis=1)
    below = np.maximum(np.ceil(np.minimum(magnitude, T_T)) - 1, 0).astype(np.intp)
    stair = np.take_along_axis(np.broadcast_to(sums, (a.shape[0], sums.shape[1])), below, axis=1)
    return stair + np.maximum(magnitude - T_T, 0.0) / (a * T_T + b)


def mesh_area(magnitude: FloatArray, a: FloatArray, b: FloatArray, T_T: FloatArray) -> FloatArray:
    """Integral of the tooth-mesh torsion over torque from zero, in rad Nm.

    Shapes and units as in `mesh_angle`.
    """
    meshing = np.minimum(magnitude, T_T)
    small = a * T_T < 1e-9 * b
    a_safe = np.where(small, 1.0, a)
    at_end, bent = mesh_angle(meshing, a, b, T_T), meshing * (a_safe / b)
    # Below this, the difference loses its digits and four terms of its series are as good.
    few = np.minimum(bent, 1e-3)
    series = few**2 * (1 / 2 - few * (1 / 6 - few * (1 / 12 - few / 20)))
    area = np.where(bent < 1e-3, series, (1 + bent) * a_safe * at_end - bent) * (b / a_safe**2)
    area = np.where(small, meshing**2 / (2 * b), area)
    beyond = magnitude - meshing
    return np.asarray(area + beyond * (at_end + 0.5 * beyond / (a * T_T + b)))
