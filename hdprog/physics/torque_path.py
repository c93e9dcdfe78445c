"""A torque history split into stretches on which torque only rises or only falls."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hdprog.errors import BadInputError
from hdprog.physics.parameters import FloatArray


@dataclass(frozen=True)
class TorquePath:
    """Torque samples and the stretches between reversals.

    Attributes
    ----------
    torque : (samples,) torque in order of time, in Nm; (draws, samples) where an error of its
        sensor is taken out draw by draw
    starts : (stretches,) index of the first sample of each stretch; the first is 0
    rising : (stretches,) whether torque rises on the stretch
    variance : (samples,) variance of torque inside the block that a sample stands for [Nm²],
        or None where each sample is one reading
    reversal_torque : (stretches,) torque reached at the end of each stretch in Nm, or None where
        the last sample of the stretch is that torque; (draws, stretches) with such a torque
    """

    torque: FloatArray
    starts: NDArray[np.intp]
    rising: NDArray[np.bool_]
    variance: FloatArray | None = None
    reversal_torque: FloatArray | None = None

    @cached_property
    def ends(self) -> NDArray[np.intp]:
        """(stretches,) index behind the last sample of each stretch."""
        return np.append(self.starts[1:], self.torque.shape[-1])

    @cached_property
    def reached(self) -> FloatArray:
        """(stretches,) torque at the end of each stretch in Nm; (draws, stretches) by draw."""
        if self.reversal_torque is None:
            return np.asarray(self.torque[..., self.ends - 1])
        return self.reversal_torque

    @cached_property
    def began(self) -> FloatArray:
        """(stretches,) torque at which each stretch begins in Nm; (draws, stretches) by draw."""
        first = self.torque[..., :1]
        return np.concatenate([first, self.reached[..., :-1]], axis=-1)

    @cached_property
    def direction(self) -> FloatArray:
        """(samples,) +1 on rising and −1 on falling stretches."""
        return np.repeat(np.where(self.rising, 1.0, -1.0), self.lengths)

    @cached_property
    def pushing(self) -> FloatArray:
        """Torque along the direction of travel at all places that bound the slip, in Nm.

        (samples + stretches + 2,): the samples, the stretches' ends, and the first sample as if
        torque rose and as if it fell; (draws, …) where torque is by draw.
        """
        at = np.concatenate([self.torque, self.reached, self.torque[..., [0, 0]]], axis=-1)
        turned = np.where(self.rising, 1.0, -1.0)
        return np.asarray(at * np.concatenate([self.direction, turned, [1.0, -1.0]]))

    @cached_property
    def pushing_basis(self) -> FloatArray:
        """The `line_basis` of `pushing`."""
        return line_basis(self.pushing)

    def parted(self, pushing: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """What bounds a play at the places of `pushing`, (draws, places), taken apart.

        Returns
        -------
        (draws, samples) along the path and (draws, stretches) at the stretches' ends, both along
        the direction of travel, and (draws,) lower and upper bound at the first sample
        """
        samples = self.torque.shape[-1]
        return pushing[:, :samples], pushing[:, samples:-2], pushing[:, -2], -pushing[:, -1]

    @cached_property
    def lengths(self) -> NDArray[np.intp]:
        """(stretches,) number of samples on each stretch."""
        return np.asarray(self.ends - self.starts)

    @cached_property
    def magnitude(self) -> FloatArray:
        """|torque| in Nm."""
        return np.abs(self.torque)

    @cached_property
    def largest(self) -> float:
        """Largest magnitude in Nm."""
        return float(self.magnitude.max())

    @cached_property
    def sign(self) -> FloatArray:
        """Sign of torque; zero where that is zero."""
        return np.asarray(np.sign(self.torque))

    @cached_property
    def torque_and_sign(self) -> FloatArray:
        """(2, samples) torque in Nm and its sign."""
        return np.stack([self.torque, self.sign])

    @cached_property
    def half_width(self) -> FloatArray:
        """(samples,) half of the torque that each block spans, taken as even, in Nm."""
        assert self.variance is not None
        return np.asarray(np.sqrt(3 * self.variance))

    @cached_property
    def around_zero(self) -> NDArray[np.intp]:
        """Indices of blocks that come at least half of the way from their middle to zero."""
        near = self.is_around_zero(self.torque, self.half_width)
        return np.flatnonzero(near if near.ndim == 1 else near.any(axis=0))

    @cached_property
    def reach_around_zero(self) -> float:
        """Largest magnitude that blocks around zero torque come to in Nm; 0 without such blocks."""
        if self.variance is None or self.around_zero.size == 0:
            return 0.0
        at = self.around_zero
        return float(np.max(self.magnitude[..., at] + self.half_width[at]))

    @cached_property
    def worked_out(self) -> dict[str, FloatArray]:
        """Kept between calls: what others have worked out along this path, by its name."""
        return {}

    @staticmethod
    def is_around_zero(torque: FloatArray, half_width: FloatArray) -> NDArray[np.bool_]:
        """Whether blocks of so much torque to both sides of their middle are around zero."""
        return np.asarray(2 * half_width > np.abs(torque))

    @staticmethod
    def exact(torque: FloatArray) -> TorquePath:
        """Split at every change of direction of the samples themselves.

        Parameters
        ----------
        torque : (samples,) in Nm

        Raises
        ------
        BadInputError
            if torque is not a one-dimensional finite series
        """
        try:
            values = np.ascontiguousarray(torque, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise BadInputError(
                found=f"a torque history that is not all numbers ({error})",
                where="argument torque",
                expected="a non-empty one-dimensional series of finite numbers in Nm",
                advice="convert the values to numbers first",
            ) from error
        if np.ma.is_masked(torque):  # what is masked is no reading
            values = np.where(np.ma.getmaskarray(torque), np.nan, values)
        if values.ndim != 1 or values.size == 0 or not np.isfinite(values).all():
            raise BadInputError(
                found=f"a torque history of shape {values.shape}"
                + ("" if np.isfinite(values).all() else " with values that are not finite"),
                where="argument torque",
                expected="a non-empty one-dimensional series of finite numbers in Nm",
                advice="pass torque in the order of time, one number a sample",
            )
        step = np.sign(np.diff(values))
        moved = np.flatnonzero(step)
        if moved.size == 0:
            return TorquePath(values, np.array([0]), np.array([True]))
        turned = moved[1:][step[moved[1:]] != step[moved[:-1]]]
        starts = np.concatenate([[0], turned + 1])
        rising = np.concatenate([[step[moved[0]]], step[turned]]) > 0
        return TorquePath(values, starts, rising)


def line_basis(pushed: FloatArray) -> FloatArray:
    """u, |u| and 1: (3, samples) of (samples,) u, (draws, 3, samples) of (draws, samples)."""
    return np.stack([pushed, np.abs(pushed), np.ones_like(pushed)], axis=-2)
