"""What a comparison says of a model, read off made-up numbers."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from matplotlib.figure import Figure

from hdprog.comparison.results import ComparedModel, Comparison, StiffnessBand
from hdprog.physics.figures import ARCMIN_PER_RAD
from hdprog.physics.other_models import MODELS
from hdprog.reporting.comparison_words import at_end, verdict, width
from hdprog.reporting.figures import model_stiffness as stiffness_picture
from hdprog.reporting.figures.model_stiffness import _alt
from hdprog.reporting.style import house_style


def band(*torque: float) -> StiffnessBand:
    """Stiffness of 10 at the first torque, 30 at the last, give or take one."""
    middle = np.linspace(10.0, 30.0, len(torque))
    levels = {0.05: middle - 1.0, 0.25: middle, 0.5: middle, 0.75: middle, 0.95: middle + 1.0}
    return StiffnessBand(np.array(torque), levels)


@pytest.mark.parametrize(
    ("torque", "stiffness"),
    [((-50.0, 0.0, 50.0), 30.0), ((5.0, 50.0), 30.0), ((-50.0, -5.0), 10.0)],
)
def test_median_and_interval_are_of_the_same_torque(
    torque: tuple[float, ...], stiffness: float
) -> None:
    """Of a model that is not alike at both ends the median stood outside of its interval."""
    assert at_end(band(*torque)) == (stiffness - 1.0, stiffness, stiffness + 1.0)


def rigid_first(error: float = 7e-6) -> Comparison:
    """The rigid model is best, and the drive model level with it."""
    errors = SimpleNamespace(heldout_rmse_rad=error)
    models = [
        SimpleNamespace(id="rigid", words="rigid drive", stiffness=None, errors=errors),
        SimpleNamespace(id="drive", words="drive model", stiffness=band(5.0, 50.0), errors=errors),
    ]
    found = SimpleNamespace(
        models=models, level=models, amplitude=50.0, noise_floor_rad=7e-6, converged=True
    )
    found.of = {one.id: one for one in models}.get
    return cast("Comparison", found)


def test_a_stiffness_is_said_of_the_model_that_yields() -> None:
    """Where the rigid one is best, "its" stiffness was the drive model's."""
    found = rigid_first()
    assert "By the drive model the local stiffness at 50" in verdict(found).text
    assert _alt(found, found.models[1:]).startswith("On the drive model the local stiffness runs")


def test_a_drive_model_far_above_the_noise_points_to_the_search_for_what_it_lacks() -> None:
    assert "hdprog explain" not in verdict(rigid_first()).text
    assert (
        verdict(rigid_first(43e-6)).text.count(
            "`hdprog explain` looks for what the drive model lacks."
        )
        == 1
    )


def test_the_names_of_all_models_are_in_the_picture_of_stiffness(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The legend's longest names, with the mark of what did not converge, ran out of it."""
    drawn: list[Figure] = []
    monkeypatch.setattr(stiffness_picture, "picture", lambda figure, **_: drawn.append(figure))
    words = {"drive": "drive model (hdprog)", **{model.id: model.words for model in MODELS}}
    models = [
        SimpleNamespace(id=one, words=name, stiffness=band(5.0, 50.0), converged=False)
        for one, name in words.items()
    ]
    with house_style():
        stiffness_picture.model_stiffness(
            cast("Comparison", SimpleNamespace(models=models, amplitude=50.0))
        )
        (figure,) = drawn
        legend = figure.axes[0].get_legend()
        assert legend is not None
        assert legend.get_window_extent().x1 <= figure.bbox.x1


@pytest.mark.parametrize(
    ("high", "text"),
    [(0.34, "up to 0.4"), (0.3, "up to 0.3"), (0.0024, "up to 0.003"), (0.0, "up to 0.002")],
)
def test_what_a_width_is_at_most_is_rounded_up(high: float, text: str) -> None:
    quantiles = {0.05: 0.0, 0.5: 0.0, 0.95: high / ARCMIN_PER_RAD}
    model = cast("ComparedModel", SimpleNamespace(width=quantiles))
    assert width(model) == ("0", text)
