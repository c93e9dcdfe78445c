"""The report of a drive: one self-contained HTML page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import jinja2

from hdprog.config import ReportSettings
from hdprog.reporting import outlook
from hdprog.reporting.drive_name import drive_name, is_declared
from hdprog.reporting.figures.loop_panel import PanelScales, loop_panel
from hdprog.reporting.figures.loops_overlay import loops_overlay
from hdprog.reporting.figures.prior_posterior import prior_posterior
from hdprog.reporting.figures.ridge_pairs import ridge_pairs
from hdprog.reporting.figures.service_life import life_picture, trend_pictures
from hdprog.reporting.reader_units import shown_in
from hdprog.reporting.rounding import plain
from hdprog.reporting.sections import (
    changes,
    effects,
    effects_tables,
    facts,
    method,
    paper_method,
    provenance,
    rests_on,
    shrinkage,
    tests,
    warnings,
)
from hdprog.reporting.sections import remaining_life as life
from hdprog.reporting.sections.table import Table
from hdprog.reporting.style import Picture, house_style
from hdprog.reporting.temperature_words import temperature_words
from hdprog.reporting.verdict import verdict
from hdprog.reporting.words import capital, counted, quantity, tidy, torque_words
from hdprog.results import DriveResult, ParameterDraws, TestResult


@dataclass(frozen=True)
class Panel:
    """One test's picture with its heading."""

    title: str
    note: str
    doubtful: bool
    picture: Picture


def build_report(
    result: DriveResult,
    catalogue: Mapping[str, float] | None = None,
    spread: Callable[..., Iterable[Any]] = map,
) -> str:
    """Report of a drive as HTML, without anything to fetch and without scripts.

    Parameters
    ----------
    result : a run's, or a single fit's (no forecasts)
    catalogue : the maker's figures by their keys (e.g. `K1_Nm_per_rad`), shown beside the tests'
    spread : map over pictures that take long, e.g. an executor's
    """
    with house_style(), shown_in(result.drive.report):
        scales, settings = PanelScales.of(result.tests), result.drive.report
        last, count = result.tests[-1], len(result.tests)
        of_draws = spread(_of_draws, [prior_posterior, ridge_pairs], [last] * 2, [settings] * 2)
        panels = spread(_panel, result.tests, [scales] * count, [settings] * count)
        return _page(result, catalogue or {}, scales, of_draws, panels)


def _page(
    result: DriveResult,
    catalogue: Mapping[str, float],
    scales: PanelScales,
    of_draws: Iterable[Picture | None],
    panels: Iterable[Panel],
) -> str:
    """Report under the house style, in the reader's units."""
    main = outlook.overall(result.forecasts)
    pictures = {
        "life": life_picture(result),
        "trends": [
            (capital(outlook.limit_words(limit)), drawn) for limit, drawn in trend_pictures(result)
        ],
        "effects": effects.effects(result.explanation),
        "overlay": loops_overlay(result.tests, scales) if len(result.tests) > 1 else None,
        "panels": list(panels),
    }
    pictures["against_prior"], pictures["ridge"] = of_draws
    trend, said = result.trend, verdict(result)
    limited = [limit.key for limit in result.drive.limits]
    return (
        environment()
        .get_template("report.html")
        .render(
            **pictures,
            title=f"{drive_name(result)} – {said.label} – hdprog",
            name=drive_name(result),
            subtitle=_subtitle(result),
            single=len(result.tests) == 1,
            verdict=said,
            facts=facts.facts(result),
            warnings=warnings.warnings(result),
            waiting=None if main is None else life.waiting_table(result),
            loads=None if main is None else life.loads_table(result),
            limits=None if main is None else life.limits_table(result),
            overview=tests.overview(result),
            figures=tests.figures(result, catalogue),
            read_off=tests.read_off(result),
            changed=changes.changes(result),
            parameters=tests.parameters(result),
            asked_for=_asked_for(result),
            rests_on=rests_on.rests_on(result),
            paper=paper_method.paper_method(result.tests[-1]),
            diagnostics=tests.diagnostics(result),
            hyperparameters=None if trend is None else method.hyperparameters(trend),
            shrinkage=None if trend is None else shrinkage.shrinkage(trend),
            temperature="" if trend is None else temperature_words(trend, limited),
            method=method.method(result),
            words=_words(result),
            provenance=provenance.provenance(result.provenance),
        )
    )


@cache
def environment() -> jinja2.Environment:
    """Return the templates of all reports."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("hdprog.reporting"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
    )
    environment.filters["tidy"] = tidy
    return environment


def _of_draws(
    drawn: Callable[[TestResult, ParameterDraws], Picture],
    test: TestResult,
    settings: ReportSettings,
) -> Picture | None:
    """Picture of a test's draws; None where a result was kept without them."""
    with house_style(), shown_in(settings):  # a worker starts without them
        return None if test.draws is None else drawn(test, test.draws)


def _asked_for(result: DriveResult) -> Table | None:
    """Parameters of effects that were asked for; those that were found have their own section."""
    test = result.tests[-1]
    if result.explanation is not None:
        return None
    added, doubt = test.effect_summaries, not test.converged
    return effects_tables.parameter_table(added, " to the drive model", doubtful=doubt)


def _panel(test: TestResult, scales: PanelScales, settings: ReportSettings) -> Panel:
    parts = [f"Test {test.test_id}, {tests.when(test)}", test.event or ""]
    title = ", ".join(part for part in parts if part)
    with house_style(), shown_in(settings):  # a worker starts without them
        picture = loop_panel(test, scales)
    return Panel(title, test.note or "", not test.converged, picture)


def _subtitle(result: DriveResult) -> str:
    drive = result.drive
    parts = [drive.model or ""]
    if drive.ratio is not None:
        parts.append(f"ratio {plain(drive.ratio)}")
    if drive.rated_torque is not None:
        parts.append(f"rated torque {torque_words(drive.rated_torque)}")
    if not is_declared(drive):
        parts.append("drive not declared")
    parts.append(counted(len(result.tests), "test"))
    parts.append(f"report of {result.provenance.created[:10]}")
    return " · ".join(part for part in parts if part)


def _words(result: DriveResult) -> list[tuple[str, str]]:
    keys = dict.fromkeys(key.partition("@")[0] for test in result.tests for key in test.figures)
    named = [(capital(quantity(key).name), f"{capital(quantity(key).meaning)}.") for key in keys]
    return [(name, meaning) for name, meaning in named if meaning != "."]
