"""A drive in a list of many: worst first, one sentence each."""

from __future__ import annotations

from dataclasses import asdict

import pytest

from hdprog.reporting.fleet_index import build_fleet_index, fleet_drive, shared_ids
from hdprog.reporting.fleet_words import fleet_entry
from hdprog.reporting.sparkline import sparkline
from hdprog.reporting.summary import summary_json
from hdprog.reporting.words import tidy
from hdprog.results import DriveResult
from tests.reporting import drives
from tests.reporting.page import Page, spaced


def in_all_situations() -> list[DriveResult]:
    return [
        drives.healthy(),
        drives.single_fit(drives.LOST_MOTION),
        drives.wearing(drives.LOST_MOTION, drives.SECANT, count=4),
        drives.past_limit(),
    ]


def test_worst_first() -> None:
    entries = [fleet_entry(summary_json(result)) for result in in_all_situations()]
    ordered = sorted(entries, key=lambda entry: (entry.rank, entry.rank_hours))
    assert ordered[0].status == "act"
    ranks = {"act": 0, "plan": 1, "present": 2, "good": 3}
    assert [ranks[e.status] for e in ordered] == sorted(ranks[e.status] for e in ordered)


@pytest.mark.parametrize("result", in_all_situations(), ids=lambda result: result.drive.id)
def test_one_sentence_that_stands_alone(result: DriveResult) -> None:
    entry = fleet_entry(summary_json(result))
    assert entry.sentence.endswith(".")
    assert entry.sentence[0].isupper()
    assert "\n" not in entry.sentence


def test_what_did_not_converge_says_so_beside_the_sentence() -> None:
    entry = fleet_entry(summary_json(drives.not_converged()))
    assert entry.provisional
    assert "provisional" in entry.label
    assert not entry.sentence.startswith("Not converged")


def test_the_one_sentence_of_fleet_json_says_that_it_is_provisional() -> None:
    ends = [
        fleet_drive("d", "d", summary_json(result))["sentence"].endswith(
            ". Not converged: this is provisional."
        )
        for result in (drives.not_converged(), drives.healthy())
    ]
    assert ends == [True, False]


@pytest.mark.parametrize("count", [1, 2])
def test_a_row_says_that_no_test_tells_the_pace(count: int) -> None:
    entry = fleet_entry(summary_json(drives.wearing(count=count)))
    words = " There is one test only: how fast this drive wears comes from the prior."
    assert entry.sentence.endswith(words) is (count == 1)
    assert not entry.sentence.startswith("There is")


def test_a_name_with_a_full_stop_ends_no_sentence() -> None:
    summary = summary_json(drives.not_converged())
    test = next(one["test_id"] for one in summary["tests"] if not one["converged"])
    told = [text.replace(test, "No. B") for text in summary["verdict"]["sentences"]]
    summary["verdict"] |= {"text": " ".join(told), "sentences": told}
    assert fleet_entry(summary).sentence == tidy(told[1])
    del summary["verdict"]["sentences"]  # as summaries were once
    assert fleet_entry(summary).sentence.startswith("B")


def test_the_course_is_of_the_leading_figure() -> None:
    summary = summary_json(drives.wearing(drives.LOST_MOTION, count=4))
    course = fleet_entry(summary).course
    assert course is not None
    assert course.limit == 2.0
    assert (course.name, course.unit) == ("lost motion", "arcmin")
    medians = [test["figures"]["lost_motion_arcmin"]["q50"] for test in summary["tests"]]
    assert [value for _, value in course.points] == medians


def test_without_a_limit_there_is_no_course() -> None:
    entry = fleet_entry(summary_json(drives.single_fit()))
    assert entry.course is None
    assert entry.remaining_hours == {}


def test_each_different_warning_of_drive_trend_and_tests_is_counted_once() -> None:
    summary = summary_json(drives.wearing(drives.LOST_MOTION, count=3))
    before = fleet_entry(summary).warnings
    summary["trend"]["warnings"] = ["Do not rely on the forecast of lost motion."]
    for test in summary["tests"][:2]:
        test["warnings"] = [*test["warnings"], "The same of two tests."]
    assert fleet_entry(summary).warnings == before + 2


def test_the_course_has_the_effects_that_the_limit_is_judged_with() -> None:
    summary = summary_json(drives.wearing(drives.LOST_MOTION, count=3))
    for test in summary["tests"]:
        test["figures_with_effects"] = {"lost_motion_arcmin": {"q50": 2.6}}
    seen = []
    for followed in ([], ["backlash"]):
        summary["trend"]["followed_effects"] = followed
        course = fleet_entry(summary).course
        assert course is not None
        seen.append([value for _, value in course.points] == [2.6] * 3)
    assert seen == [False, True]


def test_the_words_of_the_small_picture_have_no_powers_of_ten() -> None:
    course = fleet_entry(summary_json(drives.wearing(drives.SECANT, count=2, samples=600))).course
    assert course is not None
    title = spaced(str(sparkline(asdict(course)))).partition("<title>")[2].partition("<")[0]
    assert title == (
        "secant stiffness at 14 Nm: 31 000 to 20 800 Nm/rad over 2 tests, limit 12 000"
    )


def test_folders_whose_drives_have_one_id_are_told() -> None:
    """Both stood in the list without a word, and a fleet learnt from the newer only."""
    summary = summary_json(drives.healthy())
    listed = [fleet_drive(folder, f"drives/{folder}", summary) for folder in ("b", "a")]
    assert shared_ids(listed[:1]) == []
    (told,) = shared_ids(listed)
    assert told.startswith(f'The drives in a and b have the same id, "{summary["drive"]["id"]}"')
    content = {
        "fleet": "cell3",
        "created": "2026-03-02T05:58:00+00:00",
        "quick": False,
        "seed": 0,
        "command": "hdprog fleet cell3",
        "hdprog_version": "0.1.0",
        "warnings": [told],
        "drives": listed,
        "left_out": [],
    }
    assert told in Page(build_fleet_index(content)).text
    assert "Warnings" not in Page(build_fleet_index(content | {"warnings": []})).text
