"""One recorded loop of torque and torsion angle, validated and immutable."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hdprog.data.noise_level import noise_sd
from hdprog.errors import BadInputError

__all__ = ["Loop"]

_CHANNELS = {
    "torque": "Nm",
    "angle": "rad",
    "time": "s",
    "temperature": "°C",
    "output_angle": "rad",
}


@dataclass(frozen=True, eq=False, repr=False)
class Loop:
    """Torque and torsion angle in the order of recording, in SI.

    All arrays have shape (n,), are float64 copies and cannot be written to. Given arrays may be
    any one-dimensional sequence of numbers.

    Parameters
    ----------
    torque : ndarray
        Output torque [Nm], signed.
    angle : ndarray
        Torsion angle [rad] with the input locked; its zero is arbitrary.
    time : ndarray or None
        Time [s]; kept so that the first sample is at 0. Where stamps repeat the order of rows is
        all that is known: ``time`` is then None and a warning says so.
    temperature : ndarray or None
        Temperature [°C].
    output_angle : ndarray or None
        Absolute output position [rad].
    source : str
        Name of the file, or where else the record comes from.
    sha256 : str
        Digest of the file's bytes, empty for a record that comes from no file.
    warnings : tuple of str
        What a user of the record should know, in plain words.
    unread : tuple of str
        Headers of the file's columns that nothing was read from.

    Raises
    ------
    BadInputError
        Arrays of unequal length or of another shape, values that are not finite numbers, or
        times that run backwards.
    """

    torque: NDArray[np.float64]
    angle: NDArray[np.float64]
    time: NDArray[np.float64] | None = None
    temperature: NDArray[np.float64] | None = None
    output_angle: NDArray[np.float64] | None = None
    source: str = "record"
    sha256: str = ""
    warnings: tuple[str, ...] = ()
    unread: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in _CHANNELS:
            values = getattr(self, name)
            if values is not None:
                object.__setattr__(self, name, self._checked(name, values))
        object.__setattr__(self, "warnings", tuple(self.warnings))
        if self.time is not None:
            self._settle_time(self.time)

    def _checked(self, name: str, values: ArrayLike) -> NDArray[np.float64]:
        where = f"{self.source}, {name}"
        self._refuse_dates(values, where)
        try:
            array = np.array(values, dtype=np.float64)
            if np.ma.is_masked(values):
                array[np.ma.getmask(values)] = np.nan  # what is masked is no reading
        except (TypeError, ValueError) as error:
            raise BadInputError(
                f"values that are not all numbers ({error})",
                where,
                f"one number [{_CHANNELS[name]}] a sample",
                "Convert the values to numbers first.",
            ) from error
        if array.ndim != 1 or array.size == 0:
            raise BadInputError(
                f"an array of shape {array.shape}",
                where,
                "a one-dimensional array with at least one sample",
                "Pass one value a sample, in the order of recording.",
            )
        if array.size != np.size(self.torque):
            raise BadInputError(
                f"{array.size} samples",
                where,
                f"{np.size(self.torque)} samples, as many as there are torques",
                "Pass arrays that belong to the same samples.",
            )
        finite = np.isfinite(array)
        if not finite.all():
            first = int(np.argmin(finite))
            raise BadInputError(
                f"{array[first]} at sample {first + 1}",
                where,
                "a finite number in every sample",
                "Leave the sample out, or measure it again.",
            )
        array.setflags(write=False)
        return array

    def _refuse_dates(self, values: ArrayLike, where: str) -> None:
        """Refuse dates and spans of time, which would become a count in a unit of their own."""
        # A pandas series of dates in a time zone says so itself, and becomes plain objects.
        kind = getattr(values, "dtype", None) or np.asarray(values).dtype
        if kind.kind in "mM":
            raise BadInputError(
                f"values of type {kind}",
                where,
                "numbers; of times, seconds",
                "Convert times t to seconds first, with (t - t[0]) / numpy.timedelta64(1, 's').",
            )

    def _settle_time(self, time: NDArray[np.float64]) -> None:
        steps = np.diff(time)
        if (steps < 0).any():
            first = int(np.argmax(steps < 0))
            raise BadInputError(
                f"{time[first + 1]:.9g} s at sample {first + 2} after {time[first]:.9g} s",
                f"{self.source}, time",
                "times that do not run backwards",
                "Put the samples in the order of recording, or leave the time out.",
            )
        repeated = int(np.count_nonzero(steps == 0))
        if repeated:
            object.__setattr__(self, "time", None)
            warning = (
                f"{repeated} of {time.size} times repeat the one before, so the record is taken "
                "as untimed, in the order of its rows: nothing that depends on time (creep, "
                "viscous friction, loading rate) can be told from it."
            )
            object.__setattr__(self, "warnings", (*self.warnings, warning))
            return
        shifted = time - time[0]
        shifted.setflags(write=False)
        object.__setattr__(self, "time", shifted)

    @cached_property
    def torque_scatter(self) -> float:
        """Standard deviation of the torque's noise about its smooth course [Nm], see `noise_sd`.

        Found once: in a long record it takes its time, and several judges ask for it.
        """
        return noise_sd(self.torque, self.time)

    @cached_property
    def angle_scatter(self) -> float:
        """The same of the angle [rad]."""
        return noise_sd(self.angle, self.time)

    def __len__(self) -> int:
        """Return the number of samples."""
        return int(self.torque.size)

    def __repr__(self) -> str:
        """Return what the record is, for a notebook; its arrays would fill pages."""
        also = [name for name in _CHANNELS if getattr(self, name) is not None][2:]
        return (
            f"<Loop {self.source!r}: {len(self)} samples, torque {self.torque.min():.4g} to "
            f"{self.torque.max():.4g} Nm, angle {self.angle.min():.4g} to {self.angle.max():.4g} "
            f"rad{''.join(f', {name}' for name in also)}; {len(self.warnings)} warnings>"
        )

    def __setstate__(self, state: dict[str, Any]) -> None:
        # Pickling forgets that an array is read-only.
        for name in _CHANNELS:
            if state[name] is not None:
                state[name].setflags(write=False)
        self.__dict__.update(state)

    def with_warnings(self, warnings: Iterable[str]) -> Loop:
        """Return the same record with these warnings added, each once."""
        added = dict.fromkeys((*self.warnings, *warnings))
        return replace(self, warnings=tuple(added))
