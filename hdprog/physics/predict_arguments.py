"""Arguments of `predict`: checked, and brought to arrays that go together."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from hdprog.errors import BadInputError
from hdprog.physics.parameters import NAMES, FloatArray, Parameters, in_support

__all__ = ["checked_alpha", "checked_draws"]


def checked_alpha(alpha: object, where: str) -> float:
    """Gear-tooth angle in rad, between 0 and a right angle.

    Raises
    ------
    BadInputError
        for what is no such angle: one in degrees, above all
    """
    try:
        value = float(alpha)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        value = math.nan
    if not 0 < value < math.pi / 2:
        raise BadInputError(
            found=f"alpha={alpha!r}",
            where=where,
            expected="the gear-tooth angle in rad, between 0 and 1.57",
            advice="give degrees as math.radians(30)",
        )
    return value


def checked_draws(
    parameters: Parameters, initial_slip: FloatArray | float, alpha: float
) -> tuple[dict[str, FloatArray], FloatArray]:
    """Parameters and slip as numbers, or as arrays of one value a draw where any is an array.

    Raises
    ------
    BadInputError
        if a parameter is missing, no number or outside the hard support, the initial slip is no
        number, or the arrays do not belong to the same draws
    """
    if not hasattr(parameters, "__getitem__"):
        missing = list(NAMES)
    else:
        missing = [name for name in NAMES if name not in parameters]
    if missing:
        raise BadInputError(
            found="parameters without " + ", ".join(missing),
            where="argument parameters",
            expected="all of " + ", ".join(NAMES),
            advice="add the missing ones, in SI units",
        )
    given = {name: _numbers(parameters[name], name) for name in NAMES}
    slip = _numbers(initial_slip, "initial_slip")
    try:
        shape = np.broadcast_shapes(slip.shape, *(value.shape for value in given.values()))
    except ValueError:
        shape = (0,)
    if 0 in shape:
        shapes = {**given, "initial_slip": slip}
        raise BadInputError(
            found=", ".join(f"{n} of shape {v.shape}" for n, v in shapes.items() if v.ndim),
            where="arguments parameters and initial_slip",
            expected="each a number, or an array of one value a draw, as many in all of them",
            advice="pass arrays that belong to the same draws",
        )
    if np.isnan(slip).any():
        raise BadInputError(
            found="initial_slip that is no number",
            where="argument initial_slip",
            expected="the slip y before the first sample",
            advice="pass a number, or leave it out for 0",
        )
    values = {name: np.broadcast_to(value, shape) for name, value in given.items()}
    _require_support(values, alpha)
    return values, np.broadcast_to(slip, shape)


def _numbers(value: object, name: str) -> FloatArray:
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise BadInputError(
            found=f"{name} of type {type(value).__name__}",
            where=f"argument {'parameters' if name in NAMES else name}",
            expected="a number, or an array of one value a draw",
            advice="pass numbers in SI units",
        ) from error


def _require_support(values: Mapping[str, FloatArray], alpha: float) -> None:
    # With an infinite stiffness there is a limit, a rigid part; with an infinite a, or an infinite
    # T_T beside a = 0, there is none.
    inside = in_support(values, alpha) & np.isfinite(values["a"]) & np.isfinite(values["T_T"])
    if inside.all():
        return
    first = int(np.argmin(inside))
    of_draw = f" in draw {first + 1}" if inside.ndim else ""
    raise BadInputError(
        found=f"parameter values outside the model's support{of_draw}: "
        + ", ".join(f"{name}={float(values[name].flat[first])!r}" for name in NAMES),
        where="argument parameters",
        expected="stiffnesses > 0, a, T_T, T_i >= 0, a and T_T finite, c < 0, "
        "0 < mu < min(tan alpha, cot alpha) and sin alpha + mu (cos alpha + c) > 0",
        advice="check signs and units",
    )
