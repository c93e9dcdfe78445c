"""What an empirical smooth term over a coordinate would gain on top of a model, and adding it.

The model is linearised about its mode; the noise scale is found by maximum marginal likelihood, and
so are the term's size and smoothness where only its gain is asked for. A term that is added has its
covariance averaged over sizes and smoothnesses, each with the weight of its marginal likelihood:
one record does not fix them, and at their best values intervals would be too narrow. Everything
happens in the space of the columns, a hundred or so.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from hdprog.discovery.model import CORRELATED_PENALTY, Model
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.prepare import noise_about
from hdprog.inference.smooth_term import FEATURES, LENGTHS, SmoothTerm, basis_of, spectrum
from hdprog.inference.starting_points import descend_all, describe, starting_points
from hdprog.physics.coordinates import coordinates
from hdprog.physics.parameters import FloatArray

_ROUNDS = 2
_READINGS_A_LENGTH = 1.0  # a curve that bends between its readings is their noise
_LEAST_VARIANCE = 0.05**2  # of the noise over what the readings show
_NOISE_STEPS = 12
_LOG_SIZES = (np.arange(-4.0, 7.5), 0.25 * np.arange(-4, 5), 0.0625 * np.arange(-4, 5))
"""Of a term over the noise's scale: a grid, and finer ones about the best of the last."""
_AVERAGED_SIZES = np.arange(-4.0, 7.6, 0.25)
"""The same that a covariance is averaged over, one as likely as another a priori."""
_REPEATS = 4  # stretches: two loadings and two unloadings
TERM_PENALTY = 3.0
"""Log evidence that the term's two numbers must earn."""


@dataclass(frozen=True)
class TermGain:
    """An empirical term over a coordinate and the log evidence that it gains."""

    coordinate: str
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
        beside_white = replace(model.likelihood, noise=model.likelihood.noise.as_white)
        tangents.append(_Tangent.of(beside_white, model))
    for name, values in coordinates(course).items():
        if name == "order" and course.path.starts.size >= _REPEATS:
            continue
        basis = basis_of(name, float(values.min()), float(values.max()), course)
        for tangent in tangents:
            white = tangent is not own
            gained = tangent.evidence_with(basis) - own.without + (model.doubt if white else 0.0)
            gain = model.worth * gained - TERM_PENALTY
            if name not in found or gain > found[name].gain:
                found[name] = TermGain(name, gain, white)
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

    def evidence_with(self, basis: FloatArray) -> float:
        """Log evidence with the best term in a basis."""
        best = -np.inf
        for _, evidence in self._by_length(basis):
            around = 0.0
            for offsets in _LOG_SIZES:
                sizes = np.asarray(around + offsets)
                marginal, _ = evidence.at_best_noise(self._ratios(sizes), self.variance)
                at = int(marginal.argmax())
                around = float(sizes[at])
            best = max(best, float(marginal[at]))
        return self.constant + best

    def averaged(self, basis: FloatArray) -> FloatArray:
        """(FEATURES,) standard deviations of a term's cosines, averaged over sizes and lengths."""
        ratios = self._ratios(_AVERAGED_SIZES)
        shapes, seen = [], []
        for shape, evidence in self._by_length(basis):
            shapes.append(shape)
            seen.append(evidence.at_best_noise(ratios, self.variance))
        marginal, variance = np.moveaxis(np.array(seen), 1, 0)
        # Covariances are counted in units of the noise's, which is another beside another term.
        weight = np.exp(marginal - marginal.max()) * variance
        return np.asarray(np.sqrt((weight @ ratios) @ np.array(shapes) ** 2 / weight.sum()))

    def _by_length(self, basis: FloatArray) -> Iterator[tuple[FloatArray, _Evidence]]:
        """The `spectrum` of every length that the readings can show, and the evidence for it."""
        smooth = self.likelihood.project(basis.T.copy()).T
        repeated = basis.shape[1] // FEATURES
        shortest = _READINGS_A_LENGTH * repeated / self.data.size
        for length in LENGTHS:
            if length >= shortest or length == LENGTHS[0]:
                shape = spectrum(length)
                yield shape, _Evidence(self.own, smooth * np.tile(shape, repeated), self.data)

    def _ratios(self, log_sizes: FloatArray) -> FloatArray:
        """Variances of a term over the noise's."""
        typical = float(np.median(self.likelihood.noise.white_sd))
        return np.asarray((typical * np.exp(log_sizes)) ** 2)


def with_term(model: Model, gain: TermGain, rng: np.random.Generator) -> Model:
    """The model with an empirical term; its modes, its noise and the term's size found anew."""
    noise = model.likelihood.noise
    plain = replace(model.likelihood, noise=noise.as_white if gain.white else noise)
    best = _joined(Model(plain, model.starts), gain.coordinate)
    for _ in range(_ROUNDS):
        # Its modes are sought everywhere: what the curve takes over held the parameters elsewhere.
        plain = replace(plain, noise=noise_about(best.likelihood, best.start))
        better = _joined(Model(plain, best.starts), gain.coordinate, rng)
        if better.log_evidence <= best.log_evidence:
            break
        best = better
    return best


def _joined(model: Model, coordinate: str, rng: np.random.Generator | None = None) -> Model:
    """The model with a term of the size that its residual asks for.

    With a generator its modes are sought from all over the prior as well.
    """
    likelihood, course = model.likelihood, model.likelihood.reduced.course
    values = coordinates(course)[coordinate]
    low, high = float(values.min()), float(values.max())
    spread = _Tangent.of(likelihood, model).averaged(basis_of(coordinate, low, high, course))
    term = SmoothTerm(coordinate, low, high, spread)
    added = replace(likelihood, noise=likelihood.noise.with_term(term, course))
    known = [start.point for start in model.starts[:2]]
    if rng is not None:
        return Model(added, tuple(starting_points(added, rng, known=known)))
    found = descend_all(added, known) or [describe(added, known[0])]
    return Model(added, tuple(sorted(found, key=lambda start: start.deviance)))
