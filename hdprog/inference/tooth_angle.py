"""How a loop's parameters and figures move where the gear-tooth angle is another than assumed.

The angle is confounded with K_W and mu: to first order a loop fixes tan²α/K_W, mu/tan α, c/cos α
and T_i, so that another angle gives nearly the same loop with other numbers. From there the mode is
found anew with the other angle, and every number is moved as it moves from mode to mode: parameters
by the shift of their unconstrained coordinate, figures by their ratio. Against full refits (20°
for 30°, new and worn drive, two priors) stiffness came out right to 0.05 % of its value and the
other numbers to 0.6 posterior standard deviations at worst. Importance weights of the mapped draws
were of no use (Pareto k 2 to 4): what is left of the loop's change is many times its noise.

A figure that is 0 in some draws has no ratio. Loops that show so little hardly change at all, and
there the draws, moved to first order, are weighted (k 0.6 to 0.9).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hdprog.config.drive import DEFAULT_ALPHA
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.pareto_weights import pareto_weights, worth
from hdprog.inference.starting_points import StartingPoint, descend_all
from hdprog.physics.figures import FigureRequest, Operation, figures
from hdprog.physics.parameters import BY_NAME, NAMES, FloatArray
from hdprog.results import OtherToothAngle

if TYPE_CHECKING:
    from hdprog.inference.posterior import Posterior

OTHER_ALPHA = math.radians(20.0)
"""The other usual pressure angle beside the default of 30 degrees."""
_LEAST_WORTH = 20.0  # effective draws of a figure that is 0 in some of them


def with_other_tooth_angle(
    posterior: Posterior,
    requests: Sequence[FigureRequest],
    parameters: Mapping[str, Mapping[float, float]],
    told: Mapping[str, Mapping[float, float]],
) -> OtherToothAngle | None:
    """Numbers of a test as they would be with the other usual gear-tooth angle, `OTHER_ALPHA`.

    Parameters
    ----------
    posterior : of the test's loop, with the assumed angle
    requests : figures of merit
    parameters, told : quantiles of the parameters and figures with the assumed angle

    Returns
    -------
    None where no mode is found with the other angle
    """
    there_too = replace(posterior.likelihood, alpha=OTHER_ALPHA)
    modes = _modes(posterior.likelihood, there_too, posterior.best)
    if modes is None:
        return None
    here, there = (mode.point[:COUNT] for mode in modes)
    prior, shift = posterior.prior, there - here
    moved = {
        name: _moved(name, levels, float(shift[NAMES.index(name)]), prior.softplus_scale)
        for name, levels in parameters.items()
    }
    before = figures(requests, prior.to_physical(here[None, :]), posterior.operation)
    after = figures(requests, prior.to_physical(there[None, :]), _operation(posterior))
    found: dict[str, Mapping[float, float]] = {}
    for request in requests:
        key, levels = request.key, told[request.key]
        if min(*levels.values(), before[key][0], after[key][0]) > 0:
            ratio = float(after[key][0] / before[key][0])
            found[key] = {level: value * ratio for level, value in levels.items()}
    without_ratio = [request for request in requests if request.key not in found]
    if without_ratio:
        found |= _weighted(posterior, there_too, without_ratio, told)
    scaled = {request.key: found[request.key] for request in requests if request.key in found}
    return OtherToothAngle(OTHER_ALPHA, moved, scaled)


def _operation(posterior: Posterior) -> Operation:
    return replace(posterior.operation, alpha=OTHER_ALPHA)


def _weighted(
    posterior: Posterior,
    there: LoopLikelihood,
    requests: Sequence[FigureRequest],
    told: Mapping[str, Mapping[float, float]],
) -> dict[str, Mapping[float, float]]:
    """Quantiles of figures with the other angle, by weighted draws, moved to first order.

    None of them where the weights are worth too few draws.
    """
    here, points = posterior.likelihood, posterior.points
    moved = points.copy()
    moved[:, :COUNT] += first_order_shift(here.alpha, there.alpha)
    possible = there.supported(moved)
    points, moved = points[possible], moved[possible]
    if not len(points):
        return {}
    after = there.log_likelihood(moved) + there.log_prior(moved)
    weight, _ = pareto_weights(after - here.log_likelihood(points) - here.log_prior(points))
    if worth(weight) < _LEAST_WORTH:
        return {}
    values = figures(requests, posterior.prior.to_physical(moved[:, :COUNT]), _operation(posterior))
    return {
        request.key: {
            level: float(
                np.quantile(values[request.key], level, weights=weight, method="inverted_cdf")
            )
            for level in told[request.key]
        }
        for request in requests
    }


def first_order_shift(alpha: float, other: float) -> FloatArray:
    """(8,) shift of the unconstrained coordinates that leaves a loop nearly as it was."""
    shift = np.zeros(COUNT)
    shift[NAMES.index("K_W")] = 2 * math.log(math.tan(other) / math.tan(alpha))
    shift[NAMES.index("mu")] = math.log(math.tan(other) / math.tan(alpha))
    shift[NAMES.index("c")] = math.log(math.cos(other) / math.cos(alpha))
    return shift


def assumed(alpha: float, declared: bool) -> bool:
    """Whether a drive's tooth angle is the default, of which nobody has told anything."""
    return not declared and math.isclose(alpha, DEFAULT_ALPHA)


def _modes(
    here: LoopLikelihood, there: LoopLikelihood, best: FloatArray
) -> tuple[StartingPoint, StartingPoint] | None:
    """Modes under both angles that belong together: each is also sought from the other."""
    shift = np.zeros(here.size)
    shift[:COUNT] = first_order_shift(here.alpha, there.alpha)
    first = _lowest(there, [best + shift])
    if first is None:
        return None
    own = _lowest(here, [best, first.point - shift])
    if own is None:
        return None
    other = _lowest(there, [first.point, own.point + shift])
    return None if other is None else (own, other)


def _lowest(likelihood: LoopLikelihood, starts: list[FloatArray]) -> StartingPoint | None:
    found = descend_all(likelihood, starts)
    return min(found, key=lambda start: start.deviance, default=None)


def _moved(
    name: str, levels: Mapping[float, float], shift: float, softplus_scale: float
) -> dict[float, float]:
    parameter = BY_NAME[name]
    values = np.array(list(levels.values()))
    coordinates = parameter.to_coordinate(values, softplus_scale) + shift
    moved = parameter.from_coordinate(coordinates, softplus_scale)
    return dict(zip(levels, map(float, moved), strict=True))
