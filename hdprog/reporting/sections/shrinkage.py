"""What other drives of the fleet told, and how far this drive was pulled towards them."""

from __future__ import annotations

from hdprog.reporting.rounding import percent
from hdprog.reporting.sections.table import Row, Table, Value
from hdprog.reporting.words import agree, counted, listed, spoken
from hdprog.results import SteadyShare, TrendSummary


def shrinkage(trend: TrendSummary) -> Table | None:
    """Hyperparameters from any drive over the fleet to this drive; None without a fleet."""
    fleet = trend.fleet
    if fleet is None:
        return None
    rows = [
        Row(
            spoken(name),
            (
                Value.of(one.shipped),
                Value.of(one.fleet),
                Value.of(one.own),
                Value.of(trend.hyperparameters[name]),
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
    caption += " " + _steady(fleet.steady, many)
    if fleet.left_out:
        left = len(fleet.left_out)
        caption += f" {counted(left, 'run')} {agree(left, 'was', 'were')} left out: " + "; ".join(
            fleet.left_out
        )
    columns = ("hyperparameter", "any drive", "this fleet", "this drive without it", "this drive")
    return Table.flat(caption, columns, rows, doubtful=not trend.converged)


def _steady(found: SteadyShare | None, many: int) -> str:
    if found is None:
        return (
            "None of these runs tells whether its drive's pace was steady: they were made by an "
            "older version. Past the last test this drive's pace therefore wanders and rises as "
            "that of any drive; run the others again to let them say."
        )
    told = ""
    if found.told < many:
        told = f" Only {found.told} of them {agree(found.told, 'tells', 'tell')} of it."
    return (
        "A pace is steady where wear follows a power of the hours and nothing else, neither now "
        f"nor past the last test. The fleet gives this drive's pace a chance of "
        f"{percent(found.fleet)} to be steady; with the drive's own tests the chance is "
        f"{percent(found.own)}. Where it is not steady, it wanders like that of any drive." + told
    )
