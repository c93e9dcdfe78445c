"""The error of a fit in words: before and after, on data left out, against what can be reached."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.explanation import DriveExplanation, ErrorFigures, Explanation
from hdprog.reporting.geometry import MICRORADIAN
from hdprog.reporting.pooled import pooled_errors, root_mean_square, tests_with
from hdprog.reporting.rounding import THIN_SPACE, significant
from hdprog.reporting.words import with_unit

LEFT_OUT = "on data left out of the fit"
_SAME = 0.02  # part by which an error has to change before it fell or grew
_ALIKE = 0.3  # correlation of neighbouring residuals from which structure remains
_AT = 1.2  # times noise or repeatability: an error up to that is down to it


@dataclass(frozen=True)
class Errors:
    """Errors in rad of a record, or of a drive's tests pooled (root mean square).

    Attributes
    ----------
    before, after : of the drive model alone, and with what was added
    floor : noise of the readings
    repeatability : how far the cycles of a record differ; None where it is not known of all tests
    added : something was added to the drive model
    tests : their number
    shown_in : how many of them have what was added, of several effects the one in most
    """

    before: ErrorFigures
    after: ErrorFigures
    floor: float
    repeatability: float | None
    added: bool
    tests: int = 1
    shown_in: int = 1


def errors(explanation: Explanation | DriveExplanation) -> Errors:
    """Errors of a record, or of a drive over its tests."""
    added = bool(explanation.effects)
    if isinstance(explanation, Explanation):
        return Errors(
            explanation.before,
            explanation.after,
            explanation.noise_floor_rad,
            explanation.repeatability_rad,
            added,
        )
    tests = explanation.tests
    return Errors(
        pooled_errors(tests, lambda test: test.before),
        pooled_errors(tests, lambda test: test.after),
        root_mean_square(test.noise_floor_rad for test in tests) or 0.0,
        _repeatability(tests),
        added,
        len(tests),
        max((len(tests_with(effect.id, tests)) for effect in explanation.effects), default=0),
    )


def _repeatability(tests: Sequence[Explanation]) -> float | None:
    own = [test.repeatability_rad for test in tests]
    return None if None in own else root_mean_square(own)


def micro(value: float | None) -> str:
    """Angle in rad as µrad, without the unit; an en dash for none."""
    return significant(None if value is None else MICRORADIAN * value, 2)


def _microradian(value: float) -> str:
    return with_unit(micro(value), "µrad")


def _change(before: float, after: float, added: bool) -> str:
    arrow = f"{THIN_SPACE}→{THIN_SPACE}"
    return with_unit(f"{micro(before)}{arrow}{micro(after)}" if added else micro(after), "µrad")


def before_and_after(found: Errors) -> str:
    """Error on the data fitted and on data left out, against the noise floor.

    "26 → 7.1 µrad on the data fitted and 29 → 7.4 µrad on data left out of the fit (noise floor
    7.0 µrad)"; one number each where nothing was added.
    """
    said = f"{_change(found.before.rmse_rad, found.after.rmse_rad, found.added)} on the data fitted"
    if _left_out(found) is not None:
        old, new = found.before.heldout_rmse_rad, found.after.heldout_rmse_rad
        said += f" and {_change(old, new, found.added)} {LEFT_OUT}"
    return f"{said} (noise floor {_microradian(found.floor)})"


def _left_out(found: Errors) -> float | None:
    """Error left on data left out, as a part of the one before; None where it is not known."""
    old, new = found.before.heldout_rmse_rad, found.after.heldout_rmse_rad
    return new / old if np.isfinite([old, new]).all() and old > 0 else None


def not_predicted(found: Errors) -> str | None:
    """Say that what was added gains nothing on data left out; None where it does gain."""
    ratio = _left_out(found)
    if not found.added or ratio is None or ratio < 1.0 - _SAME:
        return None
    grew = ratio > 1.0 + _SAME
    if found.shown_in > 1 and not grew:
        return (
            f"{LEFT_OUT.capitalize()} the error hardly fell: one record by itself hardly tells "
            f"what was added, but {found.shown_in} of {found.tests} tests show it."
        )
    return (
        f"{LEFT_OUT.capitalize()} the error {'grew' if grew else 'hardly fell'}: what was added "
        "describes these readings and does not predict others, so do not rely on it until another "
        "record shows it too."
    )


def against_cycles(found: Errors) -> str | None:
    """Compare what is left with how far cycles differ; None where that is not known."""
    own = found.repeatability
    if own is None:
        return None
    whose = "The cycles of this record" if found.tests == 1 else "The cycles of one test"
    said = f"{whose} repeat to {_microradian(own)}"
    fitted, held = found.after.rmse_rad, found.after.heldout_rmse_rad
    most = float(np.nanmax([fitted, held]))
    left = f"{_microradian(most)} is left"
    if most <= _AT * found.floor:
        return f"{said}; {left}, which the noise accounts for: nothing more can be explained."
    if _AT * most < own:
        # Cycles that differ by more than the error are followed one by one, and are no measure.
        return (
            f"{said}; {left}: the fit follows what differs between cycles, so that the noise of "
            f"{_microradian(found.floor)} is the measure of what is left."
        )
    if most <= _AT * own:
        said += f"; {left}: nothing more that comes back in every cycle can be explained"
        if found.after.lag1 < _ALIKE:
            return f"{said}."
        return f"{said}. Neighbouring readings are still alike: what is left differs by cycle."
    if fitted <= _AT * max(own, found.floor):
        return f"{said}; the fit comes as close as that, but not {LEFT_OUT}."
    return f"{said}; {_microradian(fitted)} is left: part of it is still unexplained."


def accounted_for(found: Errors) -> bool:
    """Whether noise, or a scatter of the record's own cycles, accounts for what is left."""
    left = found.after.rmse_rad
    return left <= _AT * found.floor or (
        left <= _AT * (found.repeatability or 0.0) and found.after.lag1 < _ALIKE
    )


def above_noise(found: Errors) -> str | None:
    """How far what is left is above the noise; None where it is down to it."""
    if down_to_noise(found) or not found.floor > 0:
        return None
    times = significant(found.after.rmse_rad / found.floor, 2)
    return f"What is left is still {times} times the noise: part of it is unexplained."


def down_to_noise(found: Errors) -> bool:
    """Whether no more than noise is left on the data fitted."""
    return _is_noise(found.after, found.floor)


def unexplained_alone(tests: Sequence[Explanation]) -> list[Explanation]:
    """Tests with effects on which the drive model alone leaves more than noise.

    What a drive's tests have in common is added to those, too, that do not show it.
    """
    return [
        test for test in tests if test.effects and not _is_noise(test.before, test.noise_floor_rad)
    ]


def _is_noise(left: ErrorFigures, floor: float) -> bool:
    return left.rmse_rad <= _AT * floor
