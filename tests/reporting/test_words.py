from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from hdprog.config import Drive
from hdprog.reporting.build import build_report
from hdprog.reporting.drive_name import drive_name
from hdprog.reporting.explain_json import explain_json
from hdprog.reporting.summary import summary_json
from hdprog.reporting.words import agree, keyboard_signs, quantity, tidy
from tests.reporting import drives, explanations
from tests.reporting.page import Page, spaced


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("gains -0.7, (-3) and -12 %", "gains −0.7, (−3) and −12 %"),
        ("log Bayes factor -0.0 where -0.04", "log Bayes factor 0.0 where −0.04"),
        ("csf-25-80, 18-26 Nm, 2026-03-02, --quick", "csf-25-80, 18-26 Nm, 2026-03-02, --quick"),
        ("4.29e+04 Nm/rad", "42 900 Nm/rad"),
        ("-1.5e-03 rad and 1e-05 rad", "−0.0015 rad and 1 × 10⁻⁵ rad"),
        ("run-1e-05.csv", "run-1e-05.csv"),
    ],
)
def test_numbers_from_anywhere_look_alike_on_a_page(text: str, shown: str) -> None:
    assert spaced(tidy(text)) == shown
    assert tidy(tidy(text)) == tidy(text)


def test_a_terminal_gets_the_sign_of_the_keyboard() -> None:
    assert keyboard_signs("−4 % to 3") == "-4 % to 3"


@pytest.mark.parametrize(
    ("key", "name"),
    [
        ("secant_stiffness_Nm_per_rad@9.16813Nm", "secant stiffness at 9.17 Nm"),
        ("secant_stiffness_Nm_per_rad@0.0812345Nm", "secant stiffness at 0.0812 Nm"),
        ("secant_stiffness_Nm_per_rad@14Nm", "secant stiffness at 14 Nm"),
        ("local_stiffness_Nm_per_rad@1325Nm", "local stiffness at 1 325 Nm"),
    ],
)
def test_a_torque_from_a_record_is_rounded_and_a_declared_one_is_kept(key: str, name: str) -> None:
    assert spaced(quantity(key).name) == name


def test_words_agree_with_their_count() -> None:
    assert [agree(count, "does", "do") for count in (1, 2, 3)] == ["does", "do", "do"]


def test_a_drive_that_is_not_declared_has_the_name_of_its_file() -> None:
    result = replace(explanations.single(explanations.record()), drive=Drive.default())
    assert drive_name(result) == "t01"
    page = Page(build_report(result))
    assert page.headings[0] == (1, "t01")
    assert "drive not declared" in page.text
    assert summary_json(result)["drive"]["id"] == "t01"
    assert explain_json(result)["drive"]["id"] == "t01"


def test_a_declared_drive_keeps_its_name_whatever_it_is() -> None:
    result = drives.single_fit()
    assert drive_name(result) == "cell3-axis2"
    called = replace(Drive.default(), source=Path("drive.toml"))
    assert drive_name(replace(result, drive=called)) == "drive"
