"""Error figures of a fit over the recorded samples."""

from __future__ import annotations

import numpy as np

from hdprog.discovery.heldout import HeldOut
from hdprog.explanation import ErrorFigures
from hdprog.inference.prepare import Prepared
from hdprog.physics.parameters import FloatArray

_WINDOW = 0.05  # of the torque span, after a reversal


def error_figures(prepared: Prepared, residual: FloatArray, held: HeldOut) -> ErrorFigures:
    """Figures of one fit; readings set aside as isolated spikes are left out.

    Parameters
    ----------
    prepared : the record
    residual : (samples,) in rad
    held : of the same model
    """
    kept, course = prepared.kept, prepared.record_course
    turned = np.arange(kept.size) >= (course.path.ends[0] if course.path.starts.size > 1 else 0)
    near = kept & turned & (course.travel <= _WINDOW * float(np.ptp(course.path.torque)))
    near &= course.path.starts.size > 1
    pairs = kept[1:] & kept[:-1]
    return ErrorFigures(
        rmse_rad=_rms(residual[kept]),
        heldout_rmse_rad=held.rmse,
        reversal_rmse_rad=_rms(residual[near]) if near.any() else None,
        lag1=float(np.corrcoef(residual[1:][pairs], residual[:-1][pairs])[0, 1]),
    )


def branch_rmse(
    prepared: Prepared, before: FloatArray, after: FloatArray
) -> dict[str, tuple[float, float]]:
    """Root mean square before and after on rising and on falling torque, in rad."""
    direction = prepared.record_course.path.direction
    named = {"rising": direction > 0, "falling": direction < 0}
    return {
        name: (_rms(before[here & prepared.kept]), _rms(after[here & prepared.kept]))
        for name, here in named.items()
        if (here & prepared.kept).any()
    }


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
