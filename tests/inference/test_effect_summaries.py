"""Parameters of the effects of a fit, from its draws."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from hdprog.inference.posterior import Posterior
from hdprog.inference.summarise import effect_summaries
from hdprog.physics.course import Scales
from hdprog.physics.effects import BY_ID


def test_every_parameter_of_an_effect_has_its_quantiles_and_its_unit() -> None:
    creep = BY_ID["creep"]
    scales = Scales(60.0, 1e-3, 1.0, 200.0, None, readings=100)
    names = {one.name: one.unit for one in creep.parameters(scales)}
    draws = {name: np.linspace(0.0, 1.0, 101)[:, None] for name in names}
    course = SimpleNamespace(scales=scales)
    likelihood = SimpleNamespace(effects=(creep,), reduced=SimpleNamespace(course=course))
    posterior = SimpleNamespace(likelihood=likelihood, effect_values={"creep": draws})
    [found] = effect_summaries(cast("Posterior", posterior))
    assert (found.id, dict(found.units)) == ("creep", names)
    assert names["time_constant"] == "s"
    for levels in found.parameters.values():
        assert [levels[at] for at in (0.05, 0.5, 0.95)] == pytest.approx([0.05, 0.5, 0.95])
