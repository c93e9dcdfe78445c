"""Tooth-mesh torsion: the printed sum (19) against the integral of dT/K_T (17)."""

from __future__ import annotations

import numpy as np

from hdprog.physics.parameters import FloatArray
from hdprog.physics.tooth_mesh import mesh_angle, mesh_angle_as_printed
from hdprog.reproduction.results import Curve, Finding
from hdprog.reproduction.table2 import POST_TEST, TOP, as_draw

_ABOUT = 0.05  # relative difference that "about" allows
_FINER = 10.0  # times as fine a unit of torque


def curves() -> tuple[Curve, ...]:
    """Both forms over torque, and the sum taken in tenths of a Nm."""
    torque = np.linspace(0.0, TOP, 1001)
    return (
        Curve("integral", torque, _mesh(torque)),
        Curve("sum over whole Nm, as printed", torque, _sum(torque, 1.0)),
        Curve("the same sum in units of 0.1 Nm", torque, _sum(torque, _FINER)),
    )


def finding() -> Finding:
    """The two forms at the top, and how the sum hangs on its unit."""
    top = np.array([TOP])
    integral, printed, finer = (
        float(form[0]) for form in (_mesh(top), _sum(top, 1.0), _sum(top, _FINER))
    )
    return Finding(
        "eq. 19",
        "The tooth-mesh torsion is about the sum of 1/(a·i + b) over whole numbers i below the "
        "torque.",
        f"With the post-test values the sum is {integral - printed:.2e} rad below the integral at "
        f"{TOP:.0f} Nm ({100 * (integral - printed) / integral:.1f} % of the mesh torsion), and "
        f"{integral - finer:.2e} rad where torque is counted in tenths of a Nm: it is a staircase "
        "that depends on the unit. hdprog takes the integral unless told otherwise.",
        "agrees" if abs(integral - printed) < _ABOUT * integral else "disagrees",
        {
            "integral_rad": integral,
            "sum_rad": printed,
            "sum_in_tenths_rad": finer,
            "difference_rad": integral - printed,
        },
    )


def _columns(scale: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """a, b and T_T where torque is counted in units of 1/scale Nm."""
    values = as_draw(POST_TEST)
    b, T_T = values["b"][:, None] * scale, values["T_T"][:, None] * scale
    return values["a"][:, None], b, T_T


def _mesh(torque: FloatArray) -> FloatArray:
    return np.asarray(mesh_angle(torque, *_columns(1.0))[0])


def _sum(torque: FloatArray, scale: float) -> FloatArray:
    # a is per rad whatever the unit of torque; b and T_T carry it.
    return np.asarray(mesh_angle_as_printed(torque * scale, *_columns(scale))[0])
