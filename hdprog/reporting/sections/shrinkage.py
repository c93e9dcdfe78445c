"""What other drives of the fleet told, and how far this drive was pulled towards them."""

from __future__ import annotations

from collections.abc import Mapping

from hdprog.reporting.rounding import interval
from hdprog.reporting.sections.table import Cell, Row, Table, Value
from hdprog.reporting.words import agree, counted, listed, spoken
from hdprog.results import TrendSummary


def shrinkage(trend: TrendSummary) -> Table | None:
    """Hyperparameters from any drive over the fleet to this drive; None without a fleet."""
    fleet = trend.fleet
    if fleet is None:
        return None
    rows = [
        Row(
            spoken(name),
            (
                _spread(one.shipped),
                _spread(one.fleet),
                _spread(one.own),
                _spread(trend.hyperparameters[name]),
            ),
        )
        for name, one in fleet.hyperparameters.items()
    ]
    many = len(fleet.drives)
    caption = (
        f"Learnt from the finished runs of {counted(many, 'other drive')}: "
        f"{listed(list(fleet.drives))}. Median, below it the 90 % interval. The fleet's column "
        "is this drive's prior; its own tests move it from there, little where they say little. "
        "Beside it: what they would have made of the prior of any drive."
    )
    if fleet.left_out:
        left = len(fleet.left_out)
        caption += f" {counted(left, 'run')} {agree(left, 'was', 'were')} left out: " + "; ".join(
            fleet.left_out
        )
    columns = ("hyperparameter", "any drive", "this fleet", "this drive without it", "this drive")
    return Table.flat(caption, columns, rows, doubtful=not trend.converged)


def _spread(levels: Mapping[float, float]) -> Cell:
    low, middle, high = interval(levels[0.05], levels[0.50], levels[0.95])
    return Value(middle, f"{low} to {high}")
