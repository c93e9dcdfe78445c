"""The numbers of a picture that has no table of its own: its lines and marks as they are drawn."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from hdprog.reporting.geometry import few
from hdprog.reporting.picture_data import Cell, PictureData

_MOST_POINTS = 150  # of each line
_LEAST_POINTS = 3  # fewer are rulers and marks of a reading


def drawn_lines(figure: Figure, name: str) -> PictureData | None:
    """Every line and cloud of marks as rows of x and y; None where nothing is drawn by lines.

    Parameters
    ----------
    figure : as drawn, in the reader's units
    name : of the file
    """
    rows: list[tuple[Cell, ...]] = []
    for number, axes in enumerate(figure.axes, start=1):
        panel = axes.get_title(loc="left") or axes.get_ylabel() or f"panel {number}"
        for order, line in enumerate(axes.lines, start=1):
            x, y = (np.asarray(values, dtype=float) for values in line.get_data())
            if x.size < _LEAST_POINTS:
                continue
            label = str(line.get_label())
            series = f"line {order}" if label.startswith("_") else label
            rows += [(panel, series, float(x[i]), float(y[i])) for i in few(x.size, _MOST_POINTS)]
    if not rows:
        return None
    return PictureData.of(name, ("panel", "line", "x", "y"), rows)
