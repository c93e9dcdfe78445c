"""What a record tells of the parameters one by one, and what it knows of them only together.

Two states of a drive leave parameters that no loop can tell apart:

* The teeth are in mesh from the first torque on (T_T near 0, a new drive). Cup and teeth then act
  as one spring, 1/K = 1/K_F + 1/b (38); a is not seen at all. With a threshold above 0 the spring
  of cup and meshed teeth is 1/K = 1/K_F + 1/(a·T_T + b), the same where T_T is 0.
* The record stays below the preload torque T_i. It then shows how friction falls with torque, not
  where it stops falling: the friction at no load, −c·μ·T_i, is known, its factors less.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hdprog.inference.priors import Prior, even_draws
from hdprog.physics.parameters import FloatArray, Parameters
from hdprog.results import Combination, Identification, by_level

if TYPE_CHECKING:
    from hdprog.inference.posterior import Posterior

_ALONE = 0.5  # of its logarithm's spread: K is known so much better than each of its parts
_UNSEEN = 0.25  # contraction of a below which no stiffening of the teeth was seen
_QUASI_RANDOM = 10  # binary logarithm of the points that stand for the prior


def combined_stiffness(parameters: Parameters) -> FloatArray:
    """Stiffness of cup and meshed teeth in series in Nm/rad (38), shape of the parameters."""
    mesh = parameters["a"] * parameters["T_T"] + parameters["b"]
    return np.asarray(1 / (1 / parameters["K_F"] + 1 / mesh))


def no_load_friction(parameters: Parameters) -> FloatArray:
    """−c·μ·T_i in Nm, shape of the parameters: what preload and friction are known by."""
    return np.asarray(-parameters["c"] * parameters["mu"] * parameters["T_i"])


def identification(posterior: Posterior) -> Identification:
    """What the record of a posterior tells, and what it leaves to the prior."""
    parameters = posterior.parameters
    stiffness = combined_stiffness(parameters)
    spread = float(np.log(stiffness).std())
    parts = min(float(np.log(parameters[name]).std()) for name in ("K_F", "b"))
    largest = posterior.record_course.scales.torque
    prior = prior_points(posterior.prior)
    return Identification(
        largest_torque=largest,
        beyond_record=float(np.mean(parameters["T_i"] > largest)),
        one_spring=posterior.contraction["a"] < _UNSEEN and spread < _ALONE * parts,
        combined_stiffness=_combination(stiffness, combined_stiffness(prior)),
        no_load_friction=_combination(no_load_friction(parameters), no_load_friction(prior)),
    )


def prior_points(prior: Prior) -> Parameters:
    """Quasi-random points of a prior, by name, (1024,) each: the same at every call."""
    return prior.to_physical(prior.mean + prior.sd * even_draws(_QUASI_RANDOM))


def _combination(posterior: FloatArray, prior: FloatArray) -> Combination:
    ratio = float(np.log(posterior).var() / np.log(prior).var())
    return Combination(by_level(posterior), 1 - ratio)
