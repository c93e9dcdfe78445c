from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hdprog.units import _UNITS, ISO_8601, find_unit, known_units, parse_header


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("torque_Nm", "torque", "Nm"),
        ("Torque [Nm]", "torque", "Nm"),
        ("torque (N m)", "torque", "Nm"),
        ("TORQUE [N·m]", "torque", "Nm"),
        ("torque_N_m", "torque", "Nm"),
        ("torque / kNm", "torque", "kNm"),
        ("Torque, N.m", "torque", "Nm"),
        ("Torque in Nm", "torque", "Nm"),
        ("torque_in_lbf", "torque", "in·lbf"),
        ("Torque (in-lbf)", "torque", "in·lbf"),
        ("Torque [ft·lbf]", "torque", "ft·lbf"),
        ("torsion angle [°]", "torsion_angle", "deg"),
        ("angle_arcmin", "angle", "arcmin"),
        ("angle [′]", "angle", "arcmin"),
        ("angle [\u2033]", "angle", "arcsec"),
        ("angle [′′]", "angle", "arcsec"),
        ("angle [\u00b5rad]", "angle", "urad"),
        ("angle [\u03bcrad]", "angle", "urad"),
        ("output_angle_rad", "output_angle", "rad"),
        ("POSITION (rev)", "position", "rev"),
        ("time_s", "time", "s"),
        ("Time [ms]", "time", "ms"),
        ("time [ISO 8601]", "time", "ISO 8601"),
        ("temperature_C", "temperature", "C"),
        ("Temp (°F)", "temp", "F"),
    ],
)
def test_headers_that_are_understood(header: str, name: str, unit: str) -> None:
    parsed = parse_header(header)
    assert parsed.name == name
    assert parsed.unit is not None
    assert parsed.unit.name == unit


@pytest.mark.parametrize(
    "header",
    [
        "torque",
        "torque_in",
        "torque_out",
        "Torque []",
        "torque_lb",
        "angle [counts]",
        "torque [m Nm]",
        "time (m.s)",
    ],
)
def test_no_unit_is_guessed(header: str) -> None:
    assert parse_header(header).unit is None


@pytest.mark.parametrize("header", ["torque_m_Nm", "angle m rad", "time_m_s", "torque_k_N_m"])
def test_a_letter_apart_is_no_prefix(header: str) -> None:
    parsed = parse_header(header)
    assert parsed.name in {"torque_m", "angle_m", "time_m", "torque_k"}
    assert parsed.unit is not None
    assert parsed.unit.factor == 1.0


@pytest.mark.parametrize(
    ("unit", "value", "si"),
    [
        ("kNm", 1.0, 1000.0),
        ("in·lbf", 1.0, 0.1129848290276167),  # NIST SP 811, appendix B
        ("ft-lbf", 1.0, 1.3558179483314004),
        ("deg", 180.0, math.pi),
        ("arcmin", 60.0, math.pi / 180),
        ("arcsec", 3600.0, math.pi / 180),
        ("rev", 1.0, 2 * math.pi),
        ("mrad", 1.0, 1e-3),
        ("min", 1.0, 60.0),
        ("h", 1.0, 3600.0),
        ("K", 273.15, 0.0),
        ("°F", 32.0, 0.0),
        ("°F", 212.0, 100.0),
    ],
)
def test_conversion(unit: str, value: float, si: float) -> None:
    found = find_unit(unit)
    assert found is not None
    assert found.to_si(np.array([value]))[0] == pytest.approx(si, rel=1e-14, abs=1e-12)


def test_case_counts_only_where_it_changes_the_meaning() -> None:
    assert find_unit("NM") is find_unit("Nm")
    assert find_unit("DEG") is find_unit("deg")
    milli, mega = find_unit("mNm"), find_unit("MNm")
    assert milli is not None
    assert mega is not None
    assert mega.factor / milli.factor == pytest.approx(1e9)
    assert find_unit("MNM") is None
    assert find_unit("MRAD") is None


def test_every_listed_unit_is_found_again() -> None:
    for dimension in ("torque", "angle", "time", "temperature"):
        for name in known_units(dimension):
            unit = find_unit(name)
            assert unit is not None
            assert unit.dimension == dimension
    assert find_unit("ISO-8601") is ISO_8601


def test_every_spelling_is_one_that_can_be_found() -> None:
    for unit, spellings in _UNITS:
        for spelling in spellings:
            assert find_unit(spelling) is unit


@given(st.text(max_size=30))
def test_any_header_is_taken_apart_without_failing(text: str) -> None:
    parsed = parse_header(text)
    assert parsed.text == text.strip()
