"""How good the forecasts from one earlier test would have been, scored by what came later.

The trend is fitted to the tests up to an origin, and to nothing later. What it forecasts of each
limit is scored by the crossing that was seen, and what it predicts of the limited figures by each
later test.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hdprog.config import Drive, Limit
from hdprog.data.truth_file import Truth
from hdprog.forecast.crossing import Crossing, first_crossing, forecast_hours
from hdprog.forecast.limits import margins
from hdprog.forecast.scores import (
    alpha_lambda,
    covers,
    crps,
    interval_probability,
    log_score,
    probability_integral_transform,
    relative_accuracy,
    sample_crps,
)
from hdprog.forecast.what_came import (
    SeenTest,
    passed_between,
    straight_line,
    until_intervention,
    what_came,
)
from hdprog.inference.priors import Prior
from hdprog.physics.figures import FigureRequest, Operation
from hdprog.results import LEVELS, by_level, since_replaced
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.figure_paths import figure_paths
from hdprog.trend.fitting import fit_trend
from hdprog.trend.temperature import Temperatures
from hdprog.trend.trend import Paths, Trend
from hdprog.trend.wear_coordinates import to_loop
from hdprog.trend.wear_prior import WearPrior

ALPHA = 0.2
"""Share of the remaining life within which a forecast is called accurate (Saxena et al., 2010)."""
INTERVALS: Mapping[float, tuple[float, float]] = {0.5: (0.25, 0.75), 0.9: (0.05, 0.95)}
"""Central intervals by the probability that they should hold."""
_DRAWS = 1000


@dataclass(frozen=True)
class CrossingScore:
    """A forecast of one limit and its scores.

    Attributes
    ----------
    limit : which
    quantiles : forecast crossing in service hours by level, given that it was not before the
        origin; None past the horizon
    crossed_at : service hours at which the limit was crossed; infinite if not by `seen_until`
    seen_until : service hours up to which the forecast is scored
    from_truth : whether the crossing is the simulated drive's own, not read from later tests
    held : whether each of `INTERVALS` held the crossing
    own_probability : what the forecast itself gave each of them, see `interval_probability`
    crps_hours, log_score, transform : see `hdprog.forecast.scores`
    crossed_by_then : forecast probability of a crossing by `seen_until`
    late_hours : forecast median less the crossing; None where either was not seen
    within_alpha : `alpha_lambda`, None where the crossing was not seen
    accuracy : relative accuracy of the forecast median, None where either was not seen
    passed_between : hours of the tests between which the limit was passed, where these tell of it
    """

    limit: Limit
    quantiles: Mapping[float, float | None]
    crossed_at: float
    seen_until: float
    from_truth: bool
    held: Mapping[float, bool]
    own_probability: Mapping[float, float]
    crps_hours: float
    log_score: float
    transform: float
    crossed_by_then: float
    late_hours: float | None
    within_alpha: float | None
    accuracy: float | None
    passed_between: tuple[float, float] | None = None

    @property
    def within_tests(self) -> bool:
        """Whether the forecast median lies between the tests that do not tell it early or late."""
        if self.passed_between is None or self.late_hours is None:
            return False
        first, last = self.passed_between
        return first <= self.crossed_at + self.late_hours <= last

    @property
    def crossing_seen(self) -> bool:
        """Whether the crossing itself is known, not only that it comes later."""
        return math.isfinite(self.crossed_at)


@dataclass(frozen=True)
class FigureScore:
    """The prediction of a figure at a later test and its scores.

    Attributes
    ----------
    key : the figure's
    test_id, service_hours : of the later test
    ahead : 1 for the test that followed the origin, 2 for the one after it
    measured : median of the test's own posterior, in the figure's unit
    quantiles : of the prediction by level
    held : whether each of `INTERVALS` held what was measured
    crps, transform : see `hdprog.forecast.scores`
    line_error : absolute error of a straight line through the earlier tests' medians, since the
        drive was replaced if it was; of the median itself where there is one such test only
    """

    key: str
    test_id: str
    service_hours: float
    ahead: int
    measured: float
    quantiles: Mapping[float, float]
    held: Mapping[float, bool]
    crps: float
    transform: float
    line_error: float


@dataclass(frozen=True)
class OriginScores:
    """Everything that was forecast from one test on.

    Attributes
    ----------
    test_id, service_hours : of the last test that was known
    new_at_hours : service hours of the drive's first test, since it was replaced if it was
    known : number of tests known from there on, those at the same hours as one: only different
        hours tell a pace
    converged : whether the trend converged
    crossings : one a limit that was not passed by then and of which something was seen later
    passed : keys of limits that were passed by then, of which nothing is left to forecast
    figures : of every limited figure at every later test
    """

    test_id: str
    service_hours: float
    new_at_hours: float
    known: int
    converged: bool
    crossings: tuple[CrossingScore, ...]
    passed: tuple[str, ...]
    figures: tuple[FigureScore, ...]


def score_origin(
    evidence: Sequence[LoopEvidence],
    seen: Sequence[SeenTest],
    drive: Drive,
    prior: Prior,
    wear_prior: WearPrior,
    operation: Operation,
    truth: Truth | None,
    seed: np.random.SeedSequence,
    quick: bool = False,
) -> OriginScores:
    """Fit the trend to the tests known, forecast, and score by what came later.

    Parameters
    ----------
    evidence : the tests known, by service hours
    seen : all tests of the drive by service hours, those known first
    drive : its limits and horizon
    prior, wear_prior : of the loops and of the wear
    operation : what the figures refer to
    truth : of a simulated drive, else None: the later tests tell
    seed : of everything random
    quick : fewer draws in the trend
    """
    rng = np.random.default_rng(seed)
    origin, later = seen[len(evidence) - 1], seen[len(evidence) :]
    left_alone = until_intervention(later)
    touched = len(left_alone) < len(later)
    later = [test for test in left_alone if test.service_hours > origin.service_hours]
    trend = fit_trend(evidence, prior, wear_prior, rng, quick=quick, alpha=drive.alpha)
    now, horizon = trend.now_hours, drive.forecast.horizon_hours
    hours = np.union1d(forecast_hours(now, horizon), [test.service_hours for test in later])
    paths = trend.wandering_paths(hours, rng, _DRAWS)
    crossings, passed = [], []
    # The truth, too, holds what was done to the drive, which the forecast knows nothing of.
    until = [origin, *later][-1].service_hours if touched else horizon
    for limit in drive.limits:
        end, crossed_at, from_truth = what_came(limit, origin, later, truth, until)
        if crossed_at <= now:
            passed.append(limit.key)
        elif end > now:
            margin = margins(limit, paths, prior, operation)
            # Origins past the limit are not scored, so that it is known of this one that it is not.
            crossing = first_crossing(hours, [margin], survived_so_far=True)
            score = score_crossing(
                limit, crossing, crossed_at, end, from_truth, rng.uniform(), horizon
            )
            between = None if from_truth else passed_between(limit, origin, later)
            crossings.append(replace(score, passed_between=between))
    earlier = since_replaced(seen[: len(evidence)])
    figures = _score_figures(trend, paths, earlier, later, drive, operation, rng)
    return OriginScores(
        origin.test_id,
        now,
        earlier[0].service_hours,
        len({test.service_hours for test in earlier}),
        trend.converged,
        tuple(crossings),
        tuple(passed),
        figures,
    )


def score_crossing(
    limit: Limit,
    crossing: Crossing,
    crossed_at: float,
    seen_until: float,
    from_truth: bool,
    deviate: float,
    horizon: float,
) -> CrossingScore:
    """Score a forecast that was made before the crossing.

    Parameters
    ----------
    limit : which
    crossing : distribution as forecast
    crossed_at : service hours of the crossing, infinite if it was not seen
    seen_until : service hours up to which it would have been seen
    from_truth : whether it is a simulated drive's true one
    deviate : uniform on (0, 1), for the transform
    horizon : of the forecast
    """
    cut, now = crossing.upto(seen_until), float(crossing.hours[0])
    hours, probability = cut.hours, cut.probability
    known = {level: cut.quantile(level) for level in LEVELS}
    remaining = {level: None if at is None else at - now for level, at in known.items()}
    whole = crossing.upto(horizon) if crossing.hours[-1] > horizon else crossing
    quantiles = {level: whole.quantile(level) for level in LEVELS}
    median, life, seen = quantiles[0.5], crossed_at - now, math.isfinite(crossed_at)
    return CrossingScore(
        limit=limit,
        quantiles=quantiles,
        crossed_at=crossed_at,
        seen_until=seen_until,
        from_truth=from_truth,
        held={level: covers(remaining, *ends, life) for level, ends in INTERVALS.items()},
        own_probability={
            level: interval_probability(probability, *ends) for level, ends in INTERVALS.items()
        },
        crps_hours=crps(hours, probability, crossed_at),
        log_score=log_score(hours, probability, crossed_at, 1.0 / crossing.paths),
        transform=probability_integral_transform(hours, probability, crossed_at, deviate),
        crossed_by_then=float(probability[-1]),
        late_hours=median - crossed_at if seen and median is not None else None,
        within_alpha=(
            alpha_lambda(whole.hours, whole.probability, crossed_at, ALPHA) if seen else None
        ),
        accuracy=relative_accuracy(median - now, life) if seen and median is not None else None,
    )


def _score_figures(
    trend: Trend,
    paths: Paths,
    earlier: Sequence[SeenTest],
    later: Sequence[SeenTest],
    drive: Drive,
    operation: Operation,
    rng: np.random.Generator,
) -> tuple[FigureScore, ...]:
    """Score every limited figure at every later test, as warm, mounted and read as it was."""
    scored, temperatures = [], Temperatures.of(trend.tests)
    for ahead, test in enumerate(later, start=1):
        at = int(np.searchsorted(paths.hours, test.service_hours))
        state = paths.states[:, at]
        if temperatures is not None:
            warmth = temperatures.draw_warmth(test.temperature_C, rng, _DRAWS)
            state = state + warmth * paths.warmer
        mounted = to_loop(state + paths.mounting * rng.standard_normal(state.shape))
        for limit in {limit.key: limit for limit in drive.limits}.values():
            own = test.figures[limit.key]
            measured = float(np.median(own))
            met = figure_paths(FigureRequest.of(limit), mounted, trend.prior, operation)
            predicted = met + (measured - rng.choice(own, met.size))
            levels = by_level(predicted)
            line = straight_line(
                [one.service_hours for one in earlier],
                [one.median(limit.key) for one in earlier],
                test.service_hours,
            )
            scored.append(
                FigureScore(
                    key=limit.key,
                    test_id=test.test_id,
                    service_hours=test.service_hours,
                    ahead=ahead,
                    measured=measured,
                    quantiles=levels,
                    held={
                        level: bool(levels[low] <= measured <= levels[high])
                        for level, (low, high) in INTERVALS.items()
                    },
                    crps=sample_crps(predicted, measured),
                    transform=float(np.mean(predicted <= measured)),
                    line_error=abs(line - measured),
                )
            )
    return tuple(scored)
