"""Fit the trend: hyperparameters, and one point of linearisation for all loops, in turn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from hdprog.config.drive import DEFAULT_ALPHA
from hdprog.inference.information import Linearised
from hdprog.inference.priors import Prior
from hdprog.physics.parameters import FloatArray
from hdprog.results import since_replaced
from hdprog.trend.evidence import LoopEvidence, in_order
from hdprog.trend.followed_effects import FollowedEffects
from hdprog.trend.gaussian_step import GaussianStep
from hdprog.trend.hyperparameters import (
    FULL,
    QUICK,
    LogDensity,
    mode_of,
    sample,
    starting_walkers,
)
from hdprog.trend.joint_refit import FULL as JOINT_FULL
from hdprog.trend.joint_refit import QUICK as JOINT_QUICK
from hdprog.trend.joint_refit import Effort as JointEffort
from hdprog.trend.joint_refit import Met, begin_meeting
from hdprog.trend.joint_start import best_start
from hdprog.trend.relinearise import JointMode, JointPrior, joint_mode, moved
from hdprog.trend.state_space import Timeline, steps_of
from hdprog.trend.sudden_steps import sudden_steps
from hdprog.trend.tilted_loops import with_tilted_loops
from hdprog.trend.trend import LinearisedTrend, Trend
from hdprog.trend.trend_density import UNWORN, density
from hdprog.trend.wear_clock import ServiceClock, load_of_pace
from hdprog.trend.wear_coordinates import StatePrior, from_loop, linearise
from hdprog.trend.wear_prior import WearPrior

_MOVED_ENOUGH = 0.3  # posterior spreads per coordinate after which the loops are taken anew
_ROUNDS = 3
_LOAD_CHANGED = 1.3  # times the pace at the mean load so far


@dataclass(frozen=True)
class TrendUnderWay:
    """A trend whose loops may still be sampled in other processes.

    Attributes
    ----------
    linearised : before that
    distance : last move of the linearisation, in posterior spreads
    meeting : waits for the draws of what the tests met
    """

    linearised: LinearisedTrend
    distance: float
    meeting: Callable[[], Met]

    def finished(self) -> Trend:
        """Wait for it."""
        met = self.meeting()
        return Trend.of(self.linearised, met, _warnings(self.linearised, met, self.distance))


def fit_trend(
    evidence: Sequence[LoopEvidence],
    prior: Prior,
    wear_prior: WearPrior,
    rng: np.random.Generator,
    quick: bool = False,
    alpha: float = DEFAULT_ALPHA,
    followed: FollowedEffects | None = None,
    joint_effort: JointEffort | None = None,
) -> Trend:
    """Fit the trend to a drive's tests.

    Parameters
    ----------
    evidence : the tests, in any order
    prior : of the loops' coordinates; counts once a drive, not once a test
    wear_prior : see `read_wear_prior`
    rng : source of randomness
    quick : fewer draws
    alpha : gear-tooth angle in rad
    followed : effects whose amplitudes the evidence has as part of the state
    joint_effort : of sampling all loops and the trend together; what `quick` says if None

    Raises
    ------
    BadInputError
        without tests, or for hours or events that cannot be
    """
    return begin_trend(
        evidence,
        prior,
        wear_prior,
        rng,
        quick=quick,
        alpha=alpha,
        followed=followed,
        joint_effort=joint_effort,
    ).finished()


def begin_trend(
    evidence: Sequence[LoopEvidence],
    prior: Prior,
    wear_prior: WearPrior,
    rng: np.random.Generator,
    quick: bool = False,
    alpha: float = DEFAULT_ALPHA,
    followed: FollowedEffects | None = None,
    joint_effort: JointEffort | None = None,
    executor: Executor | None = None,
) -> TrendUnderWay:
    """Begin `fit_trend`, and leave its joint sampling under way.

    Parameters
    ----------
    executor : runs the joint sampling's parts side by side; in this process if None
    evidence, prior, wear_prior, rng, quick, alpha, followed, joint_effort : as in `fit_trend`
    """
    tests = in_order(evidence)
    if followed is not None:
        wear_prior = wear_prior.following(followed.size, followed.greased)
        wear_prior = wear_prior.stepping(sudden_steps(tests, prior, wear_prior))
    clock = ServiceClock.of(tests)
    timeline, _ = Timeline.of(tests, clock, wear_prior)
    state_prior = StatePrior.of(prior, wear_prior)

    def joint_prior(deviates: FloatArray) -> JointPrior:
        steps, scatter = steps_of(deviates[None], timeline, state_prior, wear_prior)
        return JointPrior.of(steps, float(scatter[0]), wear_prior.scales)

    def density_of(loops: Sequence[Linearised]) -> LogDensity:
        return density(tests, loops, state_prior, wear_prior)

    start = from_loop(np.stack([test.posterior.mean(axis=0) for test in tests]))
    loops = tuple(linearise(test, point) for test, point in zip(tests, start, strict=True))
    found = JointMode(start, loops, converged=False, steps=0)
    starts = np.concatenate([UNWORN[None], rng.standard_normal((63, UNWORN.size))])
    best = mode_of(density_of(found.loops), starts)
    found = best_start(tests, start, joint_prior(best), state_prior.sd, alpha, prior.softplus_scale)
    for _ in range(_ROUNDS):
        best = mode_of(density_of(found.loops), starts)
        found = joint_mode(tests, found.points, joint_prior(best))
        starts = np.concatenate([best[None], best + 0.3 * rng.standard_normal((7, best.size))])
    walkers = starting_walkers(density_of(found.loops), best, rng)
    # Short runs find where the hyperparameters lie; the loops are taken anew there.
    burn_in, proposal = 60, None
    for _ in range(_ROUNDS):
        draws = sample(density_of(found.loops), walkers, burn_in, 60, rng, proposal=proposal)
        walkers, centre = draws.chains[:, -1], draws.flat.mean(axis=0)
        burn_in, proposal = 20, draws.proposal
        before, found = found, joint_mode(tests, found.points, joint_prior(centre))
        distance = moved(before.points, found, joint_prior(centre))
        if distance < _MOVED_ENOUGH:
            break
    step = GaussianStep.of(
        tests, found, timeline, state_prior, wear_prior, alpha, prior.softplus_scale
    )
    step = with_tilted_loops(step, centre, rng)
    found = replace(found, loops=tuple(test.loop for test in step.tests))
    effort = QUICK if quick else FULL
    draws = sample(density_of(found.loops), walkers, 40, effort.steps, rng, effort, proposal)
    effort_of_all = joint_effort or (JOINT_QUICK if quick else JOINT_FULL)
    meeting = begin_meeting(step, draws, rng, effort_of_all, executor)

    linearised = LinearisedTrend(tests, prior, wear_prior, clock, found, draws, followed)
    return TrendUnderWay(linearised, distance, meeting)


def _load_of_late(trend: LinearisedTrend) -> list[str]:
    """That the load of late is not the mean so far, with which the forecast goes on."""
    pace = trend.clock.pace_of_late if trend.clock.by_load else 1.0
    if 1.0 / _LOAD_CHANGED < pace < _LOAD_CHANGED:
        return []
    if pace <= 0:
        return [
            "Before the last test the drive ran without load. The forecast goes on with its mean "
            "load so far."
        ]
    return [
        f"Before the last test the drive's load wore it {pace:.2g} times as fast as its mean load "
        "so far, with which the forecast goes on. Forecast for the load of late with "
        f"--load {load_of_pace(pace):.2f}."
    ]


def _warnings(trend: LinearisedTrend, met: Met, distance: float) -> tuple[str, ...]:
    said = []
    tests, found, draws, wear_prior = trend.tests, trend.mode, trend.draws, trend.wear_prior
    carrier = "the wear prior" if wear_prior.fleet is None else "the fleet"
    own = since_replaced(tests)
    replaced = len(own) < len(tests)
    seen = len({test.service_hours for test in own})
    since = " since the drive was replaced" if replaced else ""
    carrier = f"the drive before it and {carrier}" if replaced else carrier
    if seen == 1:
        few = f"There is one test only{since}"
        if len(own) > 1:
            few = f"All tests{since} are at the same hours"
        said.append(f"{few}: how fast the drive wears is told by {carrier}, not the drive.")
    elif seen < 4:
        few = f"{seen} tests" if len(own) == seen else f"tests at {seen} service hours"
        carry = "carry" if replaced else "carries"
        said.append(f"There are {few} only{since}: {carrier} {carry} much of the forecast.")
    if replaced:
        said.append(
            "The drive was replaced: the state starts anew there, and how far wear changes each "
            "parameter; pace of wear and scatter are learnt from the one before, too."
        )
    said += _load_of_late(trend)
    if not met.sampled and (not found.converged or distance > _MOVED_ENOUGH):
        said.append(
            "The joint linearisation of the loops did not come to rest "
            f"(last move {distance:.2g} posterior spreads); the forecast is marked."
        )
    if not draws.converged:
        said.append(
            "The trend's hyperparameters did not converge "
            f"(R-hat {draws.rhat:.3f}, effective draws {draws.ess_bulk:.0f} in the bulk and "
            f"{draws.ess_tail:.0f} in the tails); the forecast is marked."
        )
    if not met.converged:
        how = "found no start"
        if met.rhat is not None:
            how = f"did not converge (R-hat {met.rhat:.3f}, {met.ess:.0f} effective draws)"
        said.append(f"The joint sampling of loops and trend {how}; the forecast is marked.")
    return tuple(said)
