"""A fit held against what its record shows: where it misses a figure it says so."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.against_record import against_record, spread_of_gap
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.posterior import Posterior
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.smooth_term import FEATURES, SmoothTerm
from hdprog.physics.drive_model import predict
from hdprog.physics.figures import FigureRequest, figures
from tests.hasty import SHORT
from tests.reporting.drives import WORN

REQUESTS = (
    FigureRequest("lost_motion_arcmin"),
    FigureRequest("hysteresis_width_arcmin"),
    FigureRequest("hysteresis_loss_J"),
    FigureRequest("secant_stiffness_Nm_per_rad", 14.0),
)
DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
STEP, NOISE = 3e-4, 1e-5  # rad


def fitted(step: float) -> Posterior:
    """The drive model alone, sampled shortly, on a loop that steps at 6 Nm to either side."""
    turns = (0.0, 63.0, -63.0, 63.0, -63.0, 63.0)
    ramps = [np.linspace(a, b, 300, endpoint=False) for a, b in pairwise(turns)]
    torque, rng = np.concatenate(ramps), np.random.default_rng(4)
    angle = predict(torque, WORN) + NOISE * rng.standard_normal(torque.size)
    angle += step * np.sign(torque) / (1 + np.exp(-4 * (np.abs(torque) - 6)))
    prior = read_prior_file("csf-25-80").prior(None)
    loop = Loop(torque=torque, angle=angle, time=0.01 * np.arange(torque.size))
    return fit_loop(loop, DRIVE, rng, prior=prior, plan=SHORT)


@pytest.fixture(scope="module")
def missed() -> Posterior:
    return fitted(STEP)


def test_a_right_model_goes_where_the_record_does() -> None:
    found = against_record(fitted(0.0), REQUESTS)
    assert list(found) == [request.key for request in REQUESTS]
    for key, one in found.items():
        gap = one.record - one.fit[0.50]
        assert abs(gap) < 3 * spread_of_gap(one.record_sd, one.fit), key
        assert not one.differs, key


def test_a_fit_that_misses_a_figure_says_so(missed: Posterior) -> None:
    """Teeth that soften smoothly cannot step, and go through zero too flat."""
    (lost_motion, *_) = against_record(missed, REQUESTS).values()
    assert lost_motion.differs
    exact = figures(REQUESTS[:1], {k: np.array([v]) for k, v in WORN.items()}, missed.operation)
    assert lost_motion.record == pytest.approx(float(exact[REQUESTS[0].key][0]), rel=0.05)
    assert lost_motion.fit[0.05] > 1.1 * lost_motion.record


def test_an_empirical_curve_does_not_make_good_what_the_figures_miss(missed: Posterior) -> None:
    term, likelihood = SmoothTerm("torque", -63.0, 63.0, np.full(FEATURES, 1e-6)), missed.likelihood
    noise = likelihood.noise.as_white.with_term(term, likelihood.reduced.course)
    curved = replace(missed, likelihood=replace(likelihood, noise=noise))
    key = REQUESTS[0].key
    plain = replace(likelihood, noise=likelihood.noise.as_white)
    alone = against_record(replace(missed, likelihood=plain), REQUESTS)[key]
    beside = against_record(curved, REQUESTS)[key]
    assert beside.record_sd == pytest.approx(alone.record_sd, rel=1e-6)
    assert beside.fit == pytest.approx(alone.fit)
