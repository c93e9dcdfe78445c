"""The numbers of a picture as a file: what was drawn, safe to open, small."""

from __future__ import annotations

import csv
import io
from urllib.parse import unquote

import numpy as np
import pytest

from hdprog.reporting.build import build_report
from hdprog.reporting.crossing_density import crossing_density
from hdprog.reporting.picture_data import PictureData, file_name
from tests.reporting import drives, explanations
from tests.reporting.page import Page


def read(uri: str) -> list[list[str]]:
    head, _, content = uri.partition(",")
    assert head == "data:text/csv;charset=utf-8"
    return list(csv.reader(io.StringIO(unquote(content))))


def test_a_file_reads_back_to_its_digits() -> None:
    data = PictureData.of("t01", ("a [Nm]", "b, c"), [(1.23456789, "x,y"), (None, '"z"')])
    assert read(data.uri) == [["a [Nm]", "b, c"], ["1.23457", "x,y"], ["", '"z"']]


def test_long_records_are_thinned_to_the_ends() -> None:
    values = np.arange(5000.0)
    data = PictureData.along("t01", ("reading",), values, most=100)
    assert (len(data.rows), data.left_out) == (100, 4900)
    assert data.rows[0] == (0.0,)
    assert data.rows[-1] == (4999.0,)


def test_no_cell_runs_as_a_formula_and_no_name_is_a_path() -> None:
    hostile = '=HYPERLINK("x")'
    assert read(PictureData.of("x", ("a",), [(hostile,)]).uri)[1] == ["'" + hostile]
    assert file_name("../../etc/x y@14Nm") == "etc-x-y-14Nm.csv"
    assert file_name("") == "picture.csv"


def test_every_picture_of_a_drive_gives_its_numbers() -> None:
    for result in (drives.wearing(drives.LOST_MOTION, drives.SECANT), explanations.of_drive()):
        page = Page(build_report(result))
        files = [attributes for tag, attributes in page.tags if "download" in attributes]
        assert len(files) == len(page.pictures)
        names = [str(attributes["download"]) for attributes in files]
        assert len(set(names)) == len(names)
        for attributes in files:
            rows = read(str(attributes["href"]))
            assert len(rows) > 2
            assert {len(row) for row in rows} == {len(rows[0])}


def test_a_panels_file_holds_the_residual_that_is_drawn() -> None:
    result = drives.single_fit()
    page = Page(build_report(result))
    [href] = [str(a["href"]) for tag, a in page.tags if a.get("download") == "t01-loop.csv"]
    head, *rows = read(href)
    column = head.index("residual [µrad]")
    fit = result.tests[0].fit
    chosen = np.isin(fit.position, [float(row[0]) for row in rows])
    assert chosen.sum() == len(rows)
    np.testing.assert_allclose(
        [float(row[column]) for row in rows], 1e6 * fit.residual[chosen], rtol=1e-5
    )


def test_the_density_holds_what_crosses_between_now_and_the_horizon() -> None:
    rng = np.random.default_rng(4)
    draws = 3000.0 + 800.0 * rng.standard_normal(20_000)
    draws[:4000] = np.inf
    forecast = drives.forecast_of(drives.LOST_MOTION, draws, now=900.0)
    hours = np.linspace(0.0, 25_000.0, 20_001)
    density = crossing_density(forecast, hours)
    table = forecast.crossing_probability
    area = float(np.sum(density) * (hours[1] - hours[0]))
    assert abs(area - (table[-1, 1] - table[0, 1])) < 0.01
    assert not density[hours < 900.0].any()
    assert abs(hours[np.argmax(density)] - 3000.0) < 250.0


def test_a_density_that_goes_on_past_the_horizon_does_not_bend_down_there() -> None:
    """A third crosses, evenly over the hours and past the horizon."""
    draws = np.linspace(900.0, 60_000.0, 6000)
    forecast = drives.forecast_of(drives.LOST_MOTION, draws, now=900.0)
    horizon = forecast.crossing_probability[-1, 0]
    hours = np.linspace(900.0, horizon, 20_001)
    density = crossing_density(forecast, hours)
    crossed = forecast.crossing_probability[-1, 1] - forecast.crossing_probability[0, 1]
    assert abs(float(np.mean(density)) * (horizon - 900.0) - crossed) < 0.01 * crossed
    assert density[-1] == pytest.approx(1.0 / 59_100.0, rel=0.25)


def test_nothing_crossing_has_no_density() -> None:
    never = drives.forecast_of(drives.LOST_MOTION, np.full(100, np.inf), now=900.0)
    assert not crossing_density(never, np.linspace(900.0, 20_000.0, 50)).any()
