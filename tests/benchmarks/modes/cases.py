"""Ten loops whose posteriors are hard to sample, each for another reason.

Those with a number are loops of the calibration benchmark, drawn from the prior that they are
fitted with. They were found by scanning seven hundred of them: for several starts of similar mass,
for long autocorrelation times, and for valleys in the marginals of a small population (`annealed`).
The others are made for what their names say. Everything is seeded: a case is the same every time.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hdprog.data.loop import Loop
from hdprog.inference.priors import Prior
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.physics.torque_path import TorquePath
from tests.benchmarks.calibration.loops import DRIVE, LOADING_RATE, TWO_SIDED, draw, prior_of

SEED = 67
_WORN = (78000.0, 98549.0, 1833.5, 14000.0, 30.0, -1.152, 70.2, 0.076)
_NEW = (78000.0, 101838.0, 2600.0, 120000.0, 1.2, -1.177, 115.5, 0.066)
"""In the order of `NAMES`, SI: a CSF-25-80 after 100 h and new, as the prior's source has them."""


@dataclass(frozen=True)
class Case:
    """A hard loop.

    Attributes
    ----------
    name : for files and tables
    why : what makes it hard
    make : gives the record and its prior
    cut : coordinate and value that part its modes where no valley does; None for valleys alone
    """

    name: str
    why: str
    make: Callable[[], tuple[Loop, Prior]]
    cut: tuple[str, float] | None = None

    def rng(self, stream: int) -> np.random.Generator:
        """Random numbers of the case; one stream for each thing done with it."""
        return np.random.default_rng([SEED, zlib.crc32(self.name.encode()), stream])


def _drawn(index: int) -> Callable[[], tuple[Loop, Prior]]:
    def make() -> tuple[Loop, Prior]:
        drawn = draw(index)
        return drawn.loop, drawn.prior

    return make


def _made(
    parameters: tuple[float, ...],
    turns: list[float],
    readings: int,
    noise: float,
    *,
    fraction: float = 0.5,
    drift: tuple[float, float] | None = None,
) -> Callable[[], tuple[Loop, Prior]]:
    """A record of known parameters.

    Parameters
    ----------
    parameters : in the order of `NAMES`, SI
    turns : torques in Nm between which torque is ramped
    readings : evenly spaced, the turning points mostly between them
    noise : standard deviation of a reading's white error in rad
    fraction : of the initial slip
    drift : standard deviation in rad and decay in s of an Ornstein-Uhlenbeck error beside it
    """

    def make() -> tuple[Loop, Prior]:
        travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))])
        at = np.linspace(0.0, travel[-1], readings)
        every = np.union1d(at, travel)
        path = TorquePath.exact(np.interp(every, travel, turns))
        values = {name: np.array([value]) for name, value in zip(NAMES, parameters, strict=True)}
        whole = torsion_angle(path, values, DRIVE.alpha, initial_fraction=np.array([fraction]))[0]
        chosen = np.searchsorted(every, at)
        time = at / LOADING_RATE
        rng = np.random.default_rng([SEED, readings, len(turns)])
        angle = whole[chosen] + noise * rng.standard_normal(readings)
        if drift is not None:
            angle = angle + _wander(time, *drift, rng)
        return Loop(torque=path.torque[chosen], angle=angle, time=time), prior_of(TWO_SIDED)

    return make


def _wander(time: FloatArray, sd: float, decay: float, rng: np.random.Generator) -> FloatArray:
    """An Ornstein-Uhlenbeck error at evenly spaced times (readings,)."""
    kept = np.exp(-(time[1] - time[0]) / decay)
    pushes = sd * rng.standard_normal(time.size)
    error = np.empty(time.size)
    error[0] = pushes[0]
    for index in range(1, time.size):
        error[index] = kept * error[index - 1] + np.sqrt(1 - kept**2) * pushes[index]
    return error


def _two_sided(largest: float, cycles: int) -> list[float]:
    return [0.0, *([largest, -largest] * cycles), largest]


CASES: tuple[Case, ...] = (
    Case(
        "threshold-near-zero",
        "T_T near 0 by the prior (calibration loop 624): where the teeth's threshold is passed at "
        "once, a, b and T_T trade places along a curve, and the friction has two stories.",
        _drawn(624),
    ),
    Case(
        "threshold-near-largest-torque",
        "T_T at 97 % of T_max: the kink lies among the last readings or outside the record (T_T "
        "beyond 60 Nm), where a flat shoulder reaches as far as the prior lets it.",
        _made((*_WORN[:4], 58.2, *_WORN[5:]), _two_sided(60.0, 1), 240, 1.2e-5),
        cut=("T_T", 6.0),
    ),
    Case(
        "largest-torque-below-T_i",
        "T_max below T_i (calibration loop 137): the friction's fall is not seen to its end, the "
        "torque at which the initial slip is left falls between two readings or behind them.",
        _drawn(137),
    ),
    Case(
        "few-readings",
        "Two cycles of 11 readings with little noise: a kink lies anywhere between two readings, "
        "and which two is a mode of its own.",
        _made(_WORN, [0.0, 60.0, -60.0, 60.0, -60.0], 22, 2e-6),
    ),
    Case(
        "coarse-noise",
        "Noise as large as the hysteresis: the posterior is the prior in several parameters, with "
        "its long tails, and the sum of stiffnesses is fixed all the same.",
        _made(_WORN, _two_sided(45.0, 1), 150, 2e-4),
    ),
    Case(
        "new-drive-fine-noise",
        "A new drive, T_T at 2 % of T_max, with noise of 0.2 µrad: K_F, a, b and T_T are bound to "
        "a thin bent sheet.",
        _made(_NEW, _two_sided(60.0, 1), 280, 2e-7),
    ),
    Case(
        "one-sided",
        "A one-sided record that ends above T_i (calibration loop 560): the torque at which the "
        "slip sets in is either of two, 400 autocorrelation steps apart.",
        _drawn(560),
    ),
    Case(
        "two-T_i",
        "Two values of T_i, each with a third or more of the mass (calibration loop 463): the "
        "friction's end lies at the record's top or far below it.",
        _drawn(463),
    ),
    Case(
        "small-far-mode",
        "A mode at T_i of 15 to 35 Nm with a few parts in a hundred of the mass beside a broad one "
        "(calibration loop 37): a short run sees it with few walkers or none.",
        _drawn(37),
    ),
    Case(
        "correlated-noise",
        "White noise with a drift that remembers 6 s: the likelihood is whitened by a full matrix, "
        "and slow friction and drift explain each other.",
        _made(_WORN, [0.0, 40.0, 0.0, 40.0, 0.0], 260, 4e-6, drift=(8e-6, 6.0)),
    ),
)
