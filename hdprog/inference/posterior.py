"""The posterior of one loop: draws, diagnostics, figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.explanation import UNKNOWN
from hdprog.inference.diagnostics import Diagnostics
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.priors import Prior
from hdprog.physics.course import Course
from hdprog.physics.effects.base import Values
from hdprog.physics.figures import FigureRequest, Operation, figures
from hdprog.physics.parameters import NAMES, FloatArray, Parameters
from hdprog.physics.steady_cycle import QUANTITIES, LastingEffects, whole_figure

FIGURE_DRAWS = 2000
_FIT_DRAWS = 32  # of which the fitted curve is the median
_LONG_RECORD = 200_000  # readings


@dataclass(frozen=True)
class Posterior:
    """Draws of one loop's posterior with all that is needed to check them.

    Attributes
    ----------
    loop, drive, prior, operation : what was fitted, and what its figures refer to
    likelihood : of the reduced record, noise model included
    chains : (ensembles, steps, walkers, size) thinned draws of points, see `likelihood`
    offset, noise_scale : (ensembles, steps, walkers) drawn given the chains; rad and -
    diagnostics : of the chains as sampled, thinned by half their autocorrelation time; of the
        coordinates that are sampled, not of effects that are integrated out
    converged : R-hat, ESS and length all reached what they must
    best : (size,) best point found by least squares
    turning_points : indices of the record's first reading, reversals and last reading
    kept : (samples,) False for readings set aside as spikes
    record_course : coordinates of the whole record
    noise_floor : scatter of neighbouring residuals about a smooth course, in rad
    sampling : numbers of the run by name: ensembles, walkers, warm_up_steps, steps,
        autocorrelation_time, acceptance, evaluations, and others where they occur
    warnings : in words
    """

    loop: Loop
    drive: Drive
    prior: Prior
    operation: Operation
    likelihood: LoopLikelihood
    chains: FloatArray
    offset: FloatArray
    noise_scale: FloatArray
    diagnostics: Diagnostics
    converged: bool
    best: FloatArray
    turning_points: NDArray[np.intp]
    kept: NDArray[np.bool_]
    record_course: Course
    noise_floor: float
    sampling: Mapping[str, float]
    warnings: tuple[str, ...]

    @property
    def effects(self) -> tuple[str, ...]:
        """Ids of the effects fitted beside the drive model; "unknown" for an empirical term."""
        named = tuple(effect.id for effect in self.likelihood.effects)
        return named if self.likelihood.noise.term is None else (*named, UNKNOWN)

    @cached_property
    def effect_values(self) -> dict[str, Values]:
        """Physical parameters of the effects by id and name, (draws, 1) each."""
        return self.likelihood.effect_set.values(self.points[:, COUNT + 1 :])

    @cached_property
    def points(self) -> FloatArray:
        """(draws, size) points of the likelihood, walker after walker."""
        return self._flat(self.chains)

    @property
    def coordinates(self) -> FloatArray:
        """(draws, 8) unconstrained coordinates of the drive model."""
        return self.points[:, :COUNT]

    @cached_property
    def parameters(self) -> Parameters:
        """Physical parameters by name, (draws,) each."""
        return self.prior.to_physical(self.coordinates)

    @property
    def contraction(self) -> dict[str, float]:
        """1 − var(posterior)/var(prior) of each parameter in its unconstrained coordinate."""
        ratio = self.coordinates.var(axis=0) / self.prior.sd**2
        return {name: float(1 - ratio[index]) for index, name in enumerate(NAMES)}

    @property
    def outlier_fraction(self) -> float:
        """Share of the readings that were set aside as spikes."""
        return float(1 - self.kept.mean())

    def thinned(self, draws: int) -> NDArray[np.intp]:
        """Evenly spaced indices of about so many flat draws."""
        total = self.coordinates.shape[0]
        return np.linspace(0, total - 1, min(draws, total)).astype(np.intp)

    def figures(self, requests: Sequence[FigureRequest]) -> dict[str, FloatArray]:
        """Figures of merit by key, (at most `FIGURE_DRAWS`,) each."""
        chosen = self.thinned(FIGURE_DRAWS)
        parameters = {name: values[chosen] for name, values in self.parameters.items()}
        return figures(requests, parameters, self.operation)

    def figures_with_effects(self) -> dict[str, FloatArray]:
        """Width, loss and lost motion with the lasting effects in them; empty without any.

        Of at most `FIGURE_DRAWS` draws, (draws,) each.
        """
        chosen = self.thinned(FIGURE_DRAWS)
        values = {
            effect: {name: column[chosen] for name, column in columns.items()}
            for effect, columns in self.effect_values.items()
        }
        lasting = LastingEffects.of(self.likelihood.effect_set, values)
        if lasting is None:
            return {}
        parameters = {name: column[chosen] for name, column in self.parameters.items()}
        return {
            quantity: whole_figure(quantity, parameters, self.operation, lasting)
            for quantity in QUANTITIES
        }

    @cached_property
    def fitted_angles(self) -> FloatArray:
        """Model angle with offset, (draws, blocks) in rad, for some draws."""
        chosen = self.thinned(400)
        likelihood = self.likelihood
        angle = likelihood.angle(self.points[chosen]) + self._flat(self.offset[..., None])[chosen]
        return angle + likelihood.noise.smooth_part(likelihood.reduced.angle - angle)

    @cached_property
    def record_residual(self) -> FloatArray:
        """(samples,) measured angle minus the fitted one at every reading, in rad.

        The median of some draws: single ones of linearised effects may lie far away. In records so
        long that it would take its time, the best fit.
        """
        whole = self.likelihood.at_course(self.record_course)
        points = self.best[None]
        if len(self.loop) < _LONG_RECORD:
            points = self.points[self.thinned(_FIT_DRAWS)]
        difference = self.loop.angle - np.median(whole.angle(points), axis=0)
        term = self.likelihood.noise.term
        if term is not None:
            left = self.likelihood.reduced.angle - np.median(self.likelihood.angle(points), axis=0)
            left -= self.likelihood.offset(left)
            coefficients = self.likelihood.noise.coefficients(left)
            difference = difference - term.features(self.record_course) @ coefficients
        return np.asarray(difference - np.mean(difference[self.kept]))

    def without_effect(self, effect_id: str, draws: int) -> tuple[FloatArray, FloatArray]:
        """Model angle with all effects and with one absent, (draws, blocks) in rad each."""
        points = self.points[self.thinned(draws)]
        absent = points.copy()
        for index, (effect, parameter) in enumerate(self.likelihood.effect_set.parameters):
            if effect.id == effect_id and parameter.amplitude:
                absent[:, COUNT + 1 + index] = parameter.absent
        return self.likelihood.angle(points), self.likelihood.angle(absent)

    def _flat(self, chains: FloatArray) -> FloatArray:
        return chains.transpose(0, 2, 1, 3).reshape(-1, chains.shape[-1])
