"""Figures that fits miss: said of the last test or of several, in warnings of all, and in JSON."""

from __future__ import annotations

from dataclasses import replace

from hdprog.reporting.read_off_words import missed_sentences, missed_words
from hdprog.reporting.reader_units import shown_in
from hdprog.reporting.sections import tests, warnings
from hdprog.reporting.summary import summary_json
from hdprog.reporting.verdict import verdict
from hdprog.results import DriveResult
from tests.reporting import drives
from tests.reporting.page import Page
from tests.reporting.situations import report_of

LOST_MOTION = "lost_motion_arcmin"


def wearing(missed: str = LOST_MOTION) -> DriveResult:
    """Three tests of a drive with a limit on its lost motion, the last one missed."""
    result = drives.wearing(drives.LOST_MOTION, count=3)
    *before, last = result.tests
    read = (*map(drives.read_off, before), drives.read_off(last, missed))
    return replace(result, tests=read)


def test_it_stands_first_in_the_verdict_where_it_has_a_limit() -> None:
    said = verdict(wearing()).sentences[0]
    assert said.startswith("Test t03: Lost motion read off the record itself is ")
    assert said.endswith("or a forecast of lost motion, before that is explained.")
    assert missed_sentences(wearing("hysteresis_width_arcmin")) == []
    assert missed_sentences(wearing("")) == []


def test_earlier_tests_are_told_of_where_several_are_missed() -> None:
    result = drives.wearing(drives.LOST_MOTION, count=4)

    def missing(*places: int) -> list[str]:
        read = [
            drives.read_off(test, LOST_MOTION if place in places else "")
            for place, test in enumerate(result.tests)
        ]
        return missed_sentences(replace(result, tests=tuple(read)))

    assert missing(1) == []
    (said,) = missing(0, 2)
    assert said.startswith("The fits of 2 of 4 tests (t01 and t03) miss the lost motion that their")
    (of_last,) = missing(0, 2, 3)
    assert of_last.startswith("Test t04: ")
    one_sided = replace(result.tests[-1], read_off={})
    both = [drives.read_off(test, LOST_MOTION) for test in result.tests[:2]]
    (said,) = missed_sentences(replace(result, tests=(*both, one_sided)))
    assert said.startswith("The fits of 2 of 3 tests (t01 and t02) miss the lost motion that their")


def test_every_test_that_is_missed_is_warned_of() -> None:
    result = wearing("hysteresis_width_arcmin")
    (said,) = missed_words(result.tests[-1])
    assert f"Test t03: {said}" in warnings.warnings(result)
    assert said.startswith("Hysteresis width read off the record itself")
    assert not missed_words(result.tests[0])


def test_every_test_has_its_own_interval() -> None:
    """Told of all tests at once, the ranges of ends ran into each other: "(0.28 to 0.64 to …"."""
    result = wearing()
    read = [drives.read_off(test, LOST_MOTION) for test in drives.wearing(count=3).tests]
    said = [text for text in warnings.warnings(replace(result, tests=tuple(read))) if "off" in text]
    assert [text[:9] for text in said] == ["Test t01:", "Test t02:", "Test t03:"]
    assert all(text.count(" to ") == 1 for text in said)


def test_all_is_said_where_no_figure_has_a_limit() -> None:
    result = wearing("hysteresis_loss_J")
    bare = replace(result, drive=replace(result.drive, limits=()))
    assert len(missed_sentences(bare)) == 1


def test_an_empirical_curve_is_named_as_left_out() -> None:
    test = replace(wearing().tests[-1], effects=("unknown",))
    assert "the fit, its empirical curve left out, has" in missed_words(test)[0]


def test_numbers_and_json() -> None:
    result = wearing()
    table = tests.read_off(result)
    assert table is not None
    assert [row.head.partition(",")[0] for row in table.groups[0].rows] == ["t01", "t02", "t03"]
    assert table.columns[1] == "lost motion [arcmin]"  # what has a limit comes first
    assert "fit misses it: " in table.groups[0].rows[2].cells[0].spread  # type: ignore[union-attr]
    last = summary_json(result)["tests"][-1]
    found = result.tests[-1].read_off[LOST_MOTION]
    assert last["read_off"][LOST_MOTION]["record"] == found.record
    assert last["read_off"][LOST_MOTION]["fit"]["q50"] == found.fit[0.50]
    assert last["read_off"][LOST_MOTION]["differs"] is True
    assert any("read off the record itself" in text for text in last["warnings"])
    one_sided = replace(result, tests=(replace(result.tests[0], read_off={}),))
    assert tests.read_off(one_sided) is None


def test_it_is_told_in_the_readers_unit() -> None:
    result = wearing()
    seconds = replace(result.drive.report, angle_unit="arcsec")
    with shown_in(seconds):
        (said,) = missed_sentences(result)
    found = result.tests[-1].read_off[LOST_MOTION]
    assert "arcsec" in said
    assert f"is {60 * found.record:.1f} ± " in said
    last = summary_json(replace(result, drive=replace(result.drive, report=seconds)))["tests"][-1]
    (warned,) = (text for text in last["warnings"] if "read off the record itself" in text)
    assert "arcsec" in warned
    assert last["read_off"] == summary_json(result)["tests"][-1]["read_off"]


def test_the_report_shows_it() -> None:
    page = Page(report_of("unexplained"))
    assert page.faults == []
    assert "fit misses it: " in page.text
