"""The catalogue's entries, and the priors of all sizes and ratios made from them."""

from __future__ import annotations

import csv
import math
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.errors import BadInputError
from hdprog.inference.catalogue import (
    CatalogueGear,
    CatalogueNumbers,
    find_gear,
    gears,
    look_up,
    model_key,
    ratio_doubt,
)
from hdprog.inference.catalogue_prior import (
    WIDTH_OF_THRESHOLD,
    catalogue_prior,
    centred,
    median_stiffness,
    scaled,
)
from hdprog.inference.prior_file import name_of_model, names, prior_of_drive, read_prior_file
from hdprog.inference.prior_predictive import catalogue_curve, prior_predictive
from hdprog.inference.prior_text import gear_text
from hdprog.inference.priors import RecordScales
from hdprog.physics.parameters import NAMES
from hdprog.shipped import shipped
from tests.independent.simulator import INITIAL
from tests.inference.inverse import coordinates_of
from tests.physics.table2 import POST_TEST

FOLDER = shipped("priors") / "catalogue"
MODELS = [model for gear in gears() for model in gear.models]
OF_CSF_25_80 = CatalogueNumbers(T1=14, T2=48, K1=3.1e4, K2=5.0e4, K3=5.7e4)
SLOPES = ("K1_Nm_per_rad", "K2_Nm_per_rad", "K3_Nm_per_rad")


def label(gear: CatalogueGear) -> str:
    return gear.name


each_gear = pytest.mark.parametrize("gear", gears(), ids=label)


@pytest.mark.measured
def test_the_entries_are_those_of_the_collected_tables(measured_data: Path) -> None:
    table = measured_data / "catalogue" / "torsional_stiffness.csv"
    with table.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    keys = [*(f"T{i}_Nm" for i in (1, 2)), *SLOPES]
    collected = {
        (row["size"], row["ratio"].rstrip("+")): tuple(float(row[key]) for key in keys)
        for row in rows
    }
    shipped_here = {
        (str(gear.size), str(gear.ratio)): tuple(gear.numbers.table[key] for key in keys)
        for gear in gears()
    }
    assert len(rows) == len(gears()) == 23
    assert shipped_here == collected
    for row, gear in zip(rows, gears(), strict=True):
        assert set(row["series"].split("/")) <= set(gear.series)
        assert gear.source


@each_gear
def test_the_files_are_up_to_date(gear: CatalogueGear) -> None:
    """After a change: hdprog prior from-catalogue --all --out priors/catalogue."""
    text = (FOLDER / f"{gear.name}.toml").read_text("utf-8")
    made = gear_text(gear)

    def words(text: str) -> list[str]:
        return [line for line in text.splitlines() if not line.startswith(("median", "coord"))]

    assert words(text) == words(made)
    found, expected = tomllib.loads(text)["parameters"], tomllib.loads(made)["parameters"]
    # A median has a grain: rounding decides where in a flat valley the best point is taken to lie.
    for name in NAMES:
        slack = 0.15 if name == "T_T" else 0.0  # a tenth of its prior's spread
        assert found[name] == pytest.approx(expected[name], rel=0.05, abs=slack), name


def test_no_file_is_left_over() -> None:
    files = {entry.name for entry in FOLDER.iterdir()}
    assert files == {f"{gear.name}.toml" for gear in gears()}
    assert {gear.name for gear in gears()} < set(names())


@each_gear
def test_medians_of_stiffness_are_the_catalogues(gear: CatalogueGear) -> None:
    # Gears of ratio 30 stiffen beyond T2 by half, more steeply than the law of the teeth does.
    within = 0.22 if gear.ratio == 30 else 0.12
    prior = read_prior_file(gear.name).prior(None)
    predictive = prior_predictive(prior, np.random.default_rng(1), draws=20_000, loops=1)
    # The median of 20 000 draws of a log-sd of 0.6 has a standard error of 0.5 per cent.
    for slope in SLOPES:
        ratio = np.median(predictive.figures[slope]) / prior.catalogue[slope]
        assert 1 - within < ratio < 1 + within, (slope, ratio)
        # Table 2's worn gear has 0.39, 0.56 and 0.54 of the catalogue's K1, K2 and K3.
        low, high = np.quantile(predictive.figures[slope], [0.05, 0.95])
        assert low < (0.45 if slope == SLOPES[0] else 0.6) * prior.catalogue[slope]
        assert high > 1.4 * prior.catalogue[slope]


@pytest.mark.parametrize("degrees", [20, 30])
@pytest.mark.parametrize("name", [name for name in names() if name != "generic"])
def test_draws_are_drives(name: str, degrees: int) -> None:
    prior = read_prior_file(name).prior(None)
    alpha = math.radians(degrees)
    predictive = prior_predictive(prior, np.random.default_rng(2), alpha=alpha, loops=10)
    assert predictive.in_support > 0.995
    assert np.isfinite(predictive.loops).all()
    assert all(np.isfinite(values).all() for values in predictive.figures.values())
    width = predictive.figures["hysteresis_width_arcmin"]
    # Table 2's two gears have 0.42 and 0.30 arcmin at 30° and 0.24 and 0.17 at 20°.
    assert 0.05 < np.median(width) < 1.2
    assert np.quantile(width, 0.95) < 4
    assert (width >= 0).all()
    assert (width < 1e-6).mean() < 0.06  # preload so high that the wave generator never slips
    # Width is friction: it goes with torque over stiffness, whatever the size.
    numbers = prior.catalogue
    relative = np.median(width) / (numbers["T2_Nm"] / numbers["K3_Nm_per_rad"])
    table_2 = 0.36 if degrees == 30 else 0.205
    assert 0.5 < relative / (table_2 / (48 / 5.7e4)) < 1.6


def test_at_a_tooth_angle_of_20_degrees_gears_are_stiffer_by_what_is_stated() -> None:
    """An eighth at most; the guide to priors says so."""
    most = 0.0
    for gear in gears():
        prior = read_prior_file(gear.name).prior(None)
        at_20, at_30 = (
            prior_predictive(
                prior, np.random.default_rng(3), alpha=math.radians(degrees), draws=5000, loops=1
            ).figures
            for degrees in (20, 30)
        )
        stiffer = [np.median(at_20[slope]) / np.median(at_30[slope]) for slope in SLOPES]
        assert min(stiffer) > 1
        most = max(most, *stiffer)
    # The same draws at both angles: the ratio of their medians scatters by half a per cent.
    assert most == pytest.approx(1.125, abs=0.01)


def test_csf_25_80_comes_back_where_the_catalogue_says_what_it_says() -> None:
    own = read_prior_file("csf-25-80").prior(None)
    slopes = median_stiffness(own, OF_CSF_25_80)
    same = replace(OF_CSF_25_80, K1=slopes[0], K2=slopes[1], K3=slopes[2])
    np.testing.assert_allclose(centred(own, same).mean, own.mean, atol=1e-12)
    alike = scaled(own, OF_CSF_25_80, OF_CSF_25_80)
    np.testing.assert_array_equal(alike.mean, own.mean)
    assert alike.softplus_scale == own.softplus_scale


def test_the_catalogues_csf_25_80_differs_by_what_is_stated() -> None:
    """The identified prior lies between new and worn, the catalogue's on new gears."""
    own, made = read_prior_file("csf-25-80").prior(None), read_prior_file("csg-25-80").prior(None)
    z = dict(zip(NAMES, (made.mean - own.mean) / own.sd, strict=True))
    assert z["c"] == z["T_i"] == z["mu"] == 0
    assert max(abs(z[name]) for name in ("K_F", "K_W", "a", "b", "T_T")) < 1.6
    sd = dict(zip(NAMES, made.sd, strict=True))
    assert sd["T_T"] == WIDTH_OF_THRESHOLD
    assert {n: s for n, s in sd.items() if n != "T_T"} == {
        n: s for n, s in zip(NAMES, own.sd, strict=True) if n != "T_T"
    }
    shares = median_stiffness(own, OF_CSF_25_80) / np.array([3.1e4, 5.0e4, 5.7e4])
    np.testing.assert_allclose(shares, [0.8, 0.6, 0.5], atol=0.04)


@pytest.mark.parametrize("state", ["new", "worn", "heavily worn"])
def test_the_catalogues_csf_25_80_covers_table_2(state: str) -> None:
    prior = read_prior_file("csg-25-80").prior(None)
    values = INITIAL.as_dict() if state == "new" else dict(POST_TEST)
    if state == "new":
        # T_T = 0 has no coordinate: take one that stiffens teeth by 4 % and the gear by 0.5 %.
        values = {**values, "a": POST_TEST["a"], "T_T": 3.0}
        assert values["a"] * values["T_T"] < 0.04 * values["b"]
    elif state == "heavily worn":
        values = {**values, "b": 4500.0, "T_T": 40.0}
    z = (coordinates_of(prior, values) - prior.mean) / prior.sd
    assert (np.abs(z) < 2).all(), dict(zip(NAMES, z.round(2), strict=True))


def test_priors_scale_with_size() -> None:
    """Twice the torques and eight times the stiffness: the same drive in other units."""
    numbers = OF_CSF_25_80
    other = CatalogueNumbers(2 * 14, 2 * 48, 8 * 3.1e4, 8 * 5.0e4, 8 * 5.7e4)
    one = catalogue_prior("one", numbers, "made up").prior(None)
    two = catalogue_prior("two", other, "made up").prior(None)
    ratio = {n: float(np.exp(two.mean[i] - one.mean[i])) for i, n in enumerate(NAMES)}
    expected = {"K_F": 8, "K_W": 8, "a": 4, "b": 8, "T_T": 1, "c": 1, "T_i": 2, "mu": 1}
    assert ratio == pytest.approx(expected, rel=0.01)  # three digits are kept
    assert two.softplus_scale == 2 * one.softplus_scale


@pytest.mark.parametrize("model", MODELS)
def test_every_model_has_a_prior_in_either_case(model: str) -> None:
    scales = RecordScales(secant_stiffness=1.0, largest_torque=1.0)
    _, size, ratio = model.split("-")
    for written in (model, model.lower(), f" {model}-2UH"):
        prior, remark = prior_of_drive(Drive(model=written), scales)
        assert remark is None
        assert prior.name == name_of_model(model)
        assert prior.name.split("-")[1] == size
        assert prior.name.endswith("-80" if int(ratio) >= 80 else f"-{ratio}")
        gear = find_gear(model)
        assert gear is not None
        found = {key: prior.catalogue[key] for key in gear.numbers.table}
        assert found == gear.numbers.table
    assert read_prior_file(model) == read_prior_file(model.lower())


def test_a_prior_of_the_models_own_name_comes_first() -> None:
    assert name_of_model("CSF-25-80") == "csf-25-80"
    assert name_of_model("csf-25-80-2A-GR") == "csf-25-80"
    assert name_of_model("CSF-25-100") == "csg-25-80"
    assert name_of_model("HFUC-25-80") == "csg-25-80"


@pytest.mark.parametrize(
    "model", ["CSF-25-81", "CSF-26-80", "HFUC-25-50", "CSF-40-30", "RV-40E-121", "CSF-25", "x"]
)
def test_a_model_that_is_in_no_catalogue_has_none(model: str) -> None:
    assert name_of_model("") is None
    assert name_of_model(model) is None
    prior, remark = prior_of_drive(Drive(model=model), RecordScales(2.5e4, 40.0))
    assert prior.name == "generic"
    assert remark is not None


def test_a_prior_is_not_picked_by_a_name_that_goes_on() -> None:
    assert model_key("csf-25-80-worn") == "csf-25-80"
    with pytest.raises(BadInputError, match="no prior called 'csf-25-80-worn'"):
        read_prior_file("csf-25-80-worn")


@pytest.mark.parametrize(
    ("wanted", "expected"),
    [
        (("RV", 25, 80), "one of CSF, CSG, HFUC, SHG, HFUS"),
        (("csf", 26, 80), "of CSF one of the sizes 14, 17, 20, 25, 32, 40, 45, 50, 58, 65"),
        (("CSF", 25, 81), "of CSF-25 one of the ratios 30, 50, 80, 100, 120, 160"),
    ],
)
def test_a_look_up_says_what_there_is(wanted: tuple[str, int, int], expected: str) -> None:
    with pytest.raises(BadInputError) as refused:
        look_up(*wanted)
    assert refused.value.expected == expected
    assert "--K1" in refused.value.advice


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"K1": 0.0}, "K1_Nm_per_rad = 0; expected a number above zero"),
        ({"K3": math.nan}, "K3_Nm_per_rad = nan"),
        ({"T1": 60.0}, "T1 = 60 Nm and T2 = 48 Nm; expected T1 below T2"),
        ({"K2": 6e4}, "K1 = 31000, K2 = 60000 and K3 = 57000 Nm/rad; expected K1 at most K2"),
        ({"K1": 3.1, "K2": 5.0, "K3": 5.7}, r"torsion of 11\.3 rad at T2; .*10⁴ Nm/rad"),
        ({"K1": 9.0, "K2": 14.5, "K3": 16.6}, "Nm/arcmin"),
        ({"rated_torque": -63.0}, "rated_torque_Nm = -63"),
    ],
)
def test_numbers_that_no_gear_has_are_refused(change: dict[str, Any], said: str) -> None:
    OF_CSF_25_80.check("here")
    with pytest.raises(BadInputError, match=said) as refused:
        replace(OF_CSF_25_80, **change).check("here")
    assert refused.value.where == "here"


def test_the_catalogues_line_has_three_slopes() -> None:
    prior = read_prior_file("csg-25-80").prior(None)
    torque = np.array([0.0, 7.0, 14.0, 48.0, 63.0])
    angle = catalogue_curve(prior, torque)
    assert angle is not None
    expected = np.cumsum([0, 7 / 3.1e4, 7 / 3.1e4, 34 / 5.0e4, 15 / 5.7e4])
    np.testing.assert_allclose(angle, expected)
    assert catalogue_curve(replace(prior, catalogue={}), torque) is None


@pytest.mark.parametrize(
    ("model", "ratio", "doubtful"),
    [
        ("CSF-25-80", 80.0, False),
        ("CSF-25-80", 81.0, False),  # driven at the circular spline
        ("csg-25-100-2UH", 100.0, False),
        ("CSF-25-80", 100.0, True),
        ("csg-25-100-2UH", 80.0, True),
        ("CSF-25-80", None, False),
        ("ZZZ", 80.0, False),
        (None, 80.0, False),
    ],
)
def test_another_ratio_than_the_models_is_told(
    model: str | None, ratio: float | None, doubtful: bool
) -> None:
    assert (ratio_doubt(model, ratio) is not None) == doubtful
