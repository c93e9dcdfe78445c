"""Models that are sums of given courses with weights that must not be negative.

The courses follow from the torque's history alone, so that angle = features · weights: nonnegative
least squares identifies the weights, and their posterior is a Gaussian cut off at zero. What the
elements had seen before the record is one of three states, chosen by least squares: after a fall
from high torque, never loaded, after a rise from low torque.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.course import Course
from hdprog.physics.other_models.base import ModelParameter, OtherModel, Setting, Values
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

History = Literal[-1, 0, 1]
HISTORIES: tuple[History, ...] = (0, 1, -1)
"""Never loaded; after a rise from low torque; after a fall from high torque."""


@dataclass(frozen=True)
class NonnegativeModel(OtherModel):
    """A model that is linear in nonnegative weights.

    Attributes
    ----------
    history : what came before the record
    """

    history: History = 0
    nonnegative = True

    def after(self, history: History) -> Self:
        """The same model behind another history."""
        return replace(self, history=history)

    @abstractmethod
    def features(self, path: TorquePath, setting: Setting) -> FloatArray:
        """Courses (samples, weights) that the weights multiply."""

    def angle(self, course: Course, values: Values, setting: Setting) -> FloatArray:
        """See `OtherModel.angle`."""
        weights = np.hstack([values[one.name] for one in self.parameters(setting)])
        return np.asarray(weights @ self.features(course.path, setting).T)

    def inside(self, values: Values, setting: Setting) -> NDArray[np.bool_]:
        """No weight is negative."""
        return np.asarray(np.hstack(list(values.values())).min(axis=1) >= 0.0)


def weight(name: str, unit: str, meaning: str, typical: float) -> ModelParameter:
    """A weight with a half-normal prior: the coordinate's Gaussian, cut off at zero."""
    return ModelParameter(name, unit, meaning, "normal", 0.0, typical)


def ramps(torque: FloatArray, edges: FloatArray) -> FloatArray:
    """Torque's share in each interval between edges, counted from zero: (samples, edges − 1)."""
    low, high = edges[:-1], edges[1:]
    at_zero = np.clip(0.0, low, high) - low
    return np.asarray(np.clip(torque[:, None], low, high) - low - at_zero)


def spread(count: int, largest: float, bend: float) -> FloatArray:
    """(count + 1,) edges from −largest to largest, denser about zero for a bend above 1."""
    even = np.linspace(-1.0, 1.0, count + 1)
    return np.asarray(largest * np.sign(even) * np.abs(even) ** bend)
