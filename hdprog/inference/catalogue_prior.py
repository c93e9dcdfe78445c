"""How the prior of the eight parameters follows from a maker's catalogue.

A catalogue gives five numbers of a gear: the slope K1 of torque over torsion up to a torque T1, K2
to T2 and K3 above. They fix a prior of eight parameters only together with one that was identified
on a gear. That one is priors/csf-25-80.toml, resting on Table 2 of the compliance-and-hysteresis
model (a CSF-25-80 new and after 100 h at rated load). Three steps lead from it to any other gear.

1. Similarity. Torques go with T2, stiffnesses with K = (K1 K2 K3)^(1/3), both relative to the
   catalogue's own numbers of the CSF-25-80:

       K_F, K_W, b ~ K      a ~ K/T2      T_i, scale of T_T ~ T2      c, mu as they are

   Preload comes from how far the wave generator bends the flexspline. That goes with the size and
   not with the ratio, and so do T1 and T2 in the catalogue, while the rated torque changes with
   ratio and series. Friction at no load is mu |c| T_i: it scales with torque. No catalogue
   figure of hysteresis enters.

2. Stiffness. The medians of K1, K2 and K3 over the prior become those of the catalogue, which are
   averages over many new gears (maker's engineering data). At low torque the slope is that of three
   springs in series, 1/K_F + tan²α/K_W + 1/b, at high torque b gives way to a T_T + b (17, 24).
   Five medians (K_F, K_W, a, b, T_T) for three numbers: they move as little as they can, each
   counted in its own standard deviations z,

       minimise  Σ z² + Σ (log of median/catalogue)² / 0.05²       (α = 30°)

   where 0.05 lets catalogue numbers, rounded to two digits, be met to about that. So a prior is
   the identified one where the catalogue says nothing.

3. Widths. Those of csf-25-80: wide enough to hold Table 2's new and its worn gear and one worn
   further, since a drive that is tested may be either. The width of T_T alone grows, from 2 to 2.5:
   the catalogue's gears stiffen up to T2 or beyond, Table 2's new one not at all.

csf-25-80.toml itself is not moved: its medians lie between the new and the worn state of the very
gear it is named after, so that its K1, K2 and K3 are 0.8, 0.6 and 0.5 of the catalogue's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from hdprog.config.drive import DEFAULT_ALPHA
from hdprog.inference.catalogue import CatalogueGear, CatalogueNumbers
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.prior_schema import PriorFile
from hdprog.inference.priors import Prior, even_draws
from hdprog.physics.figures import Operation, catalogue_stiffness
from hdprog.physics.parameters import NAMES, FloatArray

ANCHOR = "csf-25-80"
"""The prior that was identified on a gear and that all others are scaled from."""
TORQUE_REACH = 63.0 / 48.0
"""How far K3 is taken beyond T2: to the rated torque of a CSF-25-80, over its T2."""
WIDTH_OF_THRESHOLD = 2.5
TOLERANCE = 0.05
_MOVED = ("K_F", "K_W", "a", "b", "T_T")
_INDEX = [NAMES.index(name) for name in _MOVED]
_BINARY_LOG = 12  # of the number of draws
_STEP = 0.1  # of the derivative, in standard deviations: far above the grain of a median
_MOST_STEPS = 60
_DIGITS = 3


def operation_of_catalogue(numbers: CatalogueNumbers) -> Operation:
    """Torques at which a catalogue's stiffness is read."""
    top = TORQUE_REACH * numbers.T2
    return Operation(DEFAULT_ALPHA, top, top, (numbers.T1, numbers.T2))


def catalogue_prior(name: str, numbers: CatalogueNumbers, source: str) -> PriorFile:
    """Prior file of a gear of which the catalogue's numbers are known.

    Parameters
    ----------
    name : of the prior
    numbers : torques and stiffnesses, checked
    source : where they come from, in words

    Returns
    -------
    PriorFile
        medians to three significant digits
    """
    anchor = _anchor()
    moved = centred(scaled(anchor.prior, anchor.numbers, numbers), numbers)
    parameters: dict[str, Any] = {}
    for index, parameter in enumerate(NAMES):
        sd = float(moved.sd[index])
        if parameter == "T_T":
            parameters[parameter] = {
                "scale_Nm": _round(moved.softplus_scale),
                "coordinate_mean": round(float(moved.mean[index]), 2),
                "coordinate_sd": sd,
            }
        else:
            median = float(moved.to_physical(moved.mean)[parameter])
            parameters[parameter] = {"median": _round(median), "log_sd": sd}
    return PriorFile.model_validate(
        {
            "name": name,
            "source": f"{source}; similarity to {ANCHOR} (Table 2 of the compliance-and-hysteresis "
            "model), whose widths it keeps but for a wider T_T",
            "parameters": parameters,
            "catalogue": numbers.table,
        }
    )


def source_of_gear(gear: CatalogueGear) -> str:
    """Where the numbers of an entry of the catalogue come from, in words."""
    return f"Stiffness of {gear.words}: {gear.source}"


def prior_of_gear(gear: CatalogueGear) -> PriorFile:
    """Prior file of an entry of the catalogue."""
    return catalogue_prior(gear.name, gear.numbers, source_of_gear(gear))


def scaled(prior: Prior, own: CatalogueNumbers, other: CatalogueNumbers) -> Prior:
    """Similarity: the prior of a gear with other catalogue numbers, of the same shape."""
    torque = other.T2 / own.T2
    stiffness = math.prod(
        (theirs / ours) ** (1 / 3)
        for theirs, ours in ((other.K1, own.K1), (other.K2, own.K2), (other.K3, own.K3))
    )
    factors: Mapping[str, float] = {
        "K_F": stiffness,
        "K_W": stiffness,
        "a": stiffness / torque,
        "b": stiffness,
        "T_i": torque,
    }
    mean = prior.mean + np.log([factors.get(name, 1.0) for name in NAMES])
    sd = prior.sd.copy()
    sd[NAMES.index("T_T")] = WIDTH_OF_THRESHOLD
    return replace(prior, mean=mean, sd=sd, softplus_scale=prior.softplus_scale * torque)


def median_stiffness(prior: Prior, numbers: CatalogueNumbers) -> FloatArray:
    """Medians (3,) of K1, K2 and K3 over a prior, in Nm/rad."""
    parameters = prior.to_physical(prior.mean + prior.sd * even_draws(_BINARY_LOG))
    operation = operation_of_catalogue(numbers)
    slopes = [catalogue_stiffness(index, parameters, operation) for index in (1, 2, 3)]
    return np.asarray(np.median(slopes, axis=1))


def centred(prior: Prior, numbers: CatalogueNumbers) -> Prior:
    """Move medians as little as possible until those of K1, K2 and K3 are the catalogue's.

    Damped Gauss-Newton steps on the shifts z, in standard deviations.
    """
    wanted = np.array([numbers.K1, numbers.K2, numbers.K3])

    def moved(z: FloatArray) -> Prior:
        mean = prior.mean.copy()
        mean[_INDEX] += prior.sd[_INDEX] * z
        return replace(prior, mean=mean)

    def misfit(z: FloatArray) -> FloatArray:
        return np.asarray(np.log(median_stiffness(moved(z), numbers) / wanted) / TOLERANCE)

    def cost(z: FloatArray, missed: FloatArray) -> float:
        return float(missed @ missed + z @ z)

    identity = np.eye(len(_MOVED))
    z, damping = np.zeros(len(_MOVED)), 1.0
    missed = misfit(z)
    lowest = cost(z, missed)
    for _ in range(_MOST_STEPS):
        rows = [(misfit(z + _STEP * e) - misfit(z - _STEP * e)) / (2 * _STEP) for e in identity]
        slope = np.array(rows).T
        curvature, gradient = slope.T @ slope + identity, slope.T @ missed + z
        gained = 0.0
        while damping < 1e6:
            damped = curvature + damping * np.diag(np.diag(curvature))
            tried = z - np.linalg.solve(damped, gradient)
            tried_misfit = misfit(tried)
            gained = lowest - cost(tried, tried_misfit)
            if gained > 0:
                z, missed, lowest = tried, tried_misfit, lowest - gained
                damping = max(damping / 3, 1e-3)
                break
            damping *= 3
        if gained < 1e-4:
            break
    return moved(z)


@dataclass(frozen=True)
class _Anchor:
    prior: Prior
    numbers: CatalogueNumbers


@cache
def _anchor() -> _Anchor:
    file = read_prior_file(ANCHOR)
    table = file.catalogue_table
    numbers = CatalogueNumbers(
        table["T1_Nm"],
        table["T2_Nm"],
        table["K1_Nm_per_rad"],
        table["K2_Nm_per_rad"],
        table["K3_Nm_per_rad"],
    )
    return _Anchor(file.prior(None), numbers)


def _round(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
