"""Evidence that the tests of a drive have an effect in common: the same one, but for a scatter.

An effect of the rig or of the drive's make is the same in every test. Where each test has
coordinates of its own, each pays for them in log evidence; together they pay once, if they agree.
A test's likelihood of these coordinates is taken as the Gaussian about its mode.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from hdprog.discovery.forward_step import Step
from hdprog.discovery.model import Model, gain_over
from hdprog.discovery.pooling import pooled
from hdprog.inference.likelihood import COUNT
from hdprog.physics.course import Scales
from hdprog.physics.parameters import FloatArray

SCATTERS = (0.0, 0.1, 0.3)
"""From test to test, in prior standard deviations; one is as likely as another."""
_STEP = 1e-4


@dataclass(frozen=True)
class Said:
    """What one test says of k coordinates x with standard Gaussian priors.

    The likelihood is exp(constant + pullᵀ x − ½ xᵀ precision x).

    Attributes
    ----------
    precision : (k, k)
    pull : (k,)
    constant : a number
    """

    precision: FloatArray
    pull: FloatArray
    constant: float = 0.0

    @property
    def log_evidence(self) -> float:
        """Of coordinates of its own."""
        inner = np.eye(self.pull.size) + self.precision
        gained = 0.5 * self.pull @ np.linalg.solve(inner, self.pull)
        return float(self.constant + gained - 0.5 * np.linalg.slogdet(inner)[1])

    def scattered(self, scatter: float) -> Said:
        """What it says of the mean about which the coordinates scatter from test to test."""
        variance = scatter**2
        inner = np.eye(self.pull.size) + variance * self.precision
        pull = np.asarray(np.linalg.solve(inner, self.pull))
        precision = np.asarray(np.linalg.solve(inner, self.precision))
        lost = 0.5 * np.linalg.slogdet(inner)[1] - 0.5 * variance * self.pull @ pull
        return Said(precision, pull, float(self.constant - lost))


def common_evidence(said: Sequence[Said]) -> float:
    """Log evidence of coordinates that the tests have in common."""
    found = []
    for scatter in SCATTERS:
        parts = [one.scattered(scatter) for one in said]
        together = Said(
            np.sum([part.precision for part in parts], axis=0),
            np.sum([part.pull for part in parts], axis=0),
            sum(part.constant for part in parts),
        )
        found.append(together.log_evidence)
    return float(logsumexp(found) - np.log(len(found)))


def gain_together(
    name: str, before: Sequence[Model], after: Sequence[Model | None]
) -> tuple[float, bool]:
    """Log evidence that an effect gains over all tests, and whether all have it in common.

    Parameters
    ----------
    name : the effect's id
    before : models without it, one a test
    after : models with it; None for a test that cannot show it
    """
    pairs = [(one, two) for one, two in zip(before, after, strict=True) if two is not None]
    gains = [gain_over(one, two) for one, two in pairs]
    some = pooled(gains)
    having = [two for _, two in pairs if name in two.ids]
    if len(having) < max(len(pairs), 2):
        return some, False
    worth = float(np.mean([one.worth for one, _ in pairs]))
    every = sum(gains) + worth * sharing_effect(having, name)
    return (every, True) if every > some else (some, False)


def gain_of_steps(name: str, steps: Sequence[Step]) -> tuple[float, bool]:
    """The same of a candidate of one forward step on every record."""
    before = [step.before for step in steps]
    return gain_together(name, before, [step.models.get(name) for step in steps])


def sharing_effect(models: Sequence[Model], name: str) -> float:
    """Log evidence gained where the tests' models have an effect in common, each having it.

    −inf where a test's effect is none that the prior of another may have drawn.
    """
    scales = models[0].likelihood.reduced.course.scales
    own = [_of_effect(model, name, model.likelihood.reduced.course.scales) for model in models]
    said = [_of_effect(model, name, scales) for model in models]
    if not all(np.isfinite(one.precision).all() and np.isfinite(one.pull).all() for one in said):
        return -np.inf
    return common_evidence(said) - sum(one.log_evidence for one in own)


def _of_effect(model: Model, name: str, scales: Scales) -> Said:
    """In coordinates whose priors suit a record of these scales; one at the mode.

    Not finite where those priors cannot have drawn the mode.
    """
    own, point = model.likelihood.effect_set, model.start.point[COUNT + 1 :]
    rows = np.flatnonzero([effect.id == name for effect, _ in own.parameters])
    mean = moved = point[rows]
    covariance = model.start.covariance[COUNT + 1 :, COUNT + 1 :][np.ix_(rows, rows)]
    # The posterior is the likelihood times the prior; strong curvature may leave less than that.
    values, axes = np.linalg.eigh(np.linalg.inv(covariance) - np.eye(rows.size))
    precision, slope = (axes * np.maximum(values, 0.0)) @ axes.T, np.ones(rows.size)
    with np.errstate(divide="ignore", invalid="ignore"):
        if scales != own.scales:
            near = (own.at_scales(point + step, scales)[rows] for step in (-_STEP, 0.0, _STEP))
            low, moved, high = near
            slope = (high - low) / (2 * _STEP)
            precision = precision / np.outer(slope, slope)
        pull = precision @ moved + mean / slope
        constant = float(0.5 * moved @ precision @ moved - pull @ moved)
    return Said(precision, pull, constant)
