"""A model of one record at its best point, and its evidence.

Laplace's approximation: log Z = log L(x̂) + log prior(x̂) + ½ log |Σ|, with Σ the posterior
covariance at the mode and the noise's determinant in L. All effects' coordinates have standard
Gaussian priors, so a parameter that the record says nothing about costs nothing (MacKay,
Information Theory, Inference and Learning Algorithms, 2003, ch. 28).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.prepare import noise_about
from hdprog.inference.smooth_term import SmoothTerm
from hdprog.inference.starting_points import StartingPoint, descend, descend_all
from hdprog.physics.parameters import FloatArray

STEPS_EFFECT = 4.0
"""Of an angle's steps: readings are worth 1/(1 + 4 s²) of themselves where steps make up a share s
of the error's variance (a design effect). Steps wider than the noise leave errors that follow the
angle, which neither white nor correlated noise expects; noise as wide as a step blurs them."""
CORRELATED_PENALTY = 4.6
"""Log evidence that the two numbers of the correlated noise must earn (χ² with 2 at 1 %)."""
_MODES = 2  # of a model, from which it is sought anew beside another noise
_MOST_DOUBT = 25.0
"""Of correlated noise that is held against a curve: beyond it the better one holds."""


@dataclass(frozen=True)
class Model:
    """Drive model, effects and noise on one record.

    Attributes
    ----------
    likelihood : with its effects and noise
    starts : its modes, best first
    """

    likelihood: LoopLikelihood
    starts: tuple[StartingPoint, ...]

    @property
    def start(self) -> StartingPoint:
        """The best mode."""
        return self.starts[0]

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of the effects."""
        return tuple(effect.id for effect in self.likelihood.effects)

    @property
    def term(self) -> SmoothTerm | None:
        """The empirical term, if there is one."""
        return self.likelihood.noise.term

    @cached_property
    def log_evidence(self) -> float:
        """Log Z, up to a constant of the record."""
        return log_evidence(self.likelihood, self.start)

    @cached_property
    def doubt(self) -> float:
        """What a curve need not gain where correlated noise is held against it, in log evidence.

        Beside a curve such noise has a half-normal prior, in root mean square 0.7 of the white
        noise's: an encoder's slow errors are seldom many times larger.
        """
        ratio = self.likelihood.noise.log_ratio
        return 0.0 if ratio is None else float(min(np.exp(ratio), _MOST_DOUBT))

    @cached_property
    def worth(self) -> float:
        """Of a gain of log evidence over this model: below one where its error is an angle's steps.

        What a model leaves beside them is in its residual.
        """
        scales = self.likelihood.reduced.course.scales
        if scales.angle_step is None or scales.angle_error is None:
            return 1.0
        error = max(scales.angle_error**2, float(np.mean(self.residual**2)))
        return float(1.0 / (1.0 + STEPS_EFFECT * (scales.angle_step**2 / 12 / error) ** 2))

    @cached_property
    def residual(self) -> FloatArray:
        """(blocks,) what mechanisms and empirical term leave, mean taken out, in rad."""
        likelihood = self.likelihood
        left = likelihood.reduced.angle - likelihood.angle(self.start.point[None, :])[0]
        left = left - likelihood.offset(left)
        left = left - likelihood.noise.smooth_part(left)
        weight = 1 / likelihood.noise.white_sd**2
        return np.asarray(left - weight @ left / weight.sum())

    @cached_property
    def misfit(self) -> float:
        """Sum of squares of the residual over its white noise as declared."""
        return float(np.sum((self.residual / self.likelihood.noise.white_sd) ** 2))

    @cached_property
    def least_misfit(self) -> float:
        """The misfit beside white noise, where nothing is left to the noise that can be fitted.

        Beside correlated noise a fit stays away from what that noise takes over.
        """
        noise = self.likelihood.noise
        if noise.whitening is None or noise.term is not None:
            return self.misfit
        white = replace(self.likelihood, noise=noise.as_white)
        found = descend(white, self.start.point)
        return self.misfit if found is None else min(self.misfit, Model(white, (found,)).misfit)


def gain_over(simpler: Model, model: Model) -> float:
    """Log evidence that a model gains over a simpler one of the same record."""
    return simpler.worth * (model.log_evidence - simpler.log_evidence)


def gain_of_curve(simpler: Model, model: Model) -> float:
    """The same of an empirical term, beside which large correlated noise counts for less."""
    return gain_over(simpler, model) + simpler.worth * (simpler.doubt - model.doubt)


def log_evidence(likelihood: LoopLikelihood, start: StartingPoint) -> float:
    """Laplace's log evidence of a mode, offset and noise scale integrated out."""
    noise = likelihood.noise
    ones = noise.whiten(np.ones((1, likelihood.blocks)))[0]
    value = -0.5 * start.deviance + 0.5 * np.linalg.slogdet(start.covariance)[1]
    value -= 0.5 * noise.log_det + 0.5 * np.log(ones @ ones)
    return float(value - (CORRELATED_PENALTY if noise.log_ratio is not None else 0.0))


def settled(likelihood: LoopLikelihood, starts: Sequence[StartingPoint]) -> Model:
    """The model with its noise found anew about its best mode."""
    noise = noise_about(likelihood, starts[0])
    other = replace(likelihood, noise=noise)
    found = descend_all(other, [start.point for start in starts[:_MODES]], 12)
    if not found:
        return Model(likelihood, tuple(starts))
    best = Model(other, tuple(sorted(found, key=lambda start: start.deviance)))
    before = Model(likelihood, tuple(starts))
    return max((before, best), key=lambda model: model.log_evidence)
