"""What is believed of wear before a drive's own tests: direction, pace, clock, scatter."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from statistics import NormalDist
from typing import Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hdprog.errors import BadInputError
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.shipped import shipped
from hdprog.trend.fleet import FleetPrior
from hdprog.trend.steady_pace import Told, pooled_deviates, pooled_fleet, pooled_loadings

FILE = "trend.toml"
MESH = tuple(NAMES.index(name) for name in ("T_i", "mu"))
"""Places of preload and friction, which wear elsewhere than the teeth's stiffness."""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


class LogNormal(_Strict):
    """A log-normal belief: median and standard deviation of the logarithm."""

    median: float = Field(gt=0)
    log_sd: float = Field(gt=0, le=5)

    def at(self, deviate: FloatArray) -> FloatArray:
        """Value at standard normal deviates (any shape)."""
        return np.asarray(self.median * np.exp(self.log_sd * deviate))


class HeavyTailed(_Strict):
    """A belief whose logarithm has a Student distribution of two degrees of freedom.

    Attributes
    ----------
    median : middle
    log_scale : of the logarithm: a fifth lies farther than 1.9 of them from the middle
    """

    median: float = Field(gt=0)
    log_scale: float = Field(gt=0, le=5)

    def below(self, log_value: FloatArray) -> FloatArray:
        """Probability below a value's logarithm (any shape)."""
        deviate = (log_value - np.log(self.median)) / self.log_scale
        return np.asarray(0.5 + 0.5 * deviate / np.sqrt(2.0 + deviate**2))

    def log_at(self, probability: FloatArray) -> FloatArray:
        """Logarithm of the value that lies above so much of the belief (any shape)."""
        spread = np.sqrt(2.0 * probability * (1.0 - probability))
        return np.asarray(np.log(self.median) + self.log_scale * (2.0 * probability - 1.0) / spread)


class Share(_Strict):
    """A belief in a share between 0 and 1: a Gaussian through its distribution function."""

    mean: float
    sd: float = Field(gt=0)

    def at(self, deviate: FloatArray) -> FloatArray:
        """Value at standard normal deviates (any shape)."""
        from scipy.special import ndtr

        return np.asarray(ndtr(self.mean + self.sd * deviate))


class WearRate(LogNormal):
    """Units of wear reached after `reference_hours`."""

    reference_hours: float = Field(gt=0)


class Loading(_Strict):
    """A Gaussian belief, such as the change of one coordinate per unit of wear."""

    mean: float
    sd: float = Field(gt=0)


class RateAhead(_Strict):
    """How the logarithm of the rate of wear changes past the last test.

    Attributes
    ----------
    spread : of its random walk, over that of `rate_volatility`
    drift : while wear grows to e times itself
    """

    spread: float = Field(gt=0)
    drift: float


class OwnPace(_Strict):
    """How each coordinate's change per unit of wear walks by itself.

    Attributes
    ----------
    spread : of its walk while wear grows to e times itself, over `own_volatility` (of preload and
        friction `preload_volatility`), in drift scales
    """

    spread: float = Field(ge=0)


class WithinFleet(_Strict):
    """How far drives of one fleet differ, over how far any drives do.

    Attributes
    ----------
    wear_rate, clock_and_scatter, loadings : scales of half-Cauchy standard deviations of the
        deviates of the pace, of the other hyperparameters and of the loadings
    """

    wear_rate: float = Field(gt=0)
    clock_and_scatter: float = Field(gt=0)
    loadings: float = Field(gt=0)

    def scales(self, deviates: int) -> FloatArray:
        """(deviates,) by deviate: pace, other hyperparameters, loadings of the drive model."""
        others = deviates - 1 - len(NAMES)
        return np.repeat(
            [self.wear_rate, self.clock_and_scatter, self.loadings], [1, others, len(NAMES)]
        )


class Curvature(_Strict):
    """Curvature κ of the wear clock: zero for most of the prior, continuous from there."""

    levelling: float = Field(gt=0, lt=0.5)
    accelerating: float = Field(gt=0, lt=0.5)
    scale: float = Field(gt=0)

    def at(self, deviate: FloatArray) -> FloatArray:
        """κ at standard normal deviates (any shape)."""
        high = NormalDist().inv_cdf(1 - self.levelling)
        low = NormalDist().inv_cdf(self.accelerating)
        return np.asarray(
            self.scale * (np.maximum(deviate - high, 0.0) + np.minimum(deviate - low, 0.0))
        )


class EffectPrior(_Strict):
    """What is believed of a followed effect's amplitude, in units of the largest that was found."""

    initial_sd: float = Field(gt=0)
    loading_sd: float = Field(gt=0)
    drift_scale: float = Field(gt=0)
    scatter_scale: float = Field(gt=0)


class SuddenStep(NamedTuple):
    """A lasting step of a followed effect, which wear does not bring.

    Attributes
    ----------
    test : place of the first test after it, in order of service hours, from 0
    amplitude : place among the followed amplitudes
    """

    test: int
    amplitude: int


class WearPrior(_Strict):
    """Prior of wear, as priors/trend.toml gives it; see the comments there.

    Its arrays are (n,): eight wear coordinates, then `followed` amplitudes of effects, some
    of which may have come at once, in `sudden` steps; `greased` tells which are of friction,
    (followed) or none if empty. `fleet` is what other drives add to the file.
    """

    name: str
    source: str
    loadings: dict[str, Loading]
    wear_rate: WearRate
    clock_exponent: LogNormal
    clock_curvature: Curvature
    running_in: Loading
    running_in_length: LogNormal
    volatility: LogNormal
    rate_volatility: LogNormal
    rate_ahead: RateAhead
    own_volatility: LogNormal
    preload_volatility: LogNormal
    own_pace: OwnPace
    remounting_scatter: LogNormal
    load_share: Share
    drift_scale: dict[str, float]
    scatter_scale: dict[str, float]
    effect: EffectPrior
    temperature: dict[str, Loading]
    worn_out: dict[str, HeavyTailed]
    regreased: dict[str, float]
    reassembled: dict[str, float]
    within_fleet: WithinFleet
    followed: int = 0
    sudden: tuple[SuddenStep, ...] = ()
    greased: tuple[bool, ...] = ()
    fleet: FleetPrior | None = None

    @property
    def identity(self) -> str:
        """Digest of what the deviates are of: those of different files do not compare."""
        of_a_drive = {"followed", "sudden", "greased", "fleet"}
        content = self.model_dump_json(exclude=of_a_drive | {"temperature", "within_fleet"})
        return hashlib.sha256(content.encode()).hexdigest()[:16]

    def learnt_from(self, fleet: FleetPrior) -> WearPrior:
        """The same for a drive of a fleet."""
        return self._with(fleet=fleet)

    def taught_by(self, drives: Sequence[str], told: Sequence[Told]) -> WearPrior:
        """The same for a drive of the fleet that others (ids in the same order) tell of."""
        within = self.within_fleet.scales(told[0].said.information.size)
        return self.learnt_from(pooled_fleet(drives, told, within))

    def without_fleet(self) -> WearPrior:
        """The same as its file gives it."""
        return self._with(fleet=None)

    def deviates(self, standard: FloatArray) -> FloatArray:
        """Deviates of hyperparameters (draws, k) from standard normal ones; the fleet's, if any."""
        return standard if self.fleet is None else pooled_deviates(standard, self.fleet)

    def loadings_given(self, deviates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Mean and sd (draws, n) of the loadings, given hyperparameters' deviates (draws, k).

        Without a fleet they do not hang together: the mean is (1, n), the sd (n,).
        """
        if self.fleet is None:
            return self.loading_mean[None], self.loading_sd
        mean, sd = pooled_loadings(deviates, self.fleet)
        beside = np.zeros((len(mean), self.followed))
        centre = self.loading_mean + self.loading_sd * np.hstack([mean, beside])
        return centre, self.loading_sd * np.hstack([sd, beside + 1.0])

    def following(self, amplitudes: int, greased: Sequence[bool] = ()) -> WearPrior:
        """The same for a state with so many amplitudes of effects, some of them of friction."""
        return self._with(followed=amplitudes, sudden=(), greased=tuple(greased))

    def stepping(self, sudden: Sequence[SuddenStep]) -> WearPrior:
        """The same for a drive whose followed amplitudes may have stepped there."""
        return self._with(sudden=tuple(sudden))

    def _with(self, **changed: object) -> WearPrior:
        fields = {name: getattr(self, name) for name in WearPrior.model_fields}
        return WearPrior.model_validate(fields | changed)

    def _extended(self, coordinates: list[float], amplitude: float) -> FloatArray:
        return np.array(coordinates + [amplitude] * self.followed)

    @cached_property
    def loading_mean(self) -> FloatArray:
        """(n,) change of each coordinate per unit of wear that the file expects."""
        return self._extended([self.loadings[name].mean for name in NAMES], 0.0)

    @cached_property
    def loading_sd(self) -> FloatArray:
        """(n,) standard deviation of that change from drive to drive."""
        return self._extended([self.loadings[name].sd for name in NAMES], self.effect.loading_sd)

    @cached_property
    def drift_scales(self) -> FloatArray:
        """(n,) relative size of the own drift of each coordinate."""
        return self._extended([self.drift_scale[name] for name in NAMES], self.effect.drift_scale)

    @cached_property
    def scales(self) -> FloatArray:
        """(n,) relative size of the remounting scatter of each coordinate."""
        return self._extended(
            [self.scatter_scale[name] for name in NAMES], self.effect.scatter_scale
        )

    @cached_property
    def warmer_mean(self) -> FloatArray:
        """(n,) change of each coordinate that the file expects of 10 K."""
        return self._of_warmth("mean")

    @cached_property
    def warmer_sd(self) -> FloatArray:
        """(n,) standard deviation of that change from drive to drive."""
        return self._of_warmth("sd")

    def _of_warmth(self, value: Literal["mean", "sd"]) -> FloatArray:
        each = {name: getattr(belief, value) for name, belief in self.temperature.items()}
        return self._extended([each[name] for name in NAMES], each["effect"])

    def event_variance(self, event: str | None) -> FloatArray:
        """(n,) variance of the lasting step that an event leaves in each coordinate."""
        steps = {"regreased": self.regreased, "reassembled": self.reassembled}.get(event or "", {})
        # An effect beside the drive model may come from what was taken apart.
        amplitude = self.effect.initial_sd if event == "reassembled" else 0.0
        found = self._extended([steps.get(name, 0.0) for name in NAMES], amplitude)
        if event == "regreased" and self.greased:
            found[len(NAMES) :] = np.where(self.greased, self.effect.initial_sd, 0.0)
        return found**2

    def step_variance(self, test: int, event: str | None) -> FloatArray:
        """(n,) variance of the lasting step before a test: of its event, of what came at once."""
        variance = self.event_variance(event)
        came = [step.amplitude for step in self.sudden if step.test == test]
        variance[len(NAMES) + np.array(came, dtype=np.intp)] += self.effect.initial_sd**2
        return variance


def _read(path: Path | None) -> tuple[str, str]:
    """Text of a file, and its name for messages; of the shipped one if None."""
    if path is None:
        return (shipped("priors") / FILE).read_text("utf-8"), f"priors/{FILE}"
    if not path.is_file():
        raise BadInputError(
            found=f"no file {path}",
            where="wear prior",
            expected=f"a file like the shipped {FILE}",
            advice="Correct the path.",
        )
    return path.read_text("utf-8"), str(path)


def read_wear_prior(path: Path | None = None) -> WearPrior:
    """Read the shipped wear prior, or one at a path.

    Raises
    ------
    BadInputError
        if there is no such file or its content is not a wear prior
    """
    text, where = _read(path)
    try:
        prior = WearPrior.model_validate(tomllib.loads(text))
        for table, names in (
            (prior.loadings, NAMES),
            (prior.drift_scale, NAMES),
            (prior.scatter_scale, NAMES),
            (prior.temperature, (*NAMES, "effect")),
            (prior.worn_out, ("b", "T_i")),
        ):
            missing = [name for name in names if name not in table]
            if missing:
                raise ValueError("no entry for " + ", ".join(missing))
    except (tomllib.TOMLDecodeError, ValueError) as error:
        reason = str(error)
        if isinstance(error, ValidationError):
            first = error.errors()[0]
            reason = ".".join(str(part) for part in first["loc"]) + ": " + first["msg"]
        raise BadInputError(
            found=reason,
            where=where,
            expected=f"the tables of the shipped {FILE}",
            advice=f"Compare with the shipped {FILE}.",
        ) from None
    return prior
