"""The numbers behind a figure's trend: tests, fan and the hours at which its limit is passed."""

from __future__ import annotations

import numpy as np

from hdprog.reporting.crossing_density import crossing_density
from hdprog.reporting.geometry import few
from hdprog.reporting.picture_data import Cell, PictureData
from hdprog.reporting.words import quantity
from hdprog.results import LEVELS, FigureTrend, Forecast

_MOST_ROWS = 150


def trend_numbers(trend: FigureTrend, forecast: Forecast) -> PictureData:
    """Tests, then the fan, then the density of the crossing, as one table.

    Parameters
    ----------
    trend : of the figure, in the reader's unit
    forecast : of its limit
    """
    levels = [f"{100 * level:g} %" for level in LEVELS]
    rows: list[tuple[Cell, ...]] = []
    for what, at, quantiles in (
        ("test by itself", trend.test_hours, trend.test_quantiles),
        ("state", trend.hours, trend.quantiles),
    ):
        chosen = few(at.size, _MOST_ROWS)
        rows += [(what, float(at[i]), *map(float, quantiles[:, i]), None) for i in chosen]
    hours_ = np.linspace(forecast.now_hours, forecast.horizon_hours, _MOST_ROWS)
    density = crossing_density(forecast, hours_)
    blank = (None,) * len(levels)
    rows += [
        ("limit passed", at, *blank, value)
        for at, value in zip(hours_.tolist(), density.tolist(), strict=True)
    ]
    named = quantity(trend.key)
    head = ("what", "service hours", *(f"{level} [{named.unit}]" for level in levels))
    return PictureData.of(f"trend-{trend.key}", (*head, "density [1/h]"), rows)
