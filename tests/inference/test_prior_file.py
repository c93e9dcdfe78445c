"""Prior files: the shipped ones, a user's own, and wrong ones."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hdprog.config import Drive, Limit, read_drive
from hdprog.errors import BadInputError
from hdprog.inference.prior_file import names, prior_of_drive, read_prior_file
from hdprog.inference.priors import RecordScales
from hdprog.physics.parameters import BY_NAME, NAMES, in_support
from hdprog.shipped import shipped
from tests.independent.simulator import INITIAL
from tests.inference.inverse import coordinates_of
from tests.physics.table2 import POST_TEST

SHIPPED = (shipped("priors") / "csf-25-80.toml").read_text("utf-8")
SCALES = RecordScales(secant_stiffness=2.5e4, largest_torque=40.0)
TABLE_2 = {"new": INITIAL.as_dict(), "worn": POST_TEST}


def written(folder: Path, text: str, name: str = "own.toml") -> Path:
    path = folder / name
    path.write_text(text, "utf-8")
    return path


def test_the_shipped_names_are_priors_of_loops() -> None:
    # The folder also holds the prior of the trend, which is none of a loop.
    assert {"csf-25-80", "generic"} <= set(names())
    assert "trend" not in names()
    for name in names():
        assert read_prior_file(name).prior(SCALES).name == name


@pytest.mark.parametrize("state", TABLE_2)
def test_csf_25_80_covers_table_2(state: str) -> None:
    prior = read_prior_file("csf-25-80").prior(None)
    values = dict(TABLE_2[state])
    if state == "new":
        # A new drive has T_T = 0, where the coordinate is minus infinity and a means nothing: take
        # a of the worn one and a threshold that stiffens the teeth by less than one per cent.
        values["a"] = POST_TEST["a"]
        values["T_T"] = 0.5
        assert values["a"] * values["T_T"] < 0.01 * values["b"]
    point = coordinates_of(prior, values)
    z = (point - prior.mean) / prior.sd
    assert (np.abs(z) < 2).all(), dict(zip(NAMES, z.round(2), strict=True))


@pytest.mark.parametrize("name", ["csf-25-80", "generic"])
def test_prior_draws_go_there_and_back(name: str) -> None:
    prior = read_prior_file(name).prior(SCALES)
    draws = prior.sample(2000, np.random.default_rng(1))
    values = prior.to_physical(draws)
    np.testing.assert_allclose(coordinates_of(prior, values), draws, atol=1e-8)
    # Medians of 2 000 draws: 0.028 standard deviations each; four of that, 1 in 2 000 of eight.
    assert (np.abs(np.median(draws, axis=0) - prior.mean) < 0.112 * prior.sd).all()
    assert in_support(values, np.radians(30)).mean() > 0.5


def test_generic_is_centred_on_the_record() -> None:
    file = read_prior_file("generic")
    assert file.needs_record
    assert not read_prior_file("csf-25-80").needs_record
    one = file.prior(SCALES)
    other = file.prior(RecordScales(2 * SCALES.secant_stiffness, 3 * SCALES.largest_torque))
    ratio = {n: float(np.exp(other.mean[i] - one.mean[i])) for i, n in enumerate(NAMES)}
    expected = {"K_F": 2, "K_W": 2, "b": 2, "a": 2 / 3, "T_i": 3, "T_T": 1, "c": 1, "mu": 1}
    assert ratio == pytest.approx(expected)
    assert other.softplus_scale == pytest.approx(3 * one.softplus_scale)
    stiff = [index for index, name in enumerate(NAMES) if name in {"K_F", "K_W", "a", "b", "T_i"}]
    np.testing.assert_allclose(one.sd[stiff], 1.5)
    # Three springs in series at their medians are as stiff as the record, before a stiffens b.
    middle = {name: float(value) for name, value in one.to_physical(one.mean).items()}
    compliance = 1 / middle["K_F"] + np.tan(np.radians(30)) ** 2 / middle["K_W"] + 1 / middle["b"]
    assert 0.6 < SCALES.secant_stiffness * compliance < 1.5


def test_record_scales_are_spans() -> None:
    torque = np.array([0.0, 30.0, -40.0, 0.0])
    scales = RecordScales.of(torque, torque / 2e4 + 5.0)
    assert scales.secant_stiffness == pytest.approx(2e4)
    assert scales.largest_torque == 40


def test_the_drives_file_decides() -> None:
    named = Drive(prior="csf-25-80", model="UNKNOWN-1")
    prior, remark = prior_of_drive(named, SCALES)
    assert (prior.name, remark) == ("csf-25-80", None)
    prior, remark = prior_of_drive(replace(named, prior=None, model="CSF-25-80"), SCALES)
    assert (prior.name, remark) == ("csf-25-80", None)
    assert prior.catalogue_torques == (14, 48)


@pytest.mark.parametrize(
    ("model", "said"),
    [
        (None, "No model and no prior are declared"),
        ("UNKNOWN-1", "No prior is known for model UNKNOWN-1"),
    ],
)
def test_what_is_not_known_is_said(model: str | None, said: str) -> None:
    prior, remark = prior_of_drive(Drive(model=model), SCALES)
    assert prior.name == "generic"
    assert remark is not None
    assert said in remark
    assert "2.5e+04 Nm/rad" in remark


@pytest.mark.parametrize("name", ["csf-25-81", "trend", "", "../priors/csf-25-80"])
def test_an_unknown_name_is_refused(name: str) -> None:
    with pytest.raises(BadInputError, match=r"no prior called .*csf-25-80.*generic"):
        read_prior_file(name)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"no file .*own\.toml"):
        read_prior_file("own.toml", tmp_path)


def test_a_relative_path_starts_at_the_drives_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home, elsewhere = tmp_path / "home", tmp_path / "elsewhere"
    (home / "sub").mkdir(parents=True)
    elsewhere.mkdir()
    written(home / "sub", SHIPPED.replace('name = "csf-25-80"', 'name = "mine"'))
    toml = '[drive]\nid = "d"\nmodel = "CSF-25-80"\n[prior]\nfile = "sub/own.toml"\n'
    written(home, toml, "drive.toml")
    monkeypatch.chdir(elsewhere)
    prior, remark = prior_of_drive(read_drive(home / "drive.toml"), SCALES)
    assert (prior.name, remark) == ("mine", None)


def test_an_absolute_path_is_a_users_own(tmp_path: Path) -> None:
    text = SHIPPED.replace("median = 78000.0", "median = 50000.0").replace(
        "scale_Nm = 10.0", 'scale = 0.5\nscale_in = "largest_torque"'
    )
    path = written(tmp_path, text)
    prior = read_prior_file(str(path), tmp_path / "nowhere").prior(SCALES)
    assert np.exp(prior.mean[NAMES.index("K_F")]) == pytest.approx(50000)
    assert prior.softplus_scale == pytest.approx(20)


@pytest.mark.parametrize(
    ("old", "new", "said", "expected"),
    [
        (
            "[parameters.K_F]\nmedian",
            "[parameters.K_F]\nmiddle",
            "parameters.K_F.median",
            "only median, median_in, log_sd",
        ),
        ("log_sd = 0.4\n", "log_sd = -0.4\n", "parameters.K_F.log_sd", "greater than 0"),
        ("log_sd = 0.4\n", "log_sd = 50\n", "parameters.K_F.log_sd", "at most 5"),
        ("log_sd = 0.4\n", 'log_sd = "wide"\n', "parameters.K_F.log_sd", "without quotation marks"),
        ("log_sd = 0.4\n", "", "parameters.K_F.log_sd", "parameters.K_F.log_sd to be given"),
        ("[parameters.mu]", "[parameters.friction]", "parameters.mu", ", ".join(NAMES)),
        (
            "median = -1.16",
            "median = 1.16",
            "the median of c must be negative, not 1.16",
            "a negative number",
        ),
        (
            "median = 0.07",
            "median = -0.07",
            "the median of mu must be positive, not -0.07",
            "a positive number",
        ),
        (
            "median = 0.07",
            "median = 0.0",
            "the median of mu must be positive, not 0",
            "a positive number",
        ),
        ("median = 0.07", "median = 1.0", "parameters.mu.median = 1", "below 1"),
        (
            "scale_Nm = 10.0",
            "",
            "parameters.T_T: no scale; .*either scale_Nm, or scale",
            "together with scale_in",
        ),
        (
            "scale_Nm = 10.0",
            "scale = 10.0",
            "parameters.T_T: with scale; .*either scale_Nm, or scale",
            "together with scale_in",
        ),
        ("coordinate_sd = 2.0", "coordinate_sd = 0", "T_T.coordinate_sd", "greater than 0"),
        ("coordinate_sd = 2.0", "coordinate_sd = 2.0\nshape = 1", "T_T.shape", "coordinate_sd"),
        ("T1_Nm = 14.0", 'T1_Nm = "fourteen"', "catalogue.T1_Nm", "without quotation marks"),
        ("T1_Nm = 14.0", "", "catalogue: only T2_Nm", "or neither"),
        ("T1_Nm = 14.0", "T1_Nm = 49.0", "catalogue.T1_Nm = 49", "T1_Nm below T2_Nm"),
        ("source =", "origin =", "the key origin, .* and no source", "name, source, parameters"),
        ('name = "csf-25-80"', 'name = ""', "name = ''", "text that is not empty"),
        ("[parameters.K_F]", "[parameters.K_F", "own.toml", "TOML"),
    ],
)
def test_a_wrong_file_is_refused_by_the_key(
    old: str, new: str, said: str, expected: str, tmp_path: Path
) -> None:
    assert old in SHIPPED
    path = written(tmp_path, SHIPPED.replace(old, new, 1))
    with pytest.raises(BadInputError, match=said) as refused:
        read_prior_file(str(path))
    assert "own.toml" in refused.value.where
    assert expected in refused.value.expected
    assert refused.value.advice


def test_a_file_without_parameters_says_the_form(tmp_path: Path) -> None:
    path = written(tmp_path, 'name = "own"\nsource = "none"\n')
    with pytest.raises(BadInputError, match="found no parameters") as refused:
        read_prior_file(str(path))
    assert all(name in refused.value.expected for name in BY_NAME)


@pytest.mark.parametrize("value", ["nan", "inf"])
@pytest.mark.parametrize(
    ("key", "old"),
    [
        ("parameters.K_F.median", "median = 78000.0"),
        ("parameters.K_F.log_sd", "log_sd = 0.4"),
        ("parameters.T_T.coordinate_mean", "coordinate_mean = 0.5"),
        ("parameters.T_T.coordinate_sd", "coordinate_sd = 2.0"),
    ],
)
def test_numbers_must_be_finite(key: str, old: str, value: str, tmp_path: Path) -> None:
    path = written(tmp_path, SHIPPED.replace(old, f"{old.split(' =')[0]} = {value}", 1))
    with pytest.raises(BadInputError, match=key):
        read_prior_file(str(path))


def test_a_file_that_is_not_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_bytes(b"\xff\xfe\x00name")
    with pytest.raises(BadInputError):
        read_prior_file(str(path))


@pytest.mark.parametrize(
    ("quantity", "model", "reference", "words"),
    [
        ("K2_Nm_per_rad", None, 63.0, "no T1 and T2"),
        ("K1_Nm_per_rad", "XYZ-99", 63.0, "no T1 and T2"),
        ("K3_Nm_per_rad", "CSF-25-80", 40.0, "40 Nm of reference torque"),
        ("K3_Nm_per_rad", "CSF-25-80", None, "no rated or reference torque"),
        ("K3_Nm_per_rad", "CSF-25-80", 63.0, None),
        ("K2_Nm_per_rad", "CSF-25-80", 40.0, None),
    ],
)
def test_limits_between_the_makers_torques_need_these(
    quantity: str, model: str | None, reference: float | None, words: str | None
) -> None:
    limit = Limit(quantity, 20_000.0, "below")
    drive = Drive(model=model, rated_torque=reference, limits=(limit,))
    if words is None:
        prior_of_drive(drive, SCALES)
        return
    with pytest.raises(BadInputError, match=words):
        prior_of_drive(drive, SCALES)
