"""Tables of remaining life: each limit, and what waiting costs."""

from __future__ import annotations

from hdprog.reporting import outlook
from hdprog.reporting.end_of_wear_words import end_of_wear
from hdprog.reporting.rounding import hours, hours_up, percent, percent_beside, share, without_unit
from hdprog.reporting.sections.table import Cell, Row, Table, Value
from hdprog.reporting.words import capital, quantity, with_unit
from hdprog.results import DriveResult, Forecast


def limits_table(result: DriveResult) -> Table:
    """Every limit: the state now, when it is passed, the risks and the inspection."""
    ahead = outlook.shutdown_ahead(result)
    shutdown = None if ahead is None else ahead[0]
    columns = ["limit", "now: median, 90 %", "passed at: median, 90 %"]
    if shutdown is not None:
        columns.append(f"risk by shutdown, {hours(shutdown)}")
    columns += [f"risk by {hours(result.forecasts[0].horizon_hours)}", "inspect before"]
    rows = [_row(result, forecast, shutdown) for forecast in result.forecasts]
    caption = (
        "Each limit by itself, if nothing is done. Hours are service hours; “later” is past the "
        f"horizon, where no number is given. {end_of_wear(result)}"
    )
    return Table.flat(
        caption.rstrip(),
        tuple(columns),
        rows,
        doubtful=not result.converged,
    )


def _row(result: DriveResult, forecast: Forecast, shutdown: float | None) -> Row:
    limit = forecast.limit
    name = "first of all" if limit is None else capital(outlook.limit_words(limit))
    cells: list[Cell] = [_now(result, forecast), _passed(forecast)]
    if shutdown is not None:
        risk = forecast.probability_crossed_by_shutdown
        cells.append("–" if risk is None else percent_beside(risk, forecast.acceptable_risk))
    cells.append(percent_beside(forecast.probability_crossed_by_horizon, forecast.acceptable_risk))
    cells.append(_inspect(forecast, dated=outlook.dated(result)))
    return Row(name, tuple(cells))


def _now(result: DriveResult, forecast: Forecast) -> Cell:
    limit, trend = forecast.limit, result.trend
    figure = None if limit is None or trend is None else trend.figures.get(limit.key)
    if limit is None or figure is None:
        return ""
    low, middle, high = outlook.figure_now(figure, forecast)
    return Value(with_unit(middle, quantity(limit.key).unit), f"{low} to {high}")


def _passed(forecast: Forecast) -> Cell:
    if forecast.already_crossed:
        return Value("passed already", percent(outlook.risk_now(forecast)))
    crossing, spread = outlook.crossing_hours(forecast), outlook.spread(forecast)
    values = [crossing.get(level) for level in (0.05, 0.50, 0.95)]
    if all(value is None for value in values):
        return "later"
    early, middle, late = values
    low = "later" if early is None else without_unit(hours(outlook.rounded_date(forecast, early)))
    high = "later" if late is None else hours_up(late, spread)
    about = outlook.spread_about_median(forecast)
    return Value("later" if middle is None else hours(middle, about), f"{low} to {high}")


def _inspect(forecast: Forecast, *, dated: bool) -> str:
    at, when = outlook.inspection_hours(forecast), outlook.inspection(forecast, dated=dated)
    return when if at is None or when != "by a date" else hours(at)


def waiting_table(result: DriveResult) -> Table | None:
    """Risk by round service hours: what it costs to wait. None where a limit is passed."""
    main = outlook.overall(result.forecasts)
    if main is None or main.already_crossed:
        return None
    accepted, rows = main.acceptable_risk, []
    for at, risk in outlook.deciding_risks(result):
        beside = "within" if risk <= accepted else "above"
        cells = (hours(at - main.now_hours), percent_beside(risk, accepted), beside)
        rows.append(Row(hours(at), cells))
    return Table.flat(
        "If nothing is done: the risk that a limit has been passed by then.",
        ("service hours", "from now", "risk", "accepted risk"),
        rows,
        doubtful=not result.converged,
    )


def loads_table(result: DriveResult) -> Table | None:
    """When the first limit is passed under other loads. None where none was asked for."""
    as_now = outlook.overall(result.forecasts)
    if not result.scenarios or as_now is None:
        return None
    told = result.trend is not None and "load_share" in result.trend.hyperparameters
    tested = (
        "the trend learns" if told else "the prior says, as no test of this drive tells of its load"
    )
    rows = []
    for load, main in sorted(
        [(1.0, as_now)]
        + [
            (one.load, outlook.overall(one.forecasts))
            for one in result.scenarios
            if one.load != 1.0
        ],
        key=lambda pair: pair[0],
    ):
        if main is None:
            continue
        name = f"{share(load)} of the mean so far" if load != 1.0 else "the mean so far"
        risk = percent_beside(main.probability_crossed_by_horizon, main.acceptable_risk)
        inspect = _inspect(main, dated=outlook.dated(result))
        rows.append(Row(name, (_passed(main), risk, inspect)))
    return Table.flat(
        "If the load changes from now on: the first of all limits. Wear is taken to go with the "
        "cube of the torque, as the makers rate life, the speed staying as it is. That is for the "
        f"part of wear that follows the load; how large it is {tested}.",
        (
            "torque to come",
            "passed at: median, 90 %",
            f"risk by {hours(as_now.horizon_hours)}",
            "inspect before",
        ),
        rows,
        doubtful=not result.converged,
    )
