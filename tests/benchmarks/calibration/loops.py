"""Loops whose parameters come from the prior that they are fitted with.

Five kinds in equal parts. What tells them apart is the test's programme or the prior, never the
parameters that were drawn: to keep only draws with T_i above T_max, say, would be another prior
than the fit's, and ranks would not be uniform. So T_max is set low or high enough to lie on the
wanted side of T_i for nearly all draws (the summary counts for how many), and for T_T near 0 the
prior of T_T is another one, in the draw and in the fit alike.

The rest is what the likelihood assumes: a white angle error of unknown size, an arbitrary zero, a
slip before the first reading anywhere between its envelopes, and a torque without error.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.priors import Prior
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.parameters import NAMES, FloatArray, Parameters, in_support
from hdprog.physics.torque_path import TorquePath

SEED = 61
PRIOR = "csf-25-80"
ONE_SIDED, TWO_SIDED = "one-sided", "two-sided"
BELOW, ABOVE, EARLY = "T_max below T_i", "T_max above T_i", "T_T near 0"
KINDS = (ONE_SIDED, TWO_SIDED, BELOW, ABOVE, EARLY)
DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)

READINGS = (120, 400)
NOISE = (4e-6, 3e-5)  # rad, drawn evenly in the logarithm
OFFSET = 1e-3  # rad
LOADING_RATE = 2.0  # Nm/s
_TORQUES = {BELOW: (22.0, 36.0), ABOVE: (220.0, 255.0)}  # 2 SD of T_i's prior away from its median
_ANY_TORQUE = (45.0, 160.0)
_EARLY_MEAN, _EARLY_SD = -3.5, 1.0  # of T_T's coordinate: 0.3 Nm, and 90 % from 0.06 to 1.5 Nm
_LOOP, _FIT = range(2)  # streams of random numbers of one loop


@dataclass(frozen=True)
class Drawn:
    """A loop and what it was made from.

    Attributes
    ----------
    loop, prior : what the fit gets
    kind : of the loop
    one_sided, largest_torque : of its programme; Nm
    point : (9,) true point of the likelihood: coordinates and logit of the initial slip's fraction
    offset, noise : true angle offset and standard deviation of a reading, in rad
    """

    loop: Loop
    prior: Prior
    kind: str
    one_sided: bool
    largest_torque: float
    point: FloatArray
    offset: float
    noise: float

    @property
    def parameters(self) -> Parameters:
        """True parameters by name, (1,) each."""
        return self.prior.to_physical(self.point[None, : len(NAMES)])


@lru_cache(maxsize=len(KINDS))
def prior_of(kind: str) -> Prior:
    """The prior of a kind's draws and fits."""
    prior = read_prior_file(PRIOR).prior(None)
    if kind != EARLY:
        return prior
    mean, sd, at = prior.mean.copy(), prior.sd.copy(), NAMES.index("T_T")
    mean[at], sd[at] = _EARLY_MEAN, _EARLY_SD
    return replace(prior, name=f"{PRIOR}, T_T near 0", mean=mean, sd=sd)


def kind_of(index: int) -> str:
    """Kind of the loop with that number; the kinds take turns."""
    return KINDS[index % len(KINDS)]


def fit_rng(index: int, refit: int = 0) -> np.random.Generator:
    """Random numbers of a loop's fit, or of a further one with a planted fault."""
    return np.random.default_rng([SEED, index, _FIT, refit])


def draw(index: int) -> Drawn:
    """The loop with that number, always the same."""
    rng = np.random.default_rng([SEED, index, _LOOP])
    kind = kind_of(index)
    prior = prior_of(kind)
    coordinates = _supported(prior, rng)
    fraction = float(rng.uniform())
    one_sided = {ONE_SIDED: True, TWO_SIDED: False}.get(kind, bool(rng.random() < 0.5))
    low, high = _TORQUES.get(kind, _ANY_TORQUE)
    largest = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    time, torque, clean = _programme(
        prior.to_physical(coordinates[None, :]),
        fraction,
        largest,
        one_sided=one_sided,
        cycles=int(rng.integers(1, 3)),
        readings=int(rng.integers(READINGS[0], READINGS[1] + 1)),
    )
    noise = float(np.exp(rng.uniform(*np.log(NOISE))))
    offset = float(rng.uniform(-OFFSET, OFFSET))
    loop = Loop(
        torque=torque,
        angle=offset + clean + noise * rng.standard_normal(clean.size),
        time=time,
    )
    point = np.append(coordinates, np.log(fraction / (1 - fraction)))
    return Drawn(loop, prior, kind, one_sided, largest, point, offset, noise)


def _supported(prior: Prior, rng: np.random.Generator) -> FloatArray:
    """Coordinates (8,) from the prior inside the hard support, as the posterior sees it."""
    while True:
        coordinates = prior.sample(1, rng)
        if in_support(prior.to_physical(coordinates), DRIVE.alpha).all():
            return np.asarray(coordinates[0])


def _programme(
    parameters: Parameters,
    fraction: float,
    largest: float,
    *,
    one_sided: bool,
    cycles: int,
    readings: int,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Time, torque and angle without noise at evenly spaced readings, (readings,) in s, Nm, rad.

    The turning points, which fall between readings, are part of the history all the same.
    """
    turns = [0.0]
    for _ in range(cycles):
        turns += [largest, 0.0] if one_sided else [largest, -largest]
    turns += [] if one_sided else [largest]
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))])
    at = np.linspace(0.0, travel[-1], readings)
    every = np.union1d(at, travel)
    path = TorquePath.exact(np.interp(every, travel, turns))
    angle = torsion_angle(path, parameters, DRIVE.alpha, initial_fraction=np.array([fraction]))[0]
    chosen = np.searchsorted(every, at)
    return at / LOADING_RATE, path.torque[chosen], angle[chosen]
