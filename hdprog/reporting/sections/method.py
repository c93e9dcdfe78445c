"""How the numbers came about, written from what was done."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from hdprog.reporting.effect_words import effect_name
from hdprog.reporting.fit_names import doubtful_without_effects
from hdprog.reporting.rounding import grouped, hours, interval, plain, share
from hdprog.reporting.sections.table import Row, Table
from hdprog.reporting.words import agree, capital, counted, listed, spoken, torque_words
from hdprog.results import DriveResult, TestResult, TrendSummary

_HYPERPARAMETERS = {
    "wear_rate": "pace of wear: units of wear after the reference hours",
    "clock_exponent": "wear grows as hours to this power: 1 steady, above 1 speeding up",
    "clock_curvature": "above 0 wear levels off, below 0 it feeds on itself",
    "running_in_length": "wear within which running-in is over",
    "volatility": "random wear, shared by all parameters",
    "rate_volatility": "random change of the pace of wear",
    "own_volatility": "random drift, and change of pace, of each other parameter by itself",
    "preload_volatility": "random drift, and change of pace, of preload and of friction",
    "remounting_scatter": "scatter from mounting to mounting, not wear",
    "load_share": "how far wear follows the load given for each stretch: 0 not, 1 wholly",
}

_EFFECTS = (
    "Each candidate is tested by the gain of log evidence of a full refit from several starting "
    "points, the noise (white, or white plus Ornstein-Uhlenbeck) refitted each time; the model "
    "without it is refitted from where it led. An effect is added where it gains more than 5, a "
    "second one where it also carries 10 % of the explained error (less, the more it clears up of "
    "what was left: 2 % down to a quarter, 0.8 % down to a tenth) or gains more than 25 and leaves "
    "noise alone; after each the earlier ones are checked again. What gains more than 10 and is "
    "refused for its share is told as left over. How often that goes wrong is measured on "
    "simulated loops. What no mechanism carries becomes an empirical smooth curve over the "
    "coordinate that carries it, also where noise with a memory could stand for it but would be "
    "many times the white noise; it is called unknown. Readings that hang on the slip before the "
    "first one are not left out: no others tell it. The gain of expected log predictive density "
    "on left-out blocks, with its standard error, stands beside each effect; it does not decide. "
    "The drive model alone, and the remaining life that it would give, are sampled briefly: they "
    "are for comparison."
)


@dataclass(frozen=True)
class Passage:
    """A short heading and its text."""

    title: str
    text: str


def method(result: DriveResult) -> list[Passage]:
    """Model, priors, noise, sampling, trend and forecast as they were used."""
    passages = [
        Passage("Model of a loop", _model(result)),
        Passage("Priors", _priors(result)),
        Passage("Noise", _noise(result)),
        Passage("Sampling", _sampling(result)),
        Passage("Figures of merit", _figures(result)),
    ]
    if result.explanation is not None:
        passages.append(Passage("Effects outside the drive model", _EFFECTS))
    if result.trend is not None:
        passages.append(Passage("Trend", _trend(result.trend)))
    if result.forecasts:
        passages.append(Passage("Forecast", _forecast(result)))
    return passages


def _model(result: DriveResult) -> str:
    drive = result.drive
    alpha = f"{plain(round(math.degrees(drive.alpha), 6))}°"
    declared = "as declared" if drive.alpha_declared else "assumed, as none is declared"
    effects = sorted({effect for test in result.tests for effect in test.effects})
    where = "" if len(result.tests) == 1 else " where the tests table says so"
    added = (
        f" Beside it {listed(effect_name(effect) for effect in effects)} "
        f"{agree(len(effects), 'was', 'were')} fitted{where}."
        if effects
        else " No further effect was fitted."
    )
    return (
        "The torsion angle is the sum of the flexspline cup's, the tooth mesh's and the wave "
        "generator's, the last with friction as a play operator, so that every load history has "
        f"its own loop. Eight parameters are inferred; the gear-tooth angle is {alpha}, "
        f"{declared}, and is not: K_W, μ, c and the preload depend on it, stiffness and width "
        f"hardly do.{added} "
        "The encoder's zero, the noise scale and the slip before the first reading are inferred "
        "with them."
    )


def _priors(result: DriveResult) -> str:
    names = list(dict.fromkeys(test.prior_name for test in result.tests))
    return (
        f"Prior of the parameters: {listed(names)}. What a test does not inform stays at the "
        "prior; the tables under Parameters say which, by contraction and by power scaling "
        "(Kallioinen et al. 2024). Prior and record are said to disagree about a parameter where "
        "the record moved it by more than one sound fit in twenty moves any of the eight."
    )


def _noise(result: DriveResult) -> str:
    by_model: dict[str, list[str]] = {}
    for test in result.tests:
        by_model.setdefault(test.noise_model, []).append(test.test_id)
    said = [
        model
        if len(by_model) == 1
        else f"{model} ({agree(len(ids), 'test', 'tests')} {listed(ids)})"
        for model, ids in by_model.items()
    ]
    return (
        f"{capital('; '.join(said))}. Records were averaged in blocks along the path, "
        f"with reversals kept exact: {_range([len(t.loop) for t in result.tests])} readings became "
        f"{_range([t.fit.torque.size for t in result.tests])} blocks a test."
    )


def _range(counts: list[int]) -> str:
    low, high = grouped(min(counts), 0), grouped(max(counts), 0)
    return low if low == high else f"{low} to {high}"


def _draws(test: TestResult) -> int:
    found = [test.diagnostics.get(name, math.nan) for name in ("ensembles", "walkers", "steps")]
    return round(math.prod(found)) if all(math.isfinite(value) for value in found) else 0


def _sampling(result: DriveResult) -> str:
    made = [draws for test in result.tests if (draws := _draws(test))]
    count = f", {_range(made)} draws a test" if made else ""
    converged = sum(test.converged for test in result.tests)
    which = (
        "Every fit converged"
        if converged == len(result.tests)
        else f"{converged} of {counted(len(result.tests), 'fit')} converged"
    )
    alone = doubtful_without_effects(result)
    if alone:
        tests = agree(len(alone), "test", "tests")
        which += f"; the drive model alone, fitted to compare, did not in {tests} {listed(alone)}"
    quick = " The run was quick, with fewer draws." if result.provenance.quick else ""
    return (
        f"Independent ensembles of walkers (emcee){count}. {which}, judged by R-hat across "
        f"ensembles, effective sample size and length in autocorrelation times.{quick}"
    )


def _figures(result: DriveResult) -> str:
    drive = result.drive
    if drive.rated_torque is not None:
        rated = f"the rated torque of {torque_words(drive.rated_torque)}"
    elif len(result.tests) == 1:
        rated = "the largest torque of the record, as no rated torque is declared"
    else:
        rated = "the smallest of the tests' largest torques, as no rated torque is declared"
    reference = (
        rated
        if drive.reference_torque is None
        else f"the reference torque of {torque_words(drive.reference_torque)}"
    )
    return (
        f"Hysteresis width and loss are those of the model's steady cycle to ± {reference}, so "
        "that tests run to different torques compare. Lost motion is the angle on the loop's "
        f"mid-line between −4 % and +4 % of {rated}. Figures are computed draw by draw, "
        "so that their intervals carry every correlation between the parameters."
    )


def _trend(trend: TrendSummary) -> str:
    carried = [spoken(name) for name in trend.carried_by_prior]
    told = (
        f" The tests hardly moved these, which {_carrier(trend)} carries: {listed(carried)}."
        if carried
        else " The tests moved all its hyperparameters away from the prior."
    )
    if trend.fleet is not None:
        many = counted(len(trend.fleet.drives), "other drive")
        told += (
            f" Its prior is that of the fleet, learnt from the tests of {many}: each "
            "hyperparameter and loading is a fleet's mean and a drive's own departure, whose "
            "shares are unknown."
        )
        if trend.fleet.steady is not None:
            told += (
                " Drives whose wear follows a power of the hours alone are pooled beside those "
                "whose pace wanders, by how much better their tests fit one or the other."
            )
    if trend.temperature is not None:
        told += (
            " What 10 K change in each parameter is a Gaussian that the tests, which differ in "
            "temperature, narrow."
        )
    told += _exactness(trend.diagnostics)
    doubt = "" if trend.converged else " The trend did not converge: its numbers are provisional."
    return f"{capital(trend.model).rstrip('.')}.{told}{doubt}"


def _carrier(trend: TrendSummary) -> str:
    """Whose the prior is: with a fleet it is what that has told, as the verdict says."""
    return "the prior" if trend.fleet is None else "the fleet"


def _exactness(diagnostics: Mapping[str, float]) -> str:
    k = diagnostics.get("pareto_k", math.nan)
    if not math.isfinite(k):
        return ""
    step = f" A Gaussian near the joint mode stands for every loop at first (Pareto k {k:.2f})"
    if "joint_rhat" not in diagnostics:
        return step + "; its draws are weighted by the loops' own likelihoods."
    limit = diagnostics.get("joint_rhat_limit")
    asked = "" if limit is None else f" where less than {limit:g} is asked for"
    return (
        step + "; all loops and the trend were then sampled together by their own likelihoods "
        f"(R-hat {diagnostics['joint_rhat']:.3f}{asked}, "
        f"{diagnostics['joint_ess']:.0f} effective draws)."
    )


def _forecast(result: DriveResult) -> str:
    main = result.forecasts[0]
    return (
        "Paths are drawn from the posterior of state and hyperparameters and pushed through the "
        "model to each limited figure; a limit is passed when a path, without the scatter of "
        "remounting, first crosses it. Paths that do not cross by the horizon of "
        f"{hours(main.horizon_hours)} count as “later” and get no number. “Inspect before” is the "
        "hour at which the share of paths that have crossed reaches "
        f"{share(main.acceptable_risk)}. Hours are service hours, counted from zero; they are "
        "rounded by their uncertainty, inspection hours downwards. “Test again” is half-way "
        "from now to the inspection, and now where that is within a tenth of the longest time "
        "between two tests; without an inspection, as long again as the longest time between two "
        "tests; after one test alone, where that would be the far tail of the prior, the hour by "
        "which a limit is passed with a chance of one in four. Nothing is assumed to be done to "
        "the drive in between, and its load to stay at its mean so far"
        f"{_loads(result)}."
    )


def _loads(result: DriveResult) -> str:
    if not result.scenarios:
        return ""
    return (
        "; under another load the clock of wear runs from now on with the cube of the torque to "
        "come over the torque so far, as far as wear follows the load"
    )


def hyperparameters(trend: TrendSummary) -> Table:
    """Hyperparameters of the trend and what carries each."""
    rows = []
    for name, levels in trend.hyperparameters.items():
        told = _carrier(trend) if name in trend.carried_by_prior else "the tests"
        values = interval(levels[0.05], levels[0.50], levels[0.95])
        rows.append(Row(spoken(name), (*values, told), note=_HYPERPARAMETERS.get(name, "")))
    return Table.flat(
        "Hyperparameters of the trend.",
        ("hyperparameter", "5 %", "median", "95 %", "carried by"),
        rows,
        doubtful=not trend.converged,
    )
