"""Scores of forecasts of remaining life, over units, and whether they meet the aims."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.forecast.scores import (
    TransformHistogram,
    coverage_range,
    crps,
    probability_integral_transform,
    transform_histogram,
)
from tests.benchmarks.prognostics.fleets import HORIZON, NOW
from tests.benchmarks.prognostics.laws import FloatArray
from tests.benchmarks.prognostics.method import GRID

COVERAGE_AIM = (0.87, 0.93)
CRPS_AIM = 1.10
BINS = 10


@dataclass(frozen=True)
class Score:
    """One forecast of one unit.

    Attributes
    ----------
    transform : probability integral transform of the true crossing, random inside a lump
    crps : in hours, up to the horizon
    remaining : true remaining life, up to the horizon
    """

    transform: float
    crps: float
    remaining: float


def score(probability: FloatArray, crossing: float, deviate: float) -> Score:
    """Score a distribution function on `GRID`.

    A crossing past the horizon counts as never; what a forecast puts there, as never, too.
    """
    return Score(
        probability_integral_transform(GRID, probability, crossing, deviate),
        crps(GRID, probability, crossing),
        min(crossing, HORIZON) - NOW,
    )


@dataclass(frozen=True)
class Summary:
    """Scores over units.

    Attributes
    ----------
    units : how many
    held_90, held_50 : share of central intervals that hold the truth
    range_90, range_50 : their 95 % ranges
    relative : mean CRPS over true remaining life
    ratio : mean CRPS over that of the oracle for the same units
    histogram : of the transforms, with its band
    """

    units: int
    held_90: float
    held_50: float
    range_90: tuple[float, float]
    range_50: tuple[float, float]
    relative: float
    ratio: float
    histogram: TransformHistogram

    @property
    def covers(self) -> bool:
        """Whether the 90 % interval holds what the aim asks for."""
        return COVERAGE_AIM[0] <= self.held_90 <= COVERAGE_AIM[1]

    @property
    def sharp(self) -> bool:
        """Whether the CRPS is within the aim of the oracle's."""
        return self.ratio <= CRPS_AIM


def summarised(scores: Sequence[Score], oracle: Sequence[Score]) -> Summary:
    """Of the same units, in the same order."""
    transforms = np.array([one.transform for one in scores])
    errors = np.array([one.crps for one in scores])
    remaining = np.array([one.remaining for one in scores])
    # An interval holds the truth where the transform lies between its levels: the same for a
    # smooth distribution, and right where "never" is a lump of probability.
    wide = int(np.sum((transforms >= 0.05) & (transforms <= 0.95)))
    narrow = int(np.sum((transforms >= 0.25) & (transforms <= 0.75)))
    count = len(scores)
    return Summary(
        count,
        wide / count,
        narrow / count,
        coverage_range(wide, count),
        coverage_range(narrow, count),
        float(np.mean(errors / remaining)),
        float(errors.mean() / np.mean([one.crps for one in oracle])),
        transform_histogram(transforms.tolist(), BINS),
    )
