"""A load that is missing switches off all of them, and that is told of."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hdprog.data.loads_of_tests import load_doubts
from hdprog.data.tests_table import DriveTest


def made(
    hours: float, torque: float | None, speed: float | None = None, event: str | None = None
) -> DriveTest:
    name = f"t{hours:g}"
    return DriveTest(
        name, Path("a.csv"), hours, event=event, mean_torque_Nm=torque, mean_speed_rpm=speed
    )


def new(hours: float, torque: float | None) -> DriveTest:
    """Of a drive that was replaced before the test."""
    return made(hours, torque, event="replaced")


@pytest.mark.parametrize(
    ("tests", "words"),
    [
        ([made(0, None), made(500, None)], {}),
        ([made(0, None), made(500, 20.0), made(900, 30.0)], {}),
        ([made(250, None), made(500, 20.0)], {"t250": "mean_torque_Nm.*from 0 to 250"}),
        ([made(0, 20.0), made(500, None), made(900, 30.0)], {"t500": "mean_torque.*500"}),
        # Tests at the same hours have no stretch between them.
        ([made(500, 20.0), made(500, None)], {}),
        ([made(500, 20.0, 900.0), made(900, 30.0)], {"t900": "Speeds are not.*mean_speed_rpm"}),
        # What a drive before was loaded with is nothing of the one that runs now.
        ([new(5000, None), made(5300, 30.0)], {}),
        ([made(250, None), made(500, None), new(900, None), made(1200, 30.0)], {}),
        ([new(5000, 20.0), made(5300, None)], {"t5300": "Loads are not.*5000 to 5300"}),
        (
            [made(250, 20.0), made(500, None), new(500, None), made(900, 30.0)],
            {"t500": "Loads of the drive that was replaced are not counted.*250 to 500"},
        ),
        ([made(0, 0.0), made(300, 0.0, 0.0)], {"t300": "mean_torque_Nm is 0 wherever"}),
        ([made(300, 20.0, 0.0), made(500, 20.0, 0.0)], {"t300": "mean_speed_rpm is 0 wherever"}),
        ([made(300, 0.0), made(500, 20.0)], {}),  # it stood still
    ],
)
def test_the_first_stretch_without_a_load_is_named(
    tests: list[DriveTest], words: dict[str, str]
) -> None:
    found = load_doubts(tests)
    assert list(found) == list(words)
    for name, text in words.items():
        assert re.search(text, found[name])
