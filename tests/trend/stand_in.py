"""A stand-in for the loop's likelihood: simulated loops, finite-difference sensitivities."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hdprog.inference.priors import Prior
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.parameters import in_support
from hdprog.physics.torque_path import TorquePath
from hdprog.trend.exact_likelihood import Nuisances

ALPHA = np.radians(30.0)
NOISE = 1e-5
PRIOR = Prior(
    "test",
    mean=np.array(
        [*np.log([78e3, 1e5, 1800, 25600]), 0.5, *np.log([1.16, 90, 0.07])],
    ),
    sd=np.array([0.4, 0.35, 1.0, 1.2, 2.0, 0.25, 0.45, 0.5]),
    softplus_scale=10.0,
    source="the tests",
)
STEP = 1e-4


def loop_torque(top: float, points: int = 200) -> np.ndarray:
    """A preconditioned symmetric cycle: 0, top, −top, top; the last two stretches measured."""
    up = np.linspace(-top, top, points // 2)
    return np.concatenate([[0.0, top], up[::-1][1:], up[1:]])


@dataclass(frozen=True)
class Information:
    precision: np.ndarray
    information: np.ndarray
    log_likelihood: float


@dataclass(frozen=True)
class KnownNoise:
    """The exact likelihood of a simulated loop, which has no numbers of its own."""

    loop: SimulatedLoop

    def about(self, coordinates: np.ndarray) -> tuple[KnownNoise, Nuisances]:
        return self, Nuisances.none(coordinates.size)

    def log_likelihood(self, coordinates: np.ndarray, nuisances: np.ndarray) -> np.ndarray:
        density = self.loop.log_likelihood(coordinates)
        return np.where(np.isfinite(density), density, -np.inf)


@dataclass(frozen=True)
class SimulatedLoop:
    """Evidence from a simulated loop; offset integrated out, noise known."""

    service_hours: float
    torque: np.ndarray
    angle: np.ndarray
    event: str | None = None
    load_hours: float | None = None
    temperature_C: float | None = None
    prior: Prior = PRIOR
    start: np.ndarray | None = None
    draws: np.ndarray | None = field(default=None)

    @cached_property
    def path(self) -> TorquePath:
        return TorquePath.exact(self.torque)

    def residual(self, points: np.ndarray) -> np.ndarray:
        model = torsion_angle(self.path, self.prior.to_physical(points), ALPHA)
        rest = (self.angle - model) / NOISE
        return rest - rest.mean(axis=1, keepdims=True)

    def log_likelihood(self, points: np.ndarray) -> np.ndarray:
        inside = in_support(self.prior.to_physical(points), ALPHA)
        with np.errstate(all="ignore"):
            rest = self.residual(points)
        return np.where(inside, -0.5 * np.sum(rest**2, axis=1), -np.inf)

    @property
    def exact(self) -> KnownNoise:
        return KnownNoise(self)

    def linearise(self, coordinates: np.ndarray) -> Information:
        shift = STEP * np.eye(8)
        points = np.concatenate([coordinates[None], coordinates + shift, coordinates - shift])
        rest = self.residual(points)
        jacobian = (rest[9:] - rest[1:9]).T / (2 * STEP)
        precision = jacobian.T @ jacobian
        slope = jacobian.T @ rest[0]
        height = float(self.log_likelihood(coordinates[None])[0])
        return Information(precision, precision @ coordinates + slope, height)

    @cached_property
    def own_mode(self) -> tuple[np.ndarray, np.ndarray]:
        """Mode and covariance of the loop's own posterior, the best of a few damped climbs."""
        from scipy.optimize import least_squares

        def residual(x: np.ndarray) -> np.ndarray:
            with np.errstate(all="ignore"):
                rest = self.residual(x[None])[0]
            both = np.concatenate([rest, (x - self.prior.mean) / self.prior.sd])
            return np.nan_to_num(both, nan=1e6, posinf=1e6, neginf=-1e6)

        best = None
        starts = [self.prior.mean] if self.start is None else [self.start, self.prior.mean]
        for start in starts:
            found = least_squares(residual, start, method="lm", max_nfev=400)
            if best is None or found.cost < best.cost:
                best = found
        return best.x, np.linalg.inv(best.jac.T @ best.jac)

    @property
    def posterior(self) -> np.ndarray:
        if self.draws is not None:
            return self.draws
        mode, covariance = self.own_mode
        rng = np.random.default_rng(0)
        return rng.multivariate_normal(mode, covariance, 200, method="cholesky")


def simulated_loop(
    hours: float,
    coordinates: np.ndarray,
    rng: np.random.Generator,
    top: float = 63.0,
    points: int = 200,
    **others: object,
) -> SimulatedLoop:
    """Measure a drive with the given coordinates, noise and an encoder's offset added."""
    torque = loop_torque(top, points)
    clean = torsion_angle(TorquePath.exact(torque), PRIOR.to_physical(coordinates[None]), ALPHA)[0]
    angle = clean + NOISE * rng.standard_normal(clean.size) + 1e-3 * rng.standard_normal()
    return SimulatedLoop(hours, torque, angle, start=coordinates, **others)  # type: ignore[arg-type]


NEW = np.array([*np.log([78198, 101838, 1833, 60000]), -1.5, *np.log([1.177, 115.5, 0.066])])
WEAR = np.array([0.0, -0.033, 0.0, -2.35, 4.4, -0.021, -0.498, 0.141])
"""From `NEW` to Table 2's state after the test."""


def wearing_drive(
    rng: np.random.Generator,
    wear: np.ndarray,
    hours: np.ndarray,
    scatter: float = 0.01,
    offset: np.ndarray | float = 0.0,
    points: int = 200,
) -> list[SimulatedLoop]:
    """Tests of a drive whose wear (tests,) is given, remounting scatter and an offset added."""
    sizes = np.array([1, 1, 1, 1, 3, 1, 1, 1])
    found = []
    for at, reached in zip(hours, wear, strict=True):
        mounted = NEW + WEAR * reached + offset + scatter * sizes * rng.standard_normal(8)
        found.append(simulated_loop(float(at), mounted, rng, points=points))
    return found
