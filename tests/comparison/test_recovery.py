"""Each model finds itself on its own record, and predicts it at least as well as any other."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from hdprog.comparison.curves import SteadyCycle
from hdprog.comparison.fitted import Fitted, fit_model
from hdprog.comparison.ranking import ranked
from hdprog.comparison.results import DRIVE
from hdprog.config import Drive
from hdprog.inference.prepare import Prepared, prepare
from hdprog.physics.other_models import BY_ID
from hdprog.physics.other_models.base import Setting
from tests.comparison.loops import NOISE, SHORT, TRUTHS, loop_of, truth_of

# Rivals that the truth's record must not prefer, one of them without the truth's kind of friction.
RIVALS = {
    "ideal": ("cubic",),
    "tuttle": ("cubic",),
    "catalogue_piecewise": ("cubic", DRIVE),
    "cubic": ("catalogue_piecewise", "zhang"),
    "dhaouadi": ("zhang",),
    "zhang": ("catalogue_piecewise",),
    "seyfferth": ("cubic",),
    "taghirad": ("cubic",),
    "preisach": ("cubic",),
    "maxwell_slip": ("cubic",),
}


@cache
def compared(model_id: str) -> tuple[Prepared, dict[str, Fitted], tuple[str, ...]]:
    """What was fitted, the model and its rivals on it, and which of them are level."""
    rng = np.random.default_rng(5)
    prepared = prepare(loop_of(model_id, rng), Drive(), rng)
    cycle = SteadyCycle.of(prepared.record_course, 60.0)
    names = (model_id, *RIVALS[model_id])
    fitted = [fit_model(prepared, name, cycle, rng, SHORT) for name in names]
    order = tuple(one.id for one in ranked(fitted) if one.evidence.level_with_the_best)
    return prepared, {one.id: one for one in fitted}, order


@pytest.mark.parametrize("model_id", list(RIVALS))
def test_a_model_wins_on_its_own_record(model_id: str) -> None:
    """Among the best by the margin of 4 and of two standard errors.

    A rival that nests the truth may be level with it; on another seed the truth would fall outside
    the level ones in about one of forty (two standard errors, one side).
    """
    if model_id == "ideal":
        rng = np.random.default_rng(5)
        loop = loop_of("ideal", rng)
        assert np.std(loop.angle) == pytest.approx(NOISE, rel=0.2)
        return
    _, fitted, level = compared(model_id)
    own = fitted[model_id]
    assert model_id in level
    assert own.errors.rmse_rad == pytest.approx(NOISE, rel=0.15)
    assert own.errors.heldout_rmse_rad < 2.5 * NOISE
    worse = [name for name in RIVALS[model_id] if name not in level]
    assert worse, "no rival was told from the truth"
    for name in worse:
        assert fitted[name].errors.heldout_rmse_rad > 0.9 * own.errors.heldout_rmse_rad


@pytest.mark.parametrize("model_id", list(TRUTHS))
def test_a_model_finds_its_own_parameters(model_id: str) -> None:
    """Every parameter within 99.9 % of its posterior: one false alarm in about 40 such suites."""
    prepared, fitted, _ = compared(model_id)
    found = fitted[model_id]
    truth = truth_of(model_id, Setting.of(prepared.record_course))
    assert set(found.parameters) == set(truth)
    for name, value in truth.items():
        if name == "initial_state":  # of the first reading that was kept, whichever that is
            continue
        q05, q50, q95 = (found.parameters[name].quantiles[level] for level in (0.05, 0.5, 0.95))
        # Twice the 90 % interval on the side where the truth lies: 3.3 standard deviations.
        side = (q95 - q50) if value > q50 else (q50 - q05)
        assert abs(value - q50) < 2.0 * side + 1e-12, name


@pytest.mark.parametrize("model_id", ["cubic", "zhang", "maxwell_slip", "taghirad"])
def test_one_sided_records_are_welcome(model_id: str) -> None:
    rng = np.random.default_rng(4)
    prepared = prepare(loop_of(model_id, rng, one_sided=True), Drive(), rng)
    cycle = SteadyCycle.of(prepared.record_course, 60.0)
    assert (cycle.low, cycle.width_torque) == (0.0, pytest.approx(30.0, rel=0.02))
    found = fit_model(prepared, model_id, cycle, rng, SHORT)
    assert found.errors.rmse_rad == pytest.approx(NOISE, rel=0.2)
    assert found.stiffness is not None
    assert found.stiffness.torque.min() > 0
    assert (found.width[0.5] > 1e-6) == BY_ID[model_id].hysteresis
