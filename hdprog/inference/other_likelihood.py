"""Likelihood of a model other than the drive model on the same reduced record.

Everything but the model and its prior is inherited: blocks, noise, the offset and the noise scale
that are integrated out. A point holds the model's coordinates, each standard Gaussian a priori
(half of it for the weights of a nonnegative model).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.sampler import RidgePosterior
from hdprog.physics.other_models.base import (
    ModelParameter,
    OtherModel,
    Setting,
    Values,
    values_of,
)
from hdprog.physics.other_models.nonnegative import NonnegativeModel
from hdprog.physics.parameters import FloatArray


@dataclass(frozen=True)
class OtherLikelihood(LoopLikelihood):
    """Likelihood of the coordinates of a model other than the drive model.

    Attributes
    ----------
    model : the model
    setting : of the whole record, which the priors and elements of the model refer to
    """

    model: OtherModel = field(kw_only=True)
    setting: Setting = field(kw_only=True)
    ridge: ClassVar[bool] = False

    @cached_property
    def parameters(self) -> tuple[ModelParameter, ...]:
        """The model's parameters, in the order of a point's coordinates."""
        return self.model.parameters(self.setting)

    @cached_property
    def size(self) -> int:
        """Number of coordinates of a point."""
        return len(self.parameters)

    @cached_property
    def prior_mean(self) -> FloatArray:
        """(size,) zero."""
        return np.zeros(self.size)

    @cached_property
    def prior_sd(self) -> FloatArray:
        """(size,) one."""
        return np.ones(self.size)

    def values(self, points: FloatArray) -> Values:
        """Physical values by name, (draws, 1) each."""
        return values_of(self.parameters, points)

    @cached_property
    def design(self) -> FloatArray:
        """(blocks, size) derivatives of the angle in rad, of a nonnegative model."""
        assert isinstance(self.model, NonnegativeModel)
        scales = np.array([parameter.second for parameter in self.parameters])
        return np.asarray(self.model.features(self.reduced.path, self.setting) * scales)

    def angle(self, points: FloatArray) -> FloatArray:
        """Model angle without offset, (draws, blocks) in rad, at points (draws, size)."""
        if self.model.nonnegative:
            return np.asarray(points @ self.design.T)
        if self.size == 0:
            return np.zeros((len(points), self.reduced.path.torque.size))
        return self.model.angle(self.reduced.course, self.values(points), self.setting)

    def supported(self, points: FloatArray) -> NDArray[np.bool_]:
        """(draws,) whether points (draws, size) lie in the hard support of the model."""
        if self.size == 0:
            return np.ones(len(points), dtype=bool)
        with np.errstate(all="ignore"):
            return self.model.inside(self.values(points), self.setting)

    def log_prior(self, points: FloatArray) -> FloatArray:
        """(draws,) log prior density of points (draws, size), up to a constant."""
        return np.asarray(-0.5 * np.einsum("ij,ij->i", points, points))


@dataclass(frozen=True)
class PlainPosterior(RidgePosterior):
    """Log posterior density over the model's own coordinates."""

    def position(self, point: FloatArray) -> FloatArray:
        """Position (size,) of one point (size,): itself."""
        return point

    def _points(self, position: FloatArray) -> tuple[FloatArray, FloatArray]:
        return position, np.zeros(len(position))
