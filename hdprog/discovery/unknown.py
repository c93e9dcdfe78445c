"""What an empirical smooth term over a coordinate would gain on top of a model.

The model is linearised about its mode; the term's size and smoothness and the noise scale are found
by maximum marginal likelihood. Everything happens in the space of the columns, a hundred or so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from hdprog.discovery.model import CORRELATED_PENALTY, Model
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.noise import NoiseModel
from hdprog.inference.prepare import noise_about
from hdprog.inference.smooth_term import FEATURES, LENGTHS, SmoothTerm, basis_of, spectrum
from hdprog.inference.starting_points import descend_all, describe
from hdprog.physics.coordinates import coordinates
from hdprog.physics.parameters import FloatArray

_ROUNDS = 2
_READINGS_A_LENGTH = 1.0  # a curve that bends between its readings is their noise
_LEAST_VARIANCE = 0.05**2  # of the noise over what the readings show
_NOISE_STEPS = 12
_LOG_SIZES = (np.arange(-4.0, 7.5), 0.25 * np.arange(-4, 5), 0.0625 * np.arange(-4, 5))
"""Of a term over the noise's scale: a grid, and finer ones about the best of the last."""
_REPEATS = 4  # stretches: two loadings and two unloadings
TERM_PENALTY = 3.0
"""Log evidence that the term's two numbers must earn."""


@dataclass(frozen=True)
class TermGain:
    """An empirical term and the log evidence that it gains."""

    term: SmoothTerm
    gain: float
    white: bool  # beside white noise; else beside the model's correlated noise


class _Evidence:
    """Data d ~ N(0, s² (I + ρ B Bᵀ) + A Aᵀ) for columns A, and B of one shape.

    On the axes of BᵀB every share ρ leaves B's part diagonal, and on those of what is left of AᵀA
    every noise s leaves A's.
    """

    def __init__(self, own: FloatArray, smooth: FloatArray, data: FloatArray) -> None:
        strength, axes = np.linalg.eigh(smooth.T @ smooth)
        self._strength = np.maximum(strength, 0.0)
        self._crossed, self._pulled = axes.T @ (smooth.T @ own), axes.T @ (smooth.T @ data)
        self._gram, self._pull = own.T @ own, own.T @ data
        self._squares, self._rows = float(data @ data), data.size

    def at_best_noise(self, ratios: FloatArray, variance: float) -> tuple[FloatArray, FloatArray]:
        """Log marginal at shares ρ (shares,), each with its best s², and these; (shares,) each.

        s² is found by iteration from `variance`, where its derivative vanishes.
        """
        share = ratios[:, None] / (1 + ratios[:, None] * self._strength)
        squares = self._squares - share @ self._pulled**2
        pull = self._pull - (share * self._pulled) @ self._crossed
        left = self._gram - (self._crossed.T * share[:, None, :]) @ self._crossed
        values, axes = np.linalg.eigh(left)
        values = np.maximum(values, 0.0)
        pulls = (pull[:, None, :] @ axes)[:, 0] ** 2
        best = np.full((ratios.size, 1), max(variance, _LEAST_VARIANCE))
        for _ in range(_NOISE_STEPS):
            both = values + best
            explained = np.sum(pulls * (both + best) / both**2, axis=1)
            degrees = self._rows - np.sum(values / both, axis=1)
            best = np.maximum((squares - explained) / degrees, _LEAST_VARIANCE)[:, None]
        deviance = (squares - np.sum(pulls / (values + best), axis=1)) / best[:, 0]
        deviance += self._rows * np.log(best[:, 0]) + np.log1p(values / best).sum(axis=1)
        deviance += np.log1p(ratios[:, None] * self._strength).sum(axis=1)
        return np.asarray(-0.5 * deviance), best[:, 0]


def term_gains(model: Model) -> Mapping[str, TermGain]:
    """The best empirical term over each coordinate of the record, by the coordinate's name.

    Not over the order of an untimed record whose cycles repeat: that would explain why they differ
    from each other, beyond what the record itself repeats to.
    """
    course = model.likelihood.reduced.course
    found: dict[str, TermGain] = {}
    own = _Tangent.of(model.likelihood, model)
    tangents = [own]
    if model.likelihood.noise.log_ratio is not None:
        white = replace(model.likelihood, noise=model.likelihood.noise.as_white)
        tangents.append(_Tangent.of(white, model))
    for name, values in coordinates(course).items():
        if name == "order" and course.path.starts.size >= _REPEATS:
            continue
        low, high = float(values.min()), float(values.max())
        basis = basis_of(name, low, high, course)
        for tangent in tangents:
            sd, length, evidence = tangent.best(basis)
            gain = evidence - own.without - TERM_PENALTY
            if name not in found or gain > found[name].gain:
                term = SmoothTerm(name, low, high, sd, length)
                found[name] = TermGain(term, gain, tangent is not own)
    return found


@dataclass(frozen=True)
class _Tangent:
    """A likelihood that is linearised about a model's mode.

    Attributes
    ----------
    likelihood : with its noise
    data : (blocks,) what the prior's centre leaves
    own : (blocks, size) columns of the model's coordinates, in prior standard deviations
    variance : s² to begin with
    constant : of the log evidence, by the noise and the offset
    without : log evidence without a term
    """

    likelihood: LoopLikelihood
    data: FloatArray
    own: FloatArray
    variance: float
    constant: float
    without: float

    @staticmethod
    def of(likelihood: LoopLikelihood, model: Model) -> _Tangent:
        """About the model's mode."""
        residual, derivative = likelihood.jacobian(model.start.point)
        data = residual + derivative @ (likelihood.prior_mean - model.start.point)
        own = derivative * likelihood.prior_sd
        alone = _Evidence(own, np.zeros((data.size, 0)), data)
        variance = float(residual @ residual) / residual.size
        marginal = float(alone.at_best_noise(np.zeros(1), variance)[0][0])
        ones = likelihood.noise.whiten(np.ones((1, likelihood.blocks)))[0]
        constant = float(-0.5 * likelihood.noise.log_det - 0.5 * np.log(ones @ ones))
        if likelihood.noise.log_ratio is not None:
            constant -= CORRELATED_PENALTY
        return _Tangent(likelihood, data, own, variance, constant, constant + marginal)

    def best(self, basis: FloatArray) -> tuple[float, float, float]:
        """Size and length of the best term in a basis, and the log evidence with it."""
        smooth = self.likelihood.project(basis.T.copy()).T
        repeated = basis.shape[1] // FEATURES
        typical = float(np.median(self.likelihood.noise.white_sd))
        best = (0.0, LENGTHS[0], -np.inf)
        shortest = _READINGS_A_LENGTH * repeated / self.data.size
        for length in LENGTHS:
            if length < shortest and length != LENGTHS[0]:
                continue
            evidence = _Evidence(self.own, smooth * np.tile(spectrum(length), repeated), self.data)
            around = 0.0
            for offsets in _LOG_SIZES:
                sizes = around + offsets
                ratios = (typical * np.exp(sizes)) ** 2
                marginal, _ = evidence.at_best_noise(ratios, self.variance)
                at = int(marginal.argmax())
                around = float(sizes[at])
            found = self.constant + float(marginal[at])
            if found > best[2]:
                best = (typical * float(np.exp(around)), length, found)
        return best


def with_term(model: Model, gain: TermGain) -> Model:
    """The model with an empirical term, its modes, its noise and the term's size found anew."""
    likelihood = model.likelihood
    noise = likelihood.noise.as_white if gain.white else likelihood.noise
    best = _joined(model, noise, gain.term)
    for _ in range(_ROUNDS):
        noise = noise_about(best.likelihood, best.start)
        other = Model(replace(likelihood, noise=noise), best.starts)
        basis = basis_of(
            gain.term.coordinate, gain.term.low, gain.term.high, likelihood.reduced.course
        )
        sd, length, _ = _Tangent.of(other.likelihood, other).best(basis)
        better = _joined(other, noise, replace(gain.term, sd=sd, length=length))
        if better.log_evidence <= best.log_evidence:
            break
        best = better
    return best


def _joined(model: Model, noise: NoiseModel, term: SmoothTerm) -> Model:
    course = model.likelihood.reduced.course
    added = replace(model.likelihood, noise=noise.with_term(term, course))
    starts = descend_all(added, [start.point for start in model.starts[:2]], 12)
    starts = starts or [describe(added, model.start.point)]
    return Model(added, tuple(sorted(starts, key=lambda start: start.deviance)))
