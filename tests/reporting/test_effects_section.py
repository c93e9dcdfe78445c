from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from hdprog.explanation import ErrorFigures, LeftOver
from hdprog.outcome import ExplainOutcome
from hdprog.reporting.build import build_report
from hdprog.reporting.effect_words import moved_words, place_of_unknown
from hdprog.reporting.figures.unknown_course import unknown_course
from hdprog.reporting.left_out import the_drives_own
from hdprog.reporting.sections.warnings import warnings
from hdprog.reporting.style import house_style
from hdprog.reporting.verdict import verdict
from hdprog.results import DriveResult
from tests.reporting import drives, explanations
from tests.reporting.effects_view import said, section, tables
from tests.reporting.page import Page, spaced

MECHANISMS = (
    "torque offset",
    "backlash",
    "asymmetry",
    "cup hardening",
    "coulomb friction",
    "microslip",
    "stribeck",
    "creep",
    "thermal drift",
    "angle ripple",
    "tooth damage",
    "slip jump",
)
PAGES = {
    "adequate": lambda: explanations.single(explanations.adequate()),
    "explained": lambda: explanations.single(explanations.record()),
    "partly explained": lambda: explanations.single(explanations.partly()),
    "unexplained": lambda: explanations.single(explanations.unexplained()),
    "drive": explanations.of_drive,
    "adequate drive": lambda: explanations.of_drive(explanations.adequate_drive()),
}


@pytest.mark.parametrize("name", PAGES)
def test_the_page_is_well_formed_and_free_of_what_is_no_number(name: str) -> None:
    result: DriveResult = PAGES[name]()
    found = Page(build_report(result))
    assert found.faults == []
    levels = [level for level, _ in found.headings]
    assert all(after - before <= 1 for before, after in pairwise(levels))
    assert "What the drive model lacked" in [text for level, text in found.headings if level == 2]
    assert "Effects outside the drive model" in found.text
    words = found.text.lower().split()
    assert not {"nan", "inf", "-inf", "\u2212inf"} & set(words)
    assert len(found.pictures) == len(found.captions)
    for picture, caption in zip(found.pictures, found.captions, strict=True):
        assert len(str(picture["alt"])) > 30
        assert str(picture["alt"]) in caption
        assert "To do:" in caption
        assert int(str(picture["width"])) > int(str(picture["height"]))


def test_without_an_explanation_there_is_no_section() -> None:
    text = Page(build_report(drives.single_fit())).text
    assert "What the drive model lacked" not in text
    assert "Effects outside the drive model" not in text


def test_an_adequate_record_says_so_and_stays_short() -> None:
    found = section(explanations.adequate())
    assert spaced(found.lead) == (
        "The drive model explains this record down to its noise: nothing was added. "
        "Error 7.1 µrad on the data fitted and 7.3 µrad on data left out of the fit (noise floor "
        "7.0 µrad)."
    )
    assert [part.title for part in found.parts] == ["", "Considered and rejected"]
    (picture,) = found.parts[0].pictures
    assert spaced(picture.alt) == (
        "Test t01: the drive model alone leaves 7.1 µrad on the data fitted and 7.3 µrad on data "
        "left out of the fit (noise floor 7.0 µrad)."
    )
    assert picture.height < 300
    assert len(found.parts[0].tables[0].columns) == 2
    assert picture.action == "nothing."


def test_where_nothing_was_added_and_the_noise_is_not_reached_there_is_something_to_do() -> None:
    high = ErrorFigures(4e-5, 4.2e-5, 4.1e-5, 0.9)
    found = section(replace(explanations.adequate(), before=high, after=high))
    assert "The drive model does not reach the noise on this record" in found.lead
    assert "part of it is still unexplained" in found.left
    assert found.parts[0].pictures[0].action.startswith("look for what else moves in the rig")


def test_an_explained_record_names_the_effect_and_its_errors() -> None:
    found = section(explanations.record())
    assert spaced(found.lead) == (
        "The drive model alone does not explain this record; creep (the angle keeps growing under "
        "load and recovers) does. Error 26 → 7.1 µrad on the data fitted and 29 → 7.4 µrad on data "
        "left out of the fit (noise floor 7.0 µrad)."
    )
    assert [part.title for part in found.parts] == [
        "",
        "What the residual goes with",
        "What was added, and why",
        "What it did to the numbers",
        "Strained parameters",
        "Considered and rejected",
    ]
    (picture,) = found.parts[0].pictures
    assert spaced(picture.alt).startswith("Test t01: with creep the error goes 26 → 7.1 µrad on")


def test_what_is_most_wrong_is_named_first_however_well_it_was_known() -> None:
    """A width 39 % off stood behind stiffnesses that were off by one, but known to a thousandth."""
    text = said(explanations.record())
    assert (
        "Without creep 4 numbers came out wrong, most of all: μ (36 % too high), hysteresis width "
        "(19 % too high) and K_F (12 % too low)." in spaced(text)
    )


def test_words_agree_with_several_effects() -> None:
    two = explanations.record(effects=(explanations.creep(), explanations.backlash()))
    assert "backlash (a step in angle where torque changes sign) do. Error" in section(two).lead
    partly = (explanations.creep(), explanations.backlash(), explanations.unknown())
    text = said(explanations.record("partly_explained", partly, "creep+bump"))
    assert "changes sign) do in part, and something that no known mechanism describes" in text
    assert "Without creep, backlash and the unknown effect 4 numbers came out wrong" in text
    page = Page(build_report(explanations.single(two))).text
    assert "Effects outside the drive model were found: creep" in page
    assert "when the effects are added" in page
    assert "the effects together" in page
    assert "What the missing effects did to the numbers" in page


def test_gains_below_zero_have_true_minus_signs() -> None:
    why = "no evidence: log Bayes factor -0.7 where 5 is asked for"
    worse = replace(explanations.CONSIDERED[0], log_evidence_gain=-0.7, why_not=why)
    page = Page(build_report(explanations.single(explanations.record(considered=(worse,)))))
    assert "log Bayes factor \u22120.7 where" in page.text
    shown = page.text.partition("Provenance")[0]
    assert re.findall(r"(?<![\w.)-])-\d", shown) == []


def test_what_no_mechanism_describes_is_placed_and_drawn() -> None:
    record = explanations.unexplained()
    found = section(record)
    assert spaced(found.lead) == (
        "In this record there is something that no known mechanism describes: it acts over torque "
        "between 19 and 25 Nm on both branches. Its shape is drawn below. Error 11 → 7.1 µrad on "
        "the data fitted and 13 → 7.4 µrad on data left out of the fit (noise floor 7.0 µrad)."
    )
    shape = next(part for part in found.parts if part.title == "The unknown part")
    assert "lies over torque between 19 and 25 Nm" in spaced(shape.pictures[0].alt)
    assert "It stands for no mechanism" in said(record)


def test_the_unknown_never_gets_the_name_of_a_mechanism() -> None:
    found = section(explanations.unexplained(considered=()))
    shown = [found.lead, *(part.title for part in found.parts)]
    shown += [text for part in found.parts for text in part.paragraphs]
    shown += [str(picture) for part in found.parts for picture in part.pictures]
    shown += [str(table) for part in found.parts for table in part.tables]
    shown += verdict(explanations.single(explanations.unexplained())).sentences
    text = " ".join(part.partition("data:image")[0] for part in shown).lower()
    assert "unknown" in text
    assert not [name for name in MECHANISMS if name in text]


def test_a_record_explained_in_part_says_both() -> None:
    text = said(explanations.partly())
    assert "creep (the angle keeps growing under load and recovers) does in part" in text
    assert "something that no known mechanism describes remains over torque" in text


@pytest.mark.parametrize(
    ("branch", "words"),
    [("rising", " while torque rises"), ("falling", " while torque falls"), (None, " on both")],
)
def test_the_branch_of_the_unknown_is_said(branch: str | None, words: str) -> None:
    record = explanations.unexplained()
    assert record.course.unknown is not None
    kept = np.ones(explanations.BLOCKS) if branch is None else record.course.rising
    kept = 1 - kept if branch == "falling" else kept
    course = replace(record.course, unknown=record.course.unknown * kept)
    assert words in spaced(place_of_unknown(replace(record, course=course)))


def test_of_a_wide_unknown_it_is_said_where_most_of_it_is() -> None:
    record = explanations.unexplained()
    torque = record.course.torque
    top = float(np.abs(torque).max())

    def said(unknown: np.ndarray) -> str:
        course = replace(record.course, unknown=1e-5 * unknown)
        return spaced(place_of_unknown(replace(record, course=course)))

    whole = "over the whole range of torque"
    ends = said(np.maximum(np.abs(torque) / top - 0.5, 0.0))
    assert ends.startswith(f"{whole}, most of it beyond ")
    assert ends.endswith(" Nm in both directions")
    rippled = np.where(torque > 0.0, np.sin(4 * np.pi * torque / top), 0.0)
    lone = said(rippled + np.where(torque < -0.9 * top, 0.6, 0.0))
    assert lone == f"{whole}, most of it at positive torque"


def test_an_unknown_all_along_is_not_given_ends() -> None:
    record = explanations.unexplained()
    wavy = 1e-5 * np.sin(0.3 * record.course.torque)
    course = replace(record.course, unknown=wavy)
    assert place_of_unknown(replace(record, course=course)) == "over the whole range of torque"


def test_an_unknown_of_one_direction_is_drawn_for_each() -> None:
    record = explanations.unexplained()
    assert record.course.unknown is not None
    course = replace(record.course, unknown=record.course.unknown * record.course.rising)
    found = replace(record, effects=(explanations.unknown("branch"),), course=course)
    assert "over torque between 19 and 25 Nm while torque rises" in spaced(place_of_unknown(found))
    both = replace(found, effects=(explanations.unknown("torque"),))
    with house_style():
        split, joint = unknown_course(found), unknown_course(both)
    assert split is not None
    assert joint is not None
    assert split.uri != joint.uri


def test_there_is_no_curve_of_the_unknown_without_it() -> None:
    with house_style():
        assert unknown_course(explanations.record()) is None


def test_a_drive_tells_origin_hours_left_and_each_test() -> None:
    drive = explanations.drive_explanation()
    found = section(drive)
    assert spaced(found.lead) == (
        "The drive model alone does not explain 3 of 7 tests; backlash (a step in angle where "
        "torque changes sign) does. Error over all tests 9.5 → 7.1 µrad on the data fitted and "
        "10 → 7.4 µrad on data left out of the fit (noise floor 7.0 µrad)."
    )
    text = said(drive)
    assert "It grows with service hours" in text
    assert (
        "Without what was added, remaining life (90 %) is between 1 200 and 1 900 h; with it, at "
        "least 1 400 h and possibly beyond the horizon."
    ) in text
    assert tables(drive)["Hours from the last"]["with backlash"] == ("1 400 h", "1 900 h", "later")
    each = tables(drive)["Each test by itself."]
    assert each["t01"][1] == "nothing added"
    assert each["t07"] == (
        "900 h",
        "explained",
        "14 (left out: 15)",
        "7.1 (left out: 7.4)",
        "7.0",
        "backlash",
    )
    titles = [part.title for part in found.parts]
    assert [t for t in titles if t.startswith("Residual")] == [
        f"Residual of test t0{n}: backlash" for n in range(5, 8)
    ]
    size = next(part for part in found.parts if part.title == "Backlash").pictures[0]
    assert spaced(size.alt) == (
        "Backlash is found in 5 of 7 tests: it moves the angle by 1.3 µrad at 300 h and by 28 "
        "µrad at 900 h."
    )
    assert size.action.startswith("count it with the wear")


def test_a_test_that_cannot_show_an_effect_is_not_said_to_lack_it() -> None:
    """The last test, and the one in the middle that lies before the first with it."""
    drive = explanations.drive_explanation()
    sizes = drive.amplitudes["backlash"].copy()
    sizes[[1, 6], 1:] = np.nan
    last = explanations.adequate(test_id="t07", hours=900.0)
    drive = replace(drive, amplitudes={"backlash": sizes}, tests=(*drive.tests[:6], last))
    added = {test: cells[-1] for test, cells in tables(drive)["Each test by itself."].items()}
    assert added["t01"] == "none"
    assert added["t02"] == added["t07"] == "none (cannot show backlash)"
    part = next(part for part in section(drive).parts if part.title == "Backlash")
    assert "found in 4 of 7 tests (2 cannot show it)" in spaced(part.pictures[0].alt)
    data = part.pictures[0].data
    assert data is not None
    assert data.text.splitlines()[-1] == "900,,,"
    told = "Tests t02 and t07 cannot show backlash: how far it is in their figures cannot be told"
    assert told in warnings(explanations.of_drive(drive))[0]


def test_what_some_tests_lack_is_said_to_be_left_out_of_the_search() -> None:
    """Without a word nothing over time was found in a drive of which one test is untimed."""
    drive = explanations.drive_explanation()
    assert "was not looked for over" not in said(drive)
    *others, last = drive.tests
    timeless = {name: at for name, at in last.course.coordinates.items() if name != "time"}
    last = replace(last, course=replace(last.course, coordinates=timeless))
    told = said(replace(drive, tests=(*others, last)))
    assert "no mechanism describes was not looked for over time: not all tests tell of that" in told


def test_an_effect_of_the_rig_is_not_counted_as_wear() -> None:
    drive = explanations.drive_explanation(effects=(explanations.backlash(origin="rig"),))
    assert "says nothing of the drive's wear" in said(drive)
    unclear = explanations.drive_explanation(effects=(explanations.backlash(origin="unclear"),))
    assert "cannot be told from these tests" in said(unclear)


def test_tests_at_their_noise_are_not_counted_as_unexplained() -> None:
    drive = explanations.drive_explanation()
    shown = replace(drive, tests=drive.tests[-1:] * 5)
    floor = drive.tests[-1].noise_floor_rad
    at_noise = replace(drive.tests[-1], before=ErrorFigures(floor, floor, floor, 0.0))
    beside = section(replace(drive, tests=(at_noise, *shown.tests))).lead
    assert beside.startswith("The drive model alone does not explain 5 of 6 tests; backlash")
    # What all have in common may be clear from all of them only.
    together = section(replace(drive, tests=(at_noise,) * 6)).lead
    assert together.startswith(
        "The drive model alone does not explain these 6 tests taken together; backlash"
    )


def test_a_drive_without_a_forecast_tells_no_hours_left() -> None:
    drive = explanations.drive_explanation(remaining_hours_before=None, remaining_hours_after=None)
    assert "emaining life" not in said(drive)
    assert "emaining life" not in verdict(explanations.of_drive(drive)).text


def test_an_adequate_drive_says_so() -> None:
    assert spaced(section(explanations.adequate_drive()).lead) == (
        "The drive model explains all 3 tests down to their noise: nothing was added. Error over "
        "all tests 7.1 µrad on the data fitted and 7.3 µrad on data left out of the fit (noise "
        "floor 7.0 µrad)."
    )


@pytest.mark.parametrize(
    "result",
    [
        explanations.single(explanations.adequate()),
        explanations.of_drive(explanations.adequate_drive()),
    ],
    ids=["record", "drive"],
)
def test_that_nothing_was_added_is_told_on_the_screen_where_it_was_asked(
    result: DriveResult,
) -> None:
    told = ExplainOutcome(result, (), single=result.trend is None).sentence
    assert told.startswith(verdict(result).text)
    assert "nothing was added. Error" in told
    assert told.count("7.1\u202fµrad") == 1


def test_what_was_added_is_told_once() -> None:
    result = explanations.single(explanations.record())
    assert ExplainOutcome(result, (), single=True).sentence == verdict(result).text


def test_the_verdict_tells_what_was_added_and_what_it_moves() -> None:
    sentences = [spaced(text) for text in verdict(explanations.of_drive()).sentences]
    assert sentences[-2:] == [
        "The residual of the drive model follows torque; with backlash the error goes "
        "9.5 → 7.1 µrad on the data fitted and 10 → 7.4 µrad on data left out of the fit (noise "
        "floor 7.0 µrad).",
        "Without what was added, remaining life (90 %) is between 1 200 and 1 900 h; with it, at "
        "least 1 400 h and possibly beyond the horizon.",
    ]
    unknown = spaced(verdict(explanations.single(explanations.unexplained())).sentences[-1])
    assert unknown == (
        "Something acts over torque between 19 and 25 Nm on both branches that is none of the "
        "known effects: what is said here may be biased by it."
    )
    adequate = verdict(explanations.single(explanations.adequate()))
    assert adequate == verdict(drives.single_fit(drives.LOST_MOTION))


def test_what_was_found_is_the_first_warning() -> None:
    explained = explanations.single(explanations.record())
    assert warnings(explained)[0] == (
        "An effect outside the drive model was found: creep (the angle keeps growing under load "
        "and recovers)."
    )
    unknown = spaced(warnings(explanations.single(explanations.unexplained()))[0])
    assert unknown.startswith("Structure remains over torque between 19 and 25 Nm on both branches")
    assert warnings(explanations.single(explanations.adequate())) == []


def test_structure_that_is_explained_is_not_warned_of_twice() -> None:
    result = explanations.of_drive()
    alike = tuple(replace(test, residual_correlation=0.8) for test in result.tests)
    found = [text for text in warnings(replace(result, tests=alike)) if "more than noise" in text]
    # Only the tests in which nothing was found are left to warn of.
    assert len(found) == 1
    assert found[0].startswith("Tests t01 and t02: ")


def test_warnings_of_the_search_are_told() -> None:
    result = explanations.single(explanations.record(warnings=("Too short to tell.",)))
    assert "Too short to tell." in warnings(result)


def test_a_fit_that_did_not_converge_is_marked() -> None:
    record = explanations.record(converged=False)
    found = section(record)
    assert found.doubtful
    assert "its numbers are provisional" in said(record)
    assert all(
        table.doubtful
        for part in found.parts
        for table in part.tables
        if table.caption.startswith(("Error of", "Size of", "What the missing"))
    )
    page = Page(build_report(explanations.single(record)))
    assert "What the drive model lacked not converged" in page.text


def test_each_pictured_test_adds_less_than_a_tenth_of_a_megabyte() -> None:
    result = explanations.of_drive()
    pictured = sum(bool(test.effects) for test in explanations.drive_explanation().tests)
    without = len(build_report(replace(result, explanation=None)).encode())
    added = len(build_report(result).encode()) - without
    # The rest of the section is worth one test more.
    assert added < 100_000 * (pictured + 1)


def test_hours_left_are_not_said_to_move_where_they_do_not() -> None:
    left = {0.05: 120.0, 0.5: 400.0, 0.95: 900.0}
    told = moved_words(left, left)
    assert told is not None
    assert spaced(told) == (
        "Remaining life (90 %) is between 120 and 900 h, with what was added and without it."
    )
    none_left = dict.fromkeys((0.05, 0.5, 0.95), 0.0)
    assert moved_words(none_left, none_left) is None


@pytest.mark.parametrize(
    ("hours", "words"),
    [
        ((0.0, 0.0, 0.0), "used up"),
        ((0.0, 0.0, 640.0), "at most 650 h"),
        ((0.0, 640.0, None), "anything from none to beyond the horizon"),
        ((210.0, 400.0, 900.0), "between 200 and 900 h"),
        ((210.0, 400.0, None), "at least 200 h and possibly beyond the horizon"),
        ((210.0, None, None), "at least 200 h and probably beyond the horizon"),
        ((None, None, None), "beyond the horizon"),
    ],
)
def test_hours_left_without_and_with_an_effect_are_told_apart(
    hours: tuple[float | None, float | None, float | None], words: str
) -> None:
    levels = dict(zip((0.05, 0.5, 0.95), hours, strict=True))
    other = {0.05: 3000.0, 0.5: 4000.0, 0.95: 5000.0}
    told = moved_words(levels, other)
    assert told is not None
    assert spaced(told) == (
        f"Without what was added, remaining life (90 %) is {words}; with it, between 3 000 and "
        "5 000 h."
    )


@pytest.mark.parametrize(
    ("remains", "what"),
    [
        (LeftOver("backlash", None, 44.6), "backlash would carry it best (log Bayes factor 45)"),
        (
            LeftOver("unknown", "torque", 17.2),
            "a curve over torque would follow it (log Bayes factor 17)",
        ),
    ],
)
def test_what_was_refused_for_its_share_is_told(remains: LeftOver, what: str) -> None:
    """Though the error is down to the noise, nothing may say that nothing more can be explained."""
    record = explanations.record(left_over=remains)
    lead = spaced(section(record).lead)
    assert "do in part" in lead or "does in part" in lead
    assert what in lead
    assert "do not take it for absent" in lead
    result = explanations.single(record)
    assert what in " ".join(spaced(sentence) for sentence in verdict(result).sentences)
    page = spaced(Page(build_report(result)).text)
    assert "nothing more" not in page
    assert page.count("More remains than chance leaves") == 2  # the verdict and the section
    assert page.count("do not take it for absent") == 1
    whole = explanations.drive_explanation()
    tests = (*whole.tests[:-1], replace(whole.tests[-1], left_over=remains))
    drive = replace(whole, tests=tests)
    assert what in spaced(section(drive).lead)


def test_a_small_shift_of_a_number_that_is_well_known_is_told_as_what_it_is() -> None:
    stiffness = "secant_stiffness_Nm_per_rad@14Nm"
    record = explanations.record(
        figures_before={stiffness: explanations.around(14_100.0, 0.0002)},
        figures_after={stiffness: explanations.around(14_130.0, 0.0002)},
        parameters_before={},
        parameters_after={},
    )
    assert tables(record)["What the missing effect"]["Secant stiffness at 14 Nm [Nm/rad]"][-2:] == (
        "0.21 % too low",
        "+10.6",
    )
    text = said(record)
    assert (
        "Secant stiffness at 14 Nm moved by more than two standard deviations, but by less than "
        "half a per cent." in text
    )
    assert "No figure and no parameter" not in text


def test_width_without_what_the_drive_itself_has_is_not_left_to_be_misread() -> None:
    """A table set the width "with" friction that grows with wear at a third of the drive's."""
    grown = explanations.drive_explanation()
    words = (
        "Width, loss and lost motion in the table are the drive model's part alone. What backlash "
        "adds to the loop is the drive's own: with it, they stand under Tests"
    )
    assert words in said(grown)
    of_rig = replace(grown, effects=(explanations.backlash(origin="rig"),))
    assert the_drives_own(of_rig, of_rig.tests[-1]) == ""


def test_what_it_did_to_the_numbers_is_told_of_the_last_test_that_shows_it() -> None:
    """It was that of the last pictured one, of the three whose error fell most."""
    drive = explanations.drive_explanation()
    last = drive.tests[-1]
    little = replace(last, after=replace(last.after, rmse_rad=0.99 * last.before.rmse_rad))
    found = replace(drive, tests=(*drive.tests[:-1], little))
    titles = [part.title for part in section(found).parts]
    assert f"Residual of test {last.test_id}: backlash" not in titles
    assert f"in test {last.test_id}" in " ".join(
        spaced(table.caption)
        for part in section(found).parts
        if part.title == "What it did to the numbers"
        for table in part.tables
    )
