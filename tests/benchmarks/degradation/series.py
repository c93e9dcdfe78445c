"""Published series, and one of their readings as the trend takes a test.

A reading informs one number of the state and leaves the others alone: the coordinate of T_i, which
enters the trend as it is. It counts in units of the way from where a unit begins to where it fails.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from hdprog.inference.information import Linearised
from hdprog.inference.priors import Prior
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.wear_prior import Loading, LogNormal, WearPrior, WearRate, read_wear_prior
from tests.trend.stand_in import PRIOR

AT = NAMES.index("T_i")
_READING_ERROR = 1e-3  # of a reading by itself; its scatter is learnt


@dataclass(frozen=True)
class Study:
    """One published set of series.

    Attributes
    ----------
    name, file : of the data
    unit, time, value : columns
    start, failure : values at which a unit begins and fails; `failure` is a scale where `fails` is
        false
    planned : time that the test was planned for, in its own unit
    known : readings of a unit that the forecast is told
    """

    name: str
    file: str
    unit: str
    time: str
    value: str
    start: float
    failure: float
    planned: float
    known: int
    fails: bool = True


STUDIES = (
    Study("GaAs lasers", "gaaslaser.csv", "unit", "hours", "increase", 0.0, 10.0, 4000.0, 7),
    Study("Alloy-A cracks", "alloya.csv", "specimen", "megacycles", "inches", 0.9, 1.6, 0.12, 6),
    Study(
        "metal wear", "metalwear.csv", "unit", "cycles", "microns", 0.0, 20.0, 500.0, 4, fails=False
    ),
)


@dataclass(frozen=True)
class Series:
    """One unit: times (n,) and values (n,) in units of the way to failure."""

    unit: str
    times: FloatArray
    values: FloatArray

    def crossing(self) -> float:
        """Time at which the series, straight between its readings, reaches failure; inf if never.

        Past its last reading nothing is known.
        """
        over = np.flatnonzero(self.values >= 1.0)
        if over.size == 0:
            return np.inf
        at = int(over[0])
        if at == 0:
            return float(self.times[0])
        share = (1.0 - self.values[at - 1]) / (self.values[at] - self.values[at - 1])
        return float(self.times[at - 1] + share * (self.times[at] - self.times[at - 1]))


def read_series(study: Study, folder: Path) -> list[Series]:
    """Every unit of a study."""
    table = pd.read_csv(folder / study.file)
    found = []
    for unit, rows in table.groupby(study.unit):
        rows = rows.sort_values(study.time)
        values = (rows[study.value].to_numpy(float) - study.start) / (study.failure - study.start)
        found.append(Series(f"{unit:g}", rows[study.time].to_numpy(float), values))
    return found


@dataclass(frozen=True)
class Reading:
    """A reading as the trend takes a test; see `hdprog.trend.evidence.LoopEvidence`."""

    service_hours: float
    value: float
    prior: Prior
    event: str | None = None
    load_hours: float | None = None
    temperature_C: float | None = None
    exact: None = None

    @property
    def posterior(self) -> FloatArray:
        """The prior's centre with the reading in its place."""
        point = self.prior.mean.copy()
        point[AT] = self.value
        return point[None]

    def linearise(self, coordinates: FloatArray) -> Linearised:
        """Exact: the reading is a Gaussian."""
        precision, information = np.zeros((len(NAMES), len(NAMES))), np.zeros(len(NAMES))
        precision[AT, AT] = _READING_ERROR**-2
        information[AT] = self.value / _READING_ERROR**2
        missed = (self.value - coordinates[AT]) / _READING_ERROR
        return Linearised(precision, information, -0.5 * float(missed**2))


def readings(series: Series, count: int, prior: Prior) -> list[Reading]:
    """The first few readings of a unit."""
    each = zip(series.times[:count], series.values[:count], strict=True)
    return [Reading(float(time), float(value), prior) for time, value in each]


def state_prior() -> Prior:
    """Where a unit begins: anywhere within a way to failure of zero."""
    mean, sd = PRIOR.mean.copy(), PRIOR.sd.copy()
    mean[AT], sd[AT] = 0.0, 1.0
    return replace(PRIOR, mean=mean, sd=sd)


def wear_prior(study: Study) -> WearPrior:
    """The shipped wear prior for a number that counts in ways to failure.

    One unit of wear is one way to failure. Pace: failure within the planned time, give or take a
    factor of 4.5. Scatter of readings: one per cent of the way, give or take a factor of 2.7. It
    drifts as any coordinate does, not as preload. There are no teeth at whose end wear would end.
    All else is as shipped.
    """
    shipped = read_wear_prior()
    return shipped.model_copy(
        update={
            "loadings": shipped.loadings | {"T_i": Loading(mean=1.0, sd=1e-3)},
            "wear_rate": WearRate(median=1.0, log_sd=1.5, reference_hours=study.planned),
            "drift_scale": shipped.drift_scale | {"T_i": 1.0},
            "scatter_scale": shipped.scatter_scale | {"T_i": 1.0},
            "remounting_scatter": LogNormal(median=0.01, log_sd=1.0),
            "preload_volatility": shipped.own_volatility,
            "worn_out": {},
        }
    )
