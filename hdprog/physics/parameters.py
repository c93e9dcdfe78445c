"""The eight physical parameters of the drive model: names, units, supports, sources."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Parameters = Mapping[str, FloatArray]
"""Parameter values by name; each a scalar or a `(draws,)` array, in SI units."""

Transform = Literal["log", "negative_log", "softplus"]


@dataclass(frozen=True)
class Parameter:
    """One physical parameter and the unconstrained coordinate in which it is inferred.

    The coordinate `x` is `log(value)` for "log", `log(-value)` for "negative_log" and the
    inverse of `value = scale * log(1 + exp(x))` for "softplus", whose scale the prior gives: a
    threshold may then reach zero without its coordinate running off to minus infinity on a
    new drive more than a few units.
    """

    name: str
    symbol: str
    unit: str
    meaning: str
    transform: Transform
    equation: str

    def to_coordinate(self, value: FloatArray, scale: float = 1.0) -> FloatArray:
        """Unconstrained coordinate of a physical value (any shape)."""
        if self.transform == "log":
            return np.asarray(np.log(value))
        if self.transform == "negative_log":
            return np.asarray(np.log(-np.asarray(value)))
        ratio = np.asarray(value, dtype=float) / scale
        with np.errstate(divide="ignore"):
            return np.where(ratio > 30.0, ratio, np.log(np.expm1(np.minimum(ratio, 30.0))))

    def from_coordinate(self, coordinate: FloatArray, scale: float = 1.0) -> FloatArray:
        """Physical value of an unconstrained coordinate (any shape)."""
        if self.transform == "log":
            return np.asarray(np.exp(coordinate))
        if self.transform == "negative_log":
            return np.asarray(-np.exp(coordinate))
        return np.asarray(scale * np.logaddexp(0.0, coordinate))


PARAMETERS: tuple[Parameter, ...] = (
    Parameter("K_F", "K_F", "Nm/rad", "flexspline cup stiffness", "log", "eq. 18"),
    Parameter("K_W", "K_W", "Nm/rad", "wave generator stiffness", "log", "eq. 20"),
    Parameter("a", "a", "1/rad", "growth of tooth-mesh stiffness with torque", "log", "eq. 17"),
    Parameter("b", "b", "Nm/rad", "tooth-mesh stiffness at no load", "log", "eq. 17"),
    Parameter("T_T", "T_T", "Nm", "torque at which all tooth pairs mesh", "softplus", "eq. 17"),
    Parameter("c", "c", "-", "fall of preload with torque (negative)", "negative_log", "eq. 16"),
    Parameter("T_i", "T_i", "Nm", "torque at which the preload is gone", "log", "eq. 16"),
    Parameter("mu", "μ", "-", "tooth friction coefficient", "log", "eq. 14"),
)
NAMES: tuple[str, ...] = tuple(parameter.name for parameter in PARAMETERS)
BY_NAME: Mapping[str, Parameter] = {parameter.name: parameter for parameter in PARAMETERS}


def in_support(parameters: Parameters, alpha: float) -> NDArray[np.bool_]:
    """Whether parameter values lie inside the hard support of the model.

    Outside it the slip envelopes stop being monotone in torque or the mesh locks itself:
    stiffnesses > 0, a >= 0, T_T >= 0, T_i >= 0, c < 0, 0 < mu < min(tan alpha, cot alpha)
    and sin alpha + mu (cos alpha + c) > 0.

    Returns a boolean array with the shape of the parameters.
    """
    values = {name: np.asarray(parameters[name]) for name in NAMES}
    mu, c, tangent = values["mu"], values["c"], math.tan(alpha)
    inside = (mu > 0) & (mu < min(tangent, 1 / tangent)) & (c < 0)
    inside = inside & (math.sin(alpha) + mu * (math.cos(alpha) + c) > 0)
    # What is no number is the least of any.
    inside = inside & (np.minimum(np.minimum(values["K_F"], values["K_W"]), values["b"]) > 0)
    inside = inside & (np.minimum(np.minimum(values["a"], values["T_T"]), values["T_i"]) >= 0)
    return np.asarray(inside)


def column(value: FloatArray) -> FloatArray:
    """A scalar or `(draws,)` array as `(draws, 1)`."""
    return np.reshape(np.asarray(value, dtype=np.float64), (-1, 1))
