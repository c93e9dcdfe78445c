"""What a test leaves open: said once, in the right words, and not where nothing is open."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from hdprog.config import Limit
from hdprog.inference.power_scaling import diagnose
from hdprog.reporting.build import build_report
from hdprog.reporting.summary import summary_json
from hdprog.reporting.weak_words import moved_by_angle, prior_driven, weak_words
from hdprog.results import (
    Combination,
    DriveResult,
    Identification,
    OtherToothAngle,
    Sensitivity,
    TestResult,
)
from tests.reporting import drives
from tests.reporting.page import Page, spaced

PRELOAD = Limit("preload_Nm", 60.0, "below")
STIFFNESS = Combination(
    {0.05: 50280.0, 0.25: 50390.0, 0.5: 50460.0, 0.75: 50530.0, 0.95: 50650.0}, 1
)
FRICTION = Combination({0.05: 8.3, 0.25: 8.5, 0.5: 8.7, 0.75: 8.9, 0.95: 9.1}, 0.999)
OPEN = Identification(62.9, 0.995, True, STIFFNESS, FRICTION)
SETTLED = Identification(100.0, 0.01, False, STIFFNESS, FRICTION)


def only_test(result: DriveResult) -> TestResult:
    return result.tests[0]


def single(*limits: Limit, wear: float = 0.3, **changes: object) -> DriveResult:
    result = drives.single_fit(*limits, wear=wear)
    return replace(result, tests=(replace(result.tests[0], **changes),))  # type: ignore[arg-type]


def turned(test: TestResult, factor: dict[str, float]) -> OtherToothAngle:
    """The test's numbers with some of them multiplied."""

    def times(levels: dict[float, float], name: str) -> dict[float, float]:
        return {level: value * factor.get(name, 1.001) for level, value in levels.items()}

    return OtherToothAngle(
        math.radians(20.0),
        {name: times(dict(one.quantiles), name) for name, one in test.parameters.items()},
        {key: times(dict(levels), key) for key, levels in test.figures.items()},
    )


def widened(test: TestResult, key: str) -> dict[str, dict[float, float]]:
    """The test's figures, one of them with a wide interval."""
    wide = {level: value * (0.5 + level) for level, value in test.figures[key].items()}
    return {**{k: dict(v) for k, v in test.figures.items()}, key: wide}


def test_nothing_open_nothing_said() -> None:
    assert weak_words(only_test(drives.single_fit())) == []
    settled = single(identification=SETTLED, sensitivity={"K_F": Sensitivity(0.0, 0.1, "record")})
    assert weak_words(only_test(settled)) == []
    text = Page(build_report(settled)).text
    assert "What is known together" not in text
    assert "What each number rests on" not in text
    assert "tooth angle is not declared" not in text


def test_what_is_known_together_is_said_and_tabled() -> None:
    result = single(drives.LOST_MOTION, identification=OPEN)
    said = weak_words(only_test(result))
    assert all(text.startswith("Of the parameters, ") for text in said)
    assert "one spring" in said[0]
    assert "below the preload torque" in said[1]
    page = spaced(Page(build_report(result)).text)
    assert all(text in page for text in ("50 460", "50 280 to 50 650", "8.3 to 9.1"))
    found = summary_json(result)["tests"][0]
    assert found["warnings"] == said
    assert found["identification"]["combined_stiffness_Nm_per_rad"]["q50"] == 50460.0
    assert found["identification"]["one_spring"] is True


def test_tests_of_which_the_same_is_said_are_named_in_one() -> None:
    result = drives.wearing(count=3)
    tests = tuple(replace(test, identification=OPEN) for test in result.tests)
    text = Page(build_report(replace(result, tests=tests))).text
    assert text.count("act as one spring") == 1
    assert "All tests: Of the parameters, K_F" in text
    mixed = (tests[0], replace(tests[1], warnings=("Torque clips.",)), tests[2])
    text = Page(build_report(replace(result, tests=mixed))).text
    assert text.index("Torque clips.") < text.index("act as one spring")


def test_parameters_of_one_spring_are_not_named_twice() -> None:
    alone = weak_words(only_test(single(wear=0.0)))
    assert alone == [
        "Of the parameters, the record says nothing of a and T_T; their intervals are the prior's."
    ]
    assert len(weak_words(only_test(single(wear=0.0, identification=OPEN)))) == 2


@pytest.mark.parametrize(
    ("prior", "record", "wide", "said"),
    [(0.3, 0.1, True, True), (0.3, 0.1, False, False), (0.01, 0.3, True, False)],
)
def test_a_limited_figure_that_is_the_priors_is_said_first(
    prior: float, record: float, wide: bool, said: bool
) -> None:
    result = single(PRELOAD, identification=OPEN)
    test = replace(
        only_test(result),
        sensitivity={"preload_Nm": Sensitivity(prior, record, diagnose(prior, record))},
    )
    if wide:
        test = replace(test, figures=widened(test, "preload_Nm"))
    assert prior_driven(test, "preload_Nm") == said
    first = weak_words(test)[0]
    assert first.startswith("Preload has a limit") == said
    assert ("loaded beyond the preload torque" in first) == said
    # Without a limit on it, nobody at the drive is to be troubled.
    other = replace(test, drive=drives.drive(drives.LOST_MOTION))
    assert not any("has a limit" in text for text in weak_words(other))


def test_disagreements_are_named_in_words_and_in_the_table() -> None:
    result = single(
        sensitivity={
            "T_i": Sensitivity(0.3, 0.4, "conflict", -4.2),
            "K_W": Sensitivity(0.01, 0.1, "overruled", 5.0),
        }
    )
    said = weak_words(only_test(result))
    assert said[0].startswith("The prior and the record disagree about T_i;")
    assert said[1].startswith("The record puts K_W far from where the prior expected it;")
    text = Page(build_report(result)).text
    assert "they disagree prior 0.30, record 0.40" in text
    assert summary_json(result)["tests"][0]["sensitivity"]["T_i"] == {
        "prior": 0.3,
        "record": 0.4,
        "rests_on": "conflict",
        "shift_from_prior": -4.2,
    }


def test_what_another_tooth_angle_changes_is_tabled() -> None:
    plain = single(drives.LOST_MOTION, PRELOAD)
    other = turned(only_test(plain), {"K_W": 0.4, "mu": 0.7, "c": 0.95, "preload_Nm": 0.92})
    test = replace(only_test(plain), other_tooth_angle=other)
    result = replace(plain, tests=(test,))
    assert moved_by_angle(test) == ["K_W", "c", "mu", "preload_Nm"]
    text = spaced(Page(build_report(result)).text).replace("\u2212", "-")
    assert "The gear-tooth angle is not declared; 30° is assumed. With 20°" in text
    assert "-60 %" in text
    assert "loss, lost motion and stiffness change by less than 0.2 %" in text
    assert weak_words(test) == [
        "Preload has a limit and depends on the gear-tooth angle, which is not declared. Set "
        "alpha_deg in drive.toml; Parameters shows what another angle gives."
    ]
    found = summary_json(result)["tests"][0]["other_tooth_angle"]
    assert found["alpha_deg"] == 20.0
    assert found["parameters"]["K_W"]["q50"] == pytest.approx(
        0.4 * test.parameters["K_W"].quantiles[0.5]
    )
    assert summary_json(plain)["tests"][0]["other_tooth_angle"] is None


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_side_without_load_is_said_to_be_mirrored(sign: float) -> None:
    whole = only_test(single())
    torque = sign * np.abs(whole.fit.torque)
    torque[7] = -0.05 * torque[7]  # an overshoot at the turn loads no side
    result = single(fit=replace(whole.fit, torque=torque))
    said = [text for text in weak_words(only_test(result)) if "mirror" in text]
    assert len(said) == 1
    assert said[0].startswith("The drive was loaded to one side only. Width, loss and lost motion")
    assert said[0] in summary_json(result)["tests"][0]["warnings"]
    assert said[0] in Page(build_report(result)).text


def test_a_figure_of_zero_has_no_change_in_per_cent() -> None:
    plain = single()
    key, none = "hysteresis_width_arcmin", dict.fromkeys((0.05, 0.25, 0.5, 0.75, 0.95), 0.0)
    other = turned(only_test(plain), {"K_W": 0.4})
    test = replace(
        only_test(plain),
        figures={**only_test(plain).figures, key: none},
        other_tooth_angle=replace(other, figures={**other.figures, key: none}),
    )
    assert "-60 %" in spaced(Page(build_report(replace(plain, tests=(test,)))).text).replace(
        "\u2212", "-"
    )
