"""Tables of the tests: what was measured, figures, parameters and diagnostics."""

from __future__ import annotations

from collections.abc import Mapping

from hdprog.reporting.effect_words import effect_name
from hdprog.reporting.error_words import micro
from hdprog.reporting.read_off_words import record_words
from hdprog.reporting.rounding import (
    digit_step,
    grouped,
    hours,
    interval,
    rounded,
    share,
    significant,
)
from hdprog.reporting.sections.table import Cell, Group, Row, Table, Value
from hdprog.reporting.words import (
    capital,
    contraction_words,
    figure_interval,
    parameter_factor,
    parameter_meaning,
    parameter_name,
    quantity,
    spoken,
)
from hdprog.results import DriveResult, ParameterSummary, ReadOff, TestResult

_WITH_EFFECTS = "with lasting effects"
_SAMPLING = {
    "ensembles": "ensembles",
    "walkers": "walkers",
    "steps": "steps",
    "warm_up_steps": "warm-up steps",
    "autocorrelation_time": "autocorrelation time",
    "acceptance": "acceptance",
    "evaluations": "model evaluations",
    "lost_mode": "modes lost",
    "temperature": "temperature of the likelihood, made up for by weights",
    "pareto_k": "Pareto k of effects integrated out to first order",
    "weighted_draws_effective": "effective draws by their weights",
}


def when(test: TestResult) -> str:
    """Service hours of a test, or that they are not given."""
    return "hours not given" if test.service_hours is None else hours(test.service_hours)


def overview(result: DriveResult) -> Table:
    """List what was measured and how well the model accounts for it."""
    rows = [
        Row(
            test.test_id,
            (
                when(test),
                test.date or "–",
                test.event or "–",
                grouped(len(test.loop), 0),
                micro(test.rmse_rad),
                micro(test.noise_floor_rad),
                share(round(test.outlier_fraction, 4)),
                ", ".join(effect_name(effect) for effect in test.effects) or "none",
                test.note or "–",
            ),
            doubtful=not test.converged,
        )
        for test in result.tests
    ]
    columns = (
        "test",
        "at",
        "date",
        "event before it",
        "readings",
        "error [µrad]",
        "noise floor [µrad]",
        "set aside",
        "effects fitted",
        "note",
    )
    caption = (
        "What was measured. Error: root mean square of measured minus fitted angle, without the "
        "readings set aside; "
        "where it is near the noise floor, the model accounts for the loop."
    )
    return Table.flat(caption, columns, rows)


def figures(result: DriveResult, catalogue: Mapping[str, float]) -> Table:
    """Figures of merit of every test, and the maker's where they are known."""
    limited = [limit.key for limit in result.drive.limits]
    found = dict.fromkeys(key for test in result.tests for key in test.figures)
    keys = sorted(found, key=lambda key: key not in limited)
    rows: list[Row] = []
    for test in result.tests:
        sources = [(f"{test.test_id}, {when(test)}", test.figures)]
        if test.figures_with_effects:
            sources.append((f"{test.test_id} {_WITH_EFFECTS}", test.figures_with_effects))
        rows += [
            Row(
                head,
                tuple(_figure(key, values.get(key)) for key in keys),
                doubtful=not test.converged,
            )
            for head, values in sources
        ]
    maker = [catalogue.get(key) for key in keys]
    if any(value is not None for value in maker):
        cells = tuple(
            "–" if value is None else significant(quantity(key).factor * value, 2)
            for key, value in zip(keys, maker, strict=True)
        )
        rows.append(Row("maker's catalogue", cells))
    heads = [quantity(key).head for key in keys]
    caption = "Figures of merit of each test by itself: median, below it the 90 % interval."
    if any(test.figures_with_effects for test in result.tests):
        caption += (
            f" “{capital(_WITH_EFFECTS)}”: of the whole loop, with the effects in it that keep "
            "their size; else of the drive model's part alone."
        )
    return Table.flat(caption, ("test", *heads), rows)


def read_off(result: DriveResult) -> Table | None:
    """What the records show without a model, and the fits there; None where no record shows any."""
    keys = dict.fromkeys(key for test in result.tests for key in test.read_off)
    if not keys:
        return None
    limited = [limit.key for limit in result.drive.limits]
    ordered = sorted(keys, key=lambda key: key not in limited)
    rows = [
        Row(
            f"{test.test_id}, {when(test)}",
            tuple(_read_off(key, test.read_off.get(key)) for key in ordered),
            doubtful=not test.converged,
        )
        for test in result.tests
    ]
    caption = (
        "Read off the records themselves, no model in between, each at its own swing of torque: "
        "lines through the readings near a torque tell where its branches are (± one standard "
        "deviation of noise). Below it the same lines through the fitted curve, effects that were "
        "found included, an empirical curve not. Good: both agree. Where the fit misses by "
        "more than chance what was measured, of drive and rig together, find out why before you "
        "act on the figure."
    )
    return Table.flat(caption, ("test", *(quantity(key).head for key in ordered)), rows)


def _read_off(key: str, found: ReadOff | None) -> Cell:
    if found is None:
        return "–"
    _, middle, _ = figure_interval(key, found.fit[0.05], found.fit[0.50], found.fit[0.95])
    return Value(record_words(key, found), f"fit {'misses it: ' if found.differs else ''}{middle}")


def _figure(key: str, levels: Mapping[float, float] | None) -> Cell:
    if levels is None:
        return "–"
    return Value.of(levels, quantity(key).factor)


def parameters(result: DriveResult) -> Table:
    """Parameters of every test with what the test told of each."""
    groups = tuple(
        Group(
            f"Test {test.test_id}, {when(test)}",
            tuple(_parameter(name, found) for name, found in test.parameters.items()),
            doubtful=not test.converged,
        )
        for test in result.tests
    )
    columns = (
        "parameter",
        "5 %",
        "median",
        "95 %",
        "this test",
        "R\u2011hat",
        "ESS bulk",
        "ESS tail",
    )
    return Table(
        "Parameters of each test. “This test”: how far it narrowed the prior (contraction = "
        "1 − variance of posterior / variance of prior in the sampled coordinate); what it did "
        "not inform is the prior's. ESS: effective sample size.",
        columns,
        groups,
    )


def _parameter(name: str, found: ParameterSummary) -> Row:
    levels, factor = found.quantiles, parameter_factor(name)
    low, middle, high = interval(*(factor * levels[at] for at in (0.05, 0.50, 0.95)))
    told = f"{contraction_words(found.contraction)} ({grouped(found.contraction, 2)})"
    checks = (_rhat(found.rhat), _count(found.ess_bulk), _count(found.ess_tail))
    meaning = parameter_meaning(name)
    return Row(parameter_name(name), (low, middle, high, told, *checks), note=meaning)


def _rhat(value: float) -> str:
    return f"{value:.3f}" if value == value else "–"


def _count(value: float) -> str:
    return rounded(value, max(value / 50.0, 2 * digit_step(2.0))) if value == value else "–"


def diagnostics(result: DriveResult) -> Table:
    """How each fit was sampled and whether it converged."""
    named = dict.fromkeys(name for test in result.tests for name in _settings(test))
    rows = []
    for test in result.tests:
        rhats = [found.rhat for found in test.parameters.values()]
        sizes = [min(found.ess_bulk, found.ess_tail) for found in test.parameters.values()]
        own = _settings(test)
        cells = [
            "yes" if test.converged else "NO",
            _rhat(max(rhats, default=float("nan"))),
            _count(min(sizes, default=float("nan"))),
            *(_setting(own.get(name)) for name in named),
        ]
        rows.append(Row(test.test_id, tuple(cells), doubtful=not test.converged))
    columns = ("test", "converged", "largest R-hat", "smallest ESS", *named)
    caption = (
        "Diagnostics of each fit. Good: R-hat below 1.01 over independent ensembles, ESS of 1 000 "
        "or more (400 in a quick run), at least 50 autocorrelation times long. R-hat and ESS here "
        "are the worst of the eight parameters; whatever else is sampled, the slip before the "
        "first sample above all, must be as good."
    )
    return Table.flat(capital(caption), columns, rows)


def _settings(test: TestResult) -> dict[str, float]:
    """Numbers of the sampling by their names; not the time, which differs from run to run."""
    return {
        _SAMPLING.get(key, spoken(key)): value
        for key, value in test.diagnostics.items()
        if key != "seconds"
    }


def _setting(value: float | None) -> str:
    if value is None:
        return "–"
    return grouped(value, 0) if float(value).is_integer() else significant(value, 3)
