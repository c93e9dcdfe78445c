from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from hdprog.reporting import outlook
from hdprog.reporting.build import build_report
from hdprog.reporting.figures.loop_panel import PanelScales
from hdprog.reporting.figures.loops_overlay import _label, loops_overlay
from hdprog.reporting.style import house_style
from hdprog.reporting.summary import summary_json
from hdprog.results import DriveResult, TestResult
from tests.reporting import drives, explanations
from tests.reporting.page import Page, spaced
from tests.reporting.test_summary import SITUATIONS

HOSTILE = "<script>alert('1')</script>\"><img src=x onerror=alert(2)> $\\frac{x $ &amp; {{ 7*7 }}"


@pytest.fixture(name="page", scope="module", params=SITUATIONS)
def page_fixture(request: pytest.FixtureRequest) -> tuple[DriveResult, str, Page]:
    result: Any = SITUATIONS[request.param]()
    text = build_report(result)
    return result, text, Page(text)


def test_the_page_is_well_formed_and_its_headings_are_in_order(
    page: tuple[DriveResult, str, Page],
) -> None:
    _, text, found = page
    assert text.lstrip().startswith("<!DOCTYPE html>")
    assert found.faults == []
    assert ("html", {"lang": "en"}) in found.tags
    levels = [level for level, _ in found.headings]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    ids = [attributes["id"] for _, attributes in found.tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    links = [str(a["href"]) for tag, a in found.tags if tag == "a"]
    linked = {link[1:] for link in links if link.startswith("#")}
    assert linked <= set(ids)


def test_the_verdict_comes_first_and_the_warnings_next(page: tuple[DriveResult, str, Page]) -> None:
    _, _, found = page
    second = [text for level, text in found.headings if level == 2]
    assert second[0].split()[0] in {"Act", "Plan", "No", "Present"}
    assert second[1] == "Warnings"
    assert second[-4:] == ["Parameters", "Diagnostics", "Method", "Provenance"]


def test_nothing_is_fetched_and_nothing_runs(page: tuple[DriveResult, str, Page]) -> None:
    _, text, found = page
    for tag, attributes in found.tags:
        assert tag != "script"
        for name, value in attributes.items():
            assert not name.startswith("on")
            if name in {"src", "href", "srcset", "action", "data"}:
                assert str(value).startswith(("data:", "#")), (tag, name, str(value)[:60])
    # Clip paths inside a picture refer to the picture itself.
    assert set(re.findall(r"url\((.{3})", text)) <= {"%23"}
    assert "@import" not in text
    outside = set(re.findall(r"https?:(?://|%2F%2F)[^\"'%<> ]*", text))
    # Names of the SVG's own vocabulary, which nothing fetches.
    assert outside <= {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}


def test_every_picture_states_its_finding_and_has_a_caption(
    page: tuple[DriveResult, str, Page],
) -> None:
    _, _, found = page
    assert len(found.pictures) == len(found.captions)
    for picture, caption in zip(found.pictures, found.captions, strict=True):
        assert str(picture["src"]).startswith("data:image/svg+xml,%3Csvg")
        assert len(str(picture["alt"])) > 30
        assert str(picture["alt"]) in caption
        assert "To do:" in caption
        assert int(str(picture["width"])) > int(str(picture["height"]))


def test_each_test_has_a_panel_and_each_limit_a_trend(page: tuple[DriveResult, str, Page]) -> None:
    result, _, found = page
    third = [text for level, text in found.headings if level == 3]
    for test in result.tests:
        assert any(text.startswith(f"Test {test.test_id},") for text in third)
    assert ("Trend of each limited figure" in found.text) == (result.trend is not None)
    assert ("Remaining life" in [text for _, text in found.headings]) == bool(result.forecasts)


def test_the_same_result_gives_the_same_bytes() -> None:
    result = drives.wearing(drives.LOST_MOTION, drives.SECANT, count=3)
    assert build_report(result) == build_report(result)


def test_hostile_names_stay_text() -> None:
    result = drives.wearing(count=2)
    tests = tuple(
        replace(
            test,
            test_id=HOSTILE,
            note=HOSTILE,
            date=HOSTILE,
            event=HOSTILE,
            prior_name=HOSTILE,
            noise_model=HOSTILE,
            warnings=(HOSTILE,),
            residual_correlation=0.9,
        )
        for test in result.tests
    )
    hostile = replace(
        result,
        drive=replace(result.drive, id=HOSTILE, model=HOSTILE),
        tests=tests,
        warnings=(HOSTILE,),
        provenance=replace(
            result.provenance, command=HOSTILE, files={HOSTILE: HOSTILE}, versions={HOSTILE: "1"}
        ),
    )
    found = Page(build_report(hostile))
    assert found.faults == []
    assert {tag for tag, _ in found.tags} & {"script", "iframe", "object", "embed"} == set()
    assert all(set(picture) == {"src", "alt", "width", "height"} for picture in found.pictures)
    assert " ".join(HOSTILE.split()) in found.text
    assert "{{ 7*7 }}" in found.text


def test_twelve_long_tests_fit_into_two_megabytes() -> None:
    limits = (drives.LOST_MOTION, drives.SECANT, drives.WIDTH)
    result = drives.wearing(*limits, count=12, samples=35_000)
    found = explanations.drive_explanation(count=12)
    assert len(build_report(replace(result, explanation=found)).encode()) <= 2_000_000


def test_what_did_not_converge_is_marked_wherever_its_numbers_are() -> None:
    found = Page(build_report(drives.not_converged()))
    assert found.headings[1][1].endswith("provisional")
    assert found.text.index("Not converged: the fit of test t03") < found.text.index("Warnings")
    # A NO stood beside a good R-hat and ESS where the slip before the first sample was at fault.
    assert "the worst of the eight parameters; whatever else is sampled" in found.text
    # Overview, figures, parameters, diagnostics and the heading of its panel.
    assert len(re.findall(r"t03(?:, \d+ h)? not converged", found.text)) == 5
    told = [picture["alt"] for picture in found.pictures]
    doubtful = [str(alt).startswith("Not converged: provisional numbers. ") for alt in told]
    # Remaining life, two trends and all loops together; t07's own pictures are sound.
    assert doubtful == [True] * 4 + [False] * (len(told) - 4)
    assert found.text.count("Not converged: provisional numbers.") == 3 + 4
    assert any(
        str(picture["alt"]).startswith("Not converged. Test t03") for picture in found.pictures
    )
    single = drives.single_fit(drives.LOST_MOTION)
    doubted = drives.one_test(1, None, 0.3, single.drive, converged=False)
    only = Page(build_report(replace(single, tests=(doubted,))))
    assert all(str(picture["alt"]).startswith("Not converged") for picture in only.pictures)
    converged = Page(build_report(drives.wearing(drives.LOST_MOTION, drives.SECANT))).text
    assert "ot converged" not in converged.replace("did not converge", "")


def test_a_parameter_that_a_test_does_not_inform_is_said_to_be_so() -> None:
    found = Page(build_report(drives.single_fit(wear=0.0)))
    assert found.text.count("not informed by this test (0.04)") == 2


def test_structure_in_the_residual_is_warned_of() -> None:
    result = drives.wearing(count=3)
    tests = (*result.tests[:2], replace(result.tests[2], residual_correlation=0.8))
    text = Page(build_report(replace(result, tests=tests))).text
    assert "Test t03: The residual is more than noise" in text
    assert "neighbours are alike (correlation 0.80): structure remains" in text
    assert "The residual is more than noise" not in Page(build_report(result)).text


def test_equal_warnings_are_said_once_with_their_tests() -> None:
    result = drives.wearing(count=3)
    tests = tuple(
        replace(test, warnings=("Torque clips.", *(["Gap."] if i else [])))
        for i, test in enumerate(result.tests)
    )
    text = Page(build_report(replace(result, tests=tests))).text
    assert text.count("All tests: Torque clips.") == 1
    assert text.count("Tests t02 and t03: Gap.") == 1


def test_a_quick_run_is_marked() -> None:
    result = drives.wearing(count=2)
    quick = replace(result, provenance=replace(result.provenance, quick=True))
    text = Page(build_report(quick)).text
    assert "Quick run: fewer draws were made" in text
    assert "The run was quick, with fewer draws." in text


def test_what_the_prior_carried_is_said() -> None:
    text = Page(build_report(drives.wearing(count=3))).text
    assert "which the prior carries: volatility and clock exponent." in text


def test_risk_over_time_is_tabled_in_rising_order() -> None:
    text = Page(build_report(drives.wearing())).text
    assert "If nothing is done: the risk that a limit has been passed by then." in text
    table = text.split("If nothing is done: the risk that a limit has been passed by then.")[1]
    risks = [int(found) for found in re.findall(r"\d h (\d+) % (?:within|above)", table)]
    assert len(risks) >= 3
    assert risks == sorted(risks)


def test_the_maker_figures_stand_beside_the_tests() -> None:
    text = Page(build_report(drives.single_fit(), {"K1_Nm_per_rad": 3.1e4})).text
    assert "maker's catalogue" in text
    assert "31 000" in spaced(text)
    assert "maker's catalogue" not in Page(build_report(drives.single_fit())).text


def test_reports_do_not_touch_matplotlib_settings() -> None:
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    build_report(drives.single_fit())
    assert dict(mpl.rcParams) == before


def test_figures_with_lasting_effects_stand_below_those_without() -> None:
    result = drives.single_fit()
    whole = {"lost_motion_arcmin": dict.fromkeys((0.05, 0.25, 0.5, 0.75, 0.95), 1.25)}
    test = replace(result.tests[0], figures_with_effects=whole)
    told = replace(result, tests=(test,))
    assert "with lasting effects" not in Page(build_report(result)).text
    assert "t01 with lasting effects – – 1.25" in Page(build_report(told)).text
    assert summary_json(told)["tests"][0]["figures_with_effects"] == {
        "lost_motion_arcmin": {"q05": 1.25, "q25": 1.25, "q50": 1.25, "q75": 1.25, "q95": 1.25}
    }


def test_the_risk_of_waiting_is_told_at_the_hours_at_which_something_is_to_be_done() -> None:
    """Round hours alone can all lie past the inspection where little is known of the date."""
    result = drives.wearing(crossing=9_000.0, spread=4_500.0, never=0.3, samples=600)
    main = result.forecasts[0]
    due, told = outlook.inspection_hours(main), dict(outlook.deciding_risks(result))
    assert due is not None
    assert min(outlook.waiting_hours(main)) > due
    assert told[due] <= main.acceptable_risk
    assert told[drives.SHUTDOWN] == main.probability_crossed_by_shutdown


def test_waiting_is_told_up_to_the_horizon_where_the_risk_of_now_is_all_there_is() -> None:
    crossings = np.concatenate([np.full(160, 900.0), np.full(3840, np.inf)])
    main = drives.forecast_of(drives.LOST_MOTION, crossings, 900.0)
    assert outlook.risk_now(main) == pytest.approx(0.04)
    assert outlook.waiting_hours(main) == [5_000.0, 10_000.0, 15_000.0, 20_000.0]


def test_angles_of_loops_to_different_torques_are_not_compared() -> None:
    owner = drives.drive()
    tests = [drives.one_test(n, 100.0 * n, 0.3, owner, samples=600) for n in (1, 2)]
    small = replace(
        tests[1].fit, torque=0.5 * tests[1].fit.torque, fitted=0.5 * tests[1].fit.fitted
    )

    def told(*both: TestResult) -> str:
        with house_style():
            return spaced(loops_overlay(both, PanelScales.of(both)).alt)

    assert told(*tests).endswith(" arcmin.")
    assert told(tests[0], replace(tests[1], fit=small)).endswith(
        "and the torque over it from 125 to 62.6 Nm: the angles do not compare."
    )
    new = replace(tests[1], event="replaced")
    assert told(tests[0], new).startswith("The last test, the first since the drive was replaced,")
    assert told(*tests, new, new).count("since the drive was replaced") == 1


def test_a_test_whose_name_begins_with_an_underscore_is_in_the_legend() -> None:
    axes = Figure().add_subplot()
    axes.plot([0.0], label=_label(drives.one_test(1, 0.0, 0.3, drives.drive(), test_id="_01")))
    assert [spaced(text.get_text()).strip() for text in axes.legend().get_texts()] == ["_01  0 h"]


def test_a_risk_beside_the_accepted_one_is_told_from_it_everywhere() -> None:
    result = drives.wearing(samples=600)
    close = replace(result.forecasts[0], probability_crossed_by_shutdown=0.054)
    text = Page(build_report(replace(result, forecasts=(close,)))).text
    assert "risk 5 % by the next shutdown" not in text
    assert text.count("5.4 %") >= 3
