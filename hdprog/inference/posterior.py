"""The posterior of one loop: draws, diagnostics, figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.diagnostics import Diagnostics
from hdprog.inference.likelihood import COUNT, LoopLikelihood, sigmoid
from hdprog.inference.priors import Prior
from hdprog.physics.figures import FigureRequest, Operation, figures
from hdprog.physics.parameters import NAMES, FloatArray, Parameters
from hdprog.physics.torque_path import TorquePath

FIGURE_DRAWS = 2000


@dataclass(frozen=True)
class Posterior:
    """Draws of one loop's posterior with all that is needed to check them.

    Attributes
    ----------
    loop, drive, prior, operation : what was fitted, and what its figures refer to
    likelihood : of the reduced record, noise model included
    chains : (ensembles, steps, walkers, 9) thinned draws of the unconstrained coordinates and of
        the logit of the initial slip's fraction
    offset, noise_scale : (ensembles, steps, walkers) drawn given the chains; rad and -
    diagnostics : of the whole chains, before thinning; quantities as in `chains`
    converged : R-hat, ESS and length all reached what they must
    best : (9,) best point found by least squares
    turning_points : indices of the record's first reading, reversals and last reading
    kept : (samples,) False for readings set aside as spikes
    record_path : torque path of the whole record
    noise_floor : scatter of neighbouring readings about a smooth course, in rad
    sampling : numbers of the run by name (ensembles, walkers, steps, burn_in, tau, acceptance)
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
    record_path: TorquePath
    noise_floor: float
    sampling: Mapping[str, float]
    effects: tuple[str, ...]
    warnings: tuple[str, ...]

    @cached_property
    def coordinates(self) -> FloatArray:
        """(draws, 8) unconstrained coordinates, walker after walker."""
        return self._flat(self.chains)[:, :COUNT]

    @cached_property
    def fraction(self) -> FloatArray:
        """(draws,) initial slip as a fraction of the way between its envelopes."""
        return sigmoid(self._flat(self.chains)[:, COUNT])

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

    @cached_property
    def fitted_angles(self) -> FloatArray:
        """Model angle with offset, (draws, blocks) in rad, for some draws."""
        chosen = self.thinned(400)
        angle = self.likelihood.angle(self.coordinates[chosen], self.fraction[chosen])
        return angle + self._flat(self.offset[..., None])[chosen]

    @cached_property
    def record_residual(self) -> FloatArray:
        """(samples,) measured angle minus the fitted one at every reading, in rad."""
        whole = self.likelihood.at_path(self.record_path)
        chosen = self.thinned(8 if len(self.loop) < 200_000 else 1)
        fitted = whole.angle(self.coordinates[chosen], self.fraction[chosen]).mean(axis=0)
        difference = self.loop.angle - fitted
        return np.asarray(difference - np.mean(difference[self.kept]))

    def _flat(self, chains: FloatArray) -> FloatArray:
        return chains.transpose(0, 2, 1, 3).reshape(-1, chains.shape[-1])
