"""Clocks: from service hours to equivalent hours, and from those to wear."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hdprog.data.loads_of_tests import drives_of_stretches
from hdprog.data.tests_table import DriveTest
from hdprog.physics.parameters import FloatArray
from hdprog.results import since_replaced
from hdprog.trend.evidence import LoopEvidence

_LARGEST_LOG = 10.0  # wear beyond e^10 units is beyond anything that a figure could show
_STRAIGHT = 1e-9


def hours_by_load(
    service_hours: Sequence[float],
    mean_torque: Sequence[float | None],
    mean_speed: Sequence[float | None],
    replaced: Sequence[bool] | None = None,
) -> tuple[float, ...] | None:
    """Hours in which the drive's mean load wears as much as the loads that it had.

    Each stretch counts Δt·T³·n, the rule by which makers rate the life of the wave generator's
    bearing (Harmonic Drive CSF/CSG catalogue, service life), scaled so that all stretches together
    count the hours served: rated torque and speed, constant factors, are then not needed. A drive
    that was replaced, of which a stretch has no torque, counts the hours that it served.

    Parameters
    ----------
    service_hours : hours at the tests, rising
    mean_torque, mean_speed : load in Nm and rpm since the test before (the first: since zero
        hours), None where it is not known; speed counts where every stretch that counts has it
    replaced : whether the drive was replaced before each test; None where it never was

    Returns
    -------
    hours since zero at the tests; None where the torque of a stretch of the last drive is not known
    """
    served = np.diff(np.asarray(service_hours, dtype=float), prepend=0.0)
    torque = np.array([np.nan if one is None else one for one in mean_torque])
    speed = np.array([np.nan if one is None else one for one in mean_speed])
    drives = drives_of_stretches([False] * served.size if replaced is None else replaced)
    own, ran = np.array(drives[:-1]), served > 0
    lacking = set(own[ran & np.isnan(torque)])
    loaded = ran & ~np.isin(own, list(lacking))
    if not loaded.any() or drives[-1] in lacking:
        return None
    pace = np.abs(torque[loaded]) ** 3
    if not np.isnan(speed[loaded]).any():
        pace *= np.abs(speed[loaded])
    counted = served.copy()
    counted[loaded] *= pace
    if not counted[loaded].sum() > 0:
        return None
    counted[loaded] *= served[loaded].sum() / counted[loaded].sum()
    return tuple(np.cumsum(counted))


def load_hours_of(tests: Sequence[DriveTest]) -> Sequence[float | None]:
    """`hours_by_load` of tests in order of service hours; None for each where there are none."""
    by_load = hours_by_load(
        [test.service_hours for test in tests],
        [test.mean_torque_Nm for test in tests],
        [test.mean_speed_rpm for test in tests],
        [test.event == "replaced" for test in tests],
    )
    return [None] * len(tests) if by_load is None else by_load


def pace_of_load(load: float) -> float:
    """Pace of wear under a torque that is `load` times another, over the pace under that.

    The makers' rule of `hours_by_load`, speed staying as it is.
    """
    return load**3


def load_of_pace(pace: float) -> float:
    """Torque over another, given the pace of wear over that under it: `pace_of_load` inverted."""
    return float(pace ** (1.0 / 3.0))


@dataclass(frozen=True)
class ServiceClock:
    """Map from service hours to hours by load.

    Between tests it is linear; past the last it goes on at the mean pace so far, of a drive that
    replaced another that since then: what the other was loaded with says little of what is to come.

    Attributes
    ----------
    service, equivalent : (knots,) matching hours, from zero
    by_load : whether the load is known; else the two are the same
    pace : mean pace so far; one where the load is not known
    load_factor : pace past the last test over the mean pace so far
    """

    service: FloatArray
    equivalent: FloatArray
    by_load: bool
    pace: float = 1.0
    load_factor: float = 1.0

    @staticmethod
    def of(tests: Sequence[LoopEvidence]) -> ServiceClock:
        """Clock of tests in order; by load only where every test gives it and it rises."""
        service = np.array([test.service_hours for test in tests])
        loads = [test.load_hours for test in tests]
        known = [load for load in loads if load is not None]
        if len(known) == len(loads) and known[-1] > 0 and np.all(np.diff(known) >= 0):
            equivalent, by_load = np.array(known), True
        else:
            equivalent, by_load = service, False
        service, equivalent = np.insert(service, 0, 0.0), np.insert(equivalent, 0, 0.0)
        own = since_replaced(tests)
        begins = len(tests) - len(own) + 1 if own[0].event == "replaced" else 0
        # Of a drive that has not run yet, the one before it tells.
        for first in (begins, 0):
            served, counted = service[-1] - service[first], equivalent[-1] - equivalent[first]
            if served > 0 and counted > 0:
                return ServiceClock(service, equivalent, by_load, float(counted / served))
        return ServiceClock(service, equivalent, by_load)

    def slowed(self, load_factor: float) -> ServiceClock:
        """Give the clock another pace past the last test, e.g. 0.8³ of it at 80 % torque."""
        return replace(self, load_factor=load_factor)

    @property
    def pace_of_late(self) -> float:
        """Pace between the last two tests that service lies between, over the mean pace so far."""
        served, counted = np.diff(self.service), np.diff(self.equivalent)
        ran = np.flatnonzero(served > 0)
        return float(counted[ran[-1]] / served[ran[-1]] / self.pace) if ran.size else 1.0

    @property
    def counts_load(self) -> bool:
        """Whether hours by load differ from those served: by the load so far, or that to come."""
        return self.by_load or self.load_factor != 1.0

    def __call__(self, hours: FloatArray) -> FloatArray:
        """Hours by load at service hours (any shape)."""
        last = self.service[-1]
        beyond = np.maximum(np.asarray(hours, dtype=float) - last, 0.0)
        return np.asarray(
            np.interp(hours, self.service, self.equivalent) + self.pace * self.load_factor * beyond
        )


@dataclass(frozen=True)
class WearClock:
    """Wear over hours: a power law that may level off or feed on itself.

        u = A·(t/h)^p,   w = (1 − e^{−κu})/κ   (w = u where κ = 0)

    A power of time is the usual time scale of wear and degradation (Whitmore & Schenkelberg,
    Lifetime Data Analysis 3, 1997); κ > 0 lets it level off at 1/κ, κ < 0 accelerate.

    Attributes
    ----------
    rate, exponent, curvature : (draws,) A, p, κ
    reference_hours : h
    """

    rate: FloatArray
    exponent: FloatArray
    curvature: FloatArray
    reference_hours: float

    def expected(self, hours: FloatArray) -> FloatArray:
        """Power law u, (draws, times), at hours of age (times,) or (draws, times)."""
        age = np.maximum(np.asarray(hours, dtype=float), 0.0) / self.reference_hours
        with np.errstate(divide="ignore"):
            log_age = np.log(age)
        exponent = np.log(self.rate)[:, None] + self.exponent[:, None] * log_age
        return np.asarray(np.exp(np.minimum(exponent, _LARGEST_LOG)))

    def level(self, expected: FloatArray) -> FloatArray:
        """Wear w, (draws, times), from u (draws, times)."""
        kappa = np.broadcast_to(self.curvature[:, None], expected.shape)
        safe = np.where(np.abs(kappa) > _STRAIGHT, kappa, 1.0)
        bent = -np.expm1(np.minimum(-safe * expected, _LARGEST_LOG)) / safe
        return np.where(np.abs(kappa) > _STRAIGHT, bent, expected)
