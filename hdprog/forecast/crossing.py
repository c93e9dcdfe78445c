"""When a limit is first crossed: the distribution over service hours, from paths.

Between two times of a path that are both short of the limit, by m_1 and m_2, a Brownian path of
variance v has been past it with probability exp(−2 m_1 m_2 / v) (Karatzas & Shreve, Brownian
Motion and Stochastic Calculus, 2nd ed. 1991, section 4.3.C). The chance of having survived is
carried along each path, so nothing is lost between the times of the grid.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from hdprog.config import Drive, ForecastSettings, Limit
from hdprog.errors import BadInputError
from hdprog.forecast.limits import Margins, margins
from hdprog.parallel import begin
from hdprog.physics.figures import Operation
from hdprog.physics.parameters import FloatArray
from hdprog.results import LEVELS, Forecast
from hdprog.trend.trend import Trend

_DRAWS = 4000  # paths: the 95 % point of a few hundred of them is anywhere
_TOGETHER = 500  # a whole part of them, which stays in the processor's cache
_JOBS = 2  # that the parts are divided into, which may run side by side
_TIMES = 140
_DENSER = 5.0  # log of how much longer the grid's last step is than its first
_SETTLED = 0.5


@dataclass(frozen=True)
class Crossing:
    """Distribution of the first crossing.

    Attributes
    ----------
    hours : (times,) service hours from now on
    probability : (times,) of having crossed by then, non-decreasing
    already : whether the state at now is past the limit with more than even odds
    paths : that the distribution rests on
    """

    hours: FloatArray
    probability: FloatArray
    already: bool
    paths: int

    @staticmethod
    def of_survival(hours: FloatArray, survival: FloatArray, past: float, paths: int) -> Crossing:
        """From the chance (times,) of no crossing so far, and the share of paths past it at now."""
        probability = np.maximum.accumulate(1.0 - survival)
        return Crossing(hours, np.clip(probability, 0.0, 1.0), past > _SETTLED, paths)

    def by(self, hours: float) -> float:
        """Probability of having crossed by service hours."""
        return float(np.interp(hours, self.hours, self.probability))

    def quantile(self, level: float) -> float | None:
        """Service hours at which the probability reaches a level; None past the last hour."""
        if self.probability[0] >= level:
            return float(self.hours[0])
        if self.probability[-1] < level:
            return None
        after = int(np.searchsorted(self.probability, level))
        low, high = self.probability[after - 1], self.probability[after]
        share = (level - low) / (high - low)
        return float(self.hours[after - 1] + share * (self.hours[after] - self.hours[after - 1]))

    def upto(self, horizon: float) -> Crossing:
        """Cut it at a horizon inside its hours."""
        inside = self.hours < horizon
        return Crossing(
            np.append(self.hours[inside], horizon),
            np.append(self.probability[inside], self.by(horizon)),
            self.already,
            self.paths,
        )


def require_horizon_ahead(now: float, horizon: float) -> None:
    """Refuse a horizon in service hours that is not after now; see `forecast_hours`."""
    if not horizon > now:
        raise BadInputError(
            found=f"a horizon of {horizon:g} service hours",
            where="[forecast] horizon_hours in drive.toml",
            expected=f"more than the {now:g} service hours of the last test",
            advice="Set horizon_hours later; it counts from zero, as service_hours does.",
        )


def forecast_hours(now: float, horizon: float, shutdown: float | None = None) -> FloatArray:
    """Service hours (times,) from now to the horizon, denser near now.

    A shutdown past the horizon extends them.

    Raises
    ------
    BadInputError
        if the horizon is not after now
    """
    require_horizon_ahead(now, horizon)
    steps = np.expm1(_DENSER * np.linspace(0.0, 1.0, _TIMES)) / np.expm1(_DENSER)
    hours = now + (horizon - now) * steps
    hours[-1] = horizon
    if shutdown is not None and shutdown > horizon:
        hours = np.concatenate([hours, np.linspace(horizon, shutdown, 21)[1:]])
    return np.asarray(hours)


def first_crossing(
    hours: FloatArray, limits: Sequence[Margins], *, survived_so_far: bool = False
) -> Crossing:
    """First crossing of any of several limits (or of one).

    Paths that are past a limit at now have crossed it at now. Tests give figures within errors
    and say no more of whether a limit is passed; where something else does, such as a part that
    has not failed, these paths are left out.

    Parameters
    ----------
    hours : (times,) service hours, now first
    limits : margins along the same paths
    survived_so_far : whether it is known that no limit has been passed up to now; paths that are
        past one count all the same where every one is
    """
    survived = _survival(limits)
    past = survived[:, 0] == 0.0
    kept = survived[~past] if survived_so_far and not past.all() else survived
    return Crossing.of_survival(hours, kept.mean(axis=0), float(past.mean()), len(kept))


def _survival(limits: Sequence[Margins]) -> FloatArray:
    """(draws, times) chance that a path has been past none of the limits since the first time.

    One random path leads to all of them: between two times it touches the limit that it touches
    most easily, and the others no more often.
    """
    short = np.all([limit.margin > 0 for limit in limits], axis=0)
    stays = np.min([_stays(limit) for limit in limits], axis=0)
    stays = np.where(short[:, :-1] & short[:, 1:], stays, 0.0)
    return np.concatenate([short[:, :1], np.cumprod(stays, axis=1) * short[:, :1]], axis=1)


def _stays(limit: Margins) -> FloatArray:
    """(draws, times − 1) chance of staying short of a limit between times short of it."""
    room = np.maximum(limit.margin, 0.0)
    variance = np.maximum(limit.wander[:, 1:], np.finfo(float).tiny)
    with np.errstate(over="ignore"):  # a path that does not wander: exp(−∞) = 0 is meant
        return np.asarray(1.0 - np.exp(-2.0 * room[:, :-1] * room[:, 1:] / variance))


@dataclass(frozen=True)
class _Question:
    """What is asked of paths, whichever their random numbers.

    Attributes
    ----------
    trend, operation, load_factor : as in `begin_forecast`
    limits : of the drive
    hours : (times,) service hours, now first
    """

    trend: Trend
    operation: Operation
    load_factor: float
    limits: tuple[Limit, ...]
    hours: FloatArray

    @property
    def which(self) -> list[tuple[Limit | None, slice]]:
        """Every limit, and None for the first of them where there are more, with their places."""
        each: list[tuple[Limit | None, slice]] = [
            (limit, slice(at, at + 1)) for at, limit in enumerate(self.limits)
        ]
        return [*each, (None, slice(None))] if len(each) > 1 else each

    def survivals(
        self, parts: Sequence[tuple[np.random.SeedSequence, bool]]
    ) -> list[list[FloatArray]]:
        """Chance (times,) of no crossing so far, of every limit, over paths part by part.

        Parameters
        ----------
        parts : random numbers of each, and whether wear comes to its end there
        """
        return [self._survival(np.random.default_rng(seed), ends) for seed, ends in parts]

    def _survival(self, rng: np.random.Generator, wear_ends: bool) -> list[FloatArray]:
        trend = self.trend
        paths = trend.wandering_paths(
            self.hours, rng, _TOGETHER, self.load_factor, wear_ends=wear_ends
        )
        each = [
            margins(limit, paths, trend.prior, self.operation, trend.followed)
            for limit in self.limits
        ]
        return [_survival(each[of]).mean(axis=0) for _, of in self.which]


def begin_forecast(
    trend: Trend,
    drive: Drive,
    operation: Operation,
    rng: np.random.Generator,
    load_factor: float = 1.0,
    executor: Executor | None = None,
) -> Callable[[], tuple[Forecast, ...]]:
    """Begin to forecast the first crossing of every limit, and of the first of them.

    Parameters
    ----------
    trend : as fitted
    drive : its limits, in the order of drive.toml, horizon, acceptable risk and next shutdown
    operation : what the figures refer to
    rng : source of randomness
    load_factor : pace of wear's clock from now on over the pace so far, e.g. 0.8³ at 80 % torque
    executor : follows parts of the paths side by side; in this process if None

    Returns
    -------
    a function that waits for the forecasts

    Raises
    ------
    BadInputError
        if the horizon is not after the last test
    """
    settings, limits = drive.forecast, drive.limits
    hours = forecast_hours(trend.now_hours, settings.horizon_hours, settings.next_shutdown_hours)
    if not limits:
        return tuple
    asked = _Question(trend, operation, load_factor, limits, hours)
    whole = np.random.SeedSequence(rng.integers(0, 2**32, size=4).tolist())
    seeds = whole.spawn(_DRAWS // _TOGETHER)
    # From the same random numbers as the first part: what differs is the end of wear alone.
    parts = [(seeds[0], False), *((seed, True) for seed in seeds)]
    jobs = [
        begin(executor, asked.survivals, [parts[at] for at in places])
        for places in np.array_split(np.arange(len(parts)), _JOBS)
    ]

    def forecasts() -> tuple[Forecast, ...]:
        endless, *ended = [one for job in jobs for one in job.result()]
        found = []
        for place, (limit, _) in enumerate(asked.which):
            survival = np.mean([one[place] for one in ended], axis=0)
            whole, ending, without_end = (
                Crossing.of_survival(hours, one, 1.0 - float(one[0]), _DRAWS)
                for one in (survival, ended[0][place], endless[place])
            )
            horizon = settings.horizon_hours
            held_up = max(without_end.by(horizon) - ending.by(horizon), 0.0)
            found.append(_result(limit, whole, settings, held_up))
        return tuple(found)

    return forecasts


def forecast(
    trend: Trend,
    drive: Drive,
    operation: Operation,
    rng: np.random.Generator,
    load_factor: float = 1.0,
) -> tuple[Forecast, ...]:
    """Forecast as `begin_forecast` does, here and now."""
    return begin_forecast(trend, drive, operation, rng, load_factor)()


def _result(
    limit: Limit | None, crossing: Crossing, settings: ForecastSettings, held_up: float
) -> Forecast:
    shutdown, now = settings.next_shutdown_hours, float(crossing.hours[0])
    inside = crossing.upto(settings.horizon_hours)
    # One that lies behind the last test is over: nothing is at risk by it.
    by_shutdown = None if shutdown is None or shutdown <= now else crossing.by(shutdown)
    remaining: dict[float, float | None] = {}
    for level in LEVELS:
        at = inside.quantile(level)
        remaining[level] = None if at is None else at - now
    return Forecast(
        limit=limit,
        now_hours=now,
        already_crossed=crossing.already,
        acceptable_risk=settings.acceptable_risk,
        horizon_hours=settings.horizon_hours,
        inspect_before_hours=now if crossing.already else inside.quantile(settings.acceptable_risk),
        probability_crossed_by_shutdown=by_shutdown,
        probability_crossed_by_horizon=float(inside.probability[-1]),
        remaining_hours=remaining,
        crossing_probability=np.column_stack([inside.hours, inside.probability]),
        probability_held_up_by_end_of_wear=held_up,
    )
