"""The report of a backtest: one self-contained HTML page."""

from __future__ import annotations

from hdprog.forecast.backtest import INTERVALS
from hdprog.forecast.backtest_pool import (
    FEW,
    BacktestResult,
    DriveScores,
    crossing_courses,
    crossing_coverage,
    distinct_crossings,
    figure_coverage,
)
from hdprog.reporting.backtest_words import crossings, figures, verdict
from hdprog.reporting.figures.backtest_accuracy import accuracy
from hdprog.reporting.figures.backtest_coverage import CoverageRow, coverage
from hdprog.reporting.figures.backtest_intervals import forecast_intervals
from hdprog.reporting.figures.backtest_transforms import transforms
from hdprog.reporting.sections import backtest as tables
from hdprog.reporting.sections.section import Section
from hdprog.reporting.sections_page import sections_page
from hdprog.reporting.style import house_style
from hdprog.reporting.words import counted

_DRAWN = 12
"""Drives whose forecasts are drawn one by one, so that the file stays small."""


def build_backtest_report(result: BacktestResult) -> str:
    """Report of a backtest as HTML, without anything to fetch and without scripts."""
    said = verdict(result)
    with house_style():
        sections = [_forecasts(result), _honesty(result), _accuracy(result), _later(result)]
    fleet = len(result.drives) > 1
    name = result.name if fleet else result.drives[0].drive_id
    own = [] if name == result.drives[0].name else [result.drives[0].name]
    parts = [
        *([counted(len(result.drives), "drive")] if fleet else own),
        counted(sum(drive.tests for drive in result.drives), "test"),
    ]
    return sections_page(
        name,
        parts,
        said,
        tables.warnings(result),
        sections,
        tables.method(result),
        result.provenance,
        command="hdprog backtest",
    )


def _forecasts(result: BacktestResult) -> Section:
    """Every forecast against what came later."""
    fleet = len(result.drives) > 1
    drawn = sorted(result.drives, key=_missed, reverse=True)[:_DRAWN]
    pictures = [
        (drive.name if fleet else "", found)
        for drive in result.drives
        if drive in drawn and (found := forecast_intervals(drive)) is not None
    ]
    said = [tables.what_came(result)]
    if len(result.drives) > _DRAWN:
        said.append(
            f"Drawn are the {_DRAWN} drives whose forecasts missed most; backtest.json has all."
        )
    below = [tables.by_drive(result)] if fleet else []
    if crossings(result.drives):
        below.append(tables.by_known(result))
    return Section(
        "forecasts",
        "Forecasts against what came later",
        paragraphs=tuple(said),
        pictures=tuple(pictures),
        tables=tuple(below),
    )


def _missed(drive: DriveScores) -> int:
    return sum(not score.held[0.9] for score in drive.crossings)


def _honesty(result: BacktestResult) -> Section:
    """Whether intervals held as often as they should, and where what came fell in them."""
    scores, nearest = crossings(result.drives), figures(result.drives, ahead=1)
    many = distinct_crossings(result.drives) >= FEW
    rows = [
        CoverageRow(name, found, judged)
        for level in INTERVALS
        for name, found, judged in (
            ("crossings", crossing_coverage(scores, level), many),
            ("next test's figures", figure_coverage(nearest, level), len(nearest) >= FEW),
            ("all later tests'", figure_coverage(figures(result.drives), level), False),
        )
        if found is not None
    ]
    pictures = [coverage(rows)] if rows else []
    hits = [[score.transform for score in group] for group in (scores, nearest)]
    if any(hits):
        pictures.append(transforms(hits[0], hits[1], distinct_crossings(result.drives)))
    return Section(
        "honesty",
        "Did intervals hold as often as they should?",
        pictures=tuple(("", one) for one in pictures),
        tables=(tables.coverages(rows),) if rows else (),
    )


def _accuracy(result: BacktestResult) -> Section:
    """How near the forecasts came, from test to test."""
    courses = crossing_courses(result.drives)
    found = accuracy(courses)
    if found is None:
        said = ("No crossing was seen, so that there is no remaining life to compare with.",)
        return Section("accuracy", "How near, how early?", paragraphs=said)
    table = tables.accuracies(courses, fleet=len(result.drives) > 1)
    return Section("accuracy", "How near, how early?", pictures=(("", found),), tables=(table,))


def _later(result: BacktestResult) -> Section:
    """How well the figures of later tests were predicted."""
    scores = figures(result.drives)
    if not scores:
        said = ("There is no later test to predict.",)
        return Section("later", "Figures of later tests", paragraphs=said)
    return Section("later", "Figures of later tests", tables=(tables.skills(scores),))
