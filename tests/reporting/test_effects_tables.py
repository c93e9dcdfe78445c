"""Tables of the section of effects: every number where it belongs."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hdprog.reporting.bias import Shift, shifts
from hdprog.reporting.build import build_report
from hdprog.reporting.sections.effects_tables import off_words
from hdprog.reporting.summary import summary_json
from hdprog.results import EffectSummary
from tests.reporting import drives, explanations
from tests.reporting.effects_view import said, tables
from tests.reporting.page import Page, spaced


def test_errors_stand_side_by_side() -> None:
    table = tables(explanations.record())["Error of the fit."]
    assert table["on the data fitted"] == ("26", "7.1")
    assert table["on data left out of the fit"] == ("29", "7.4")
    assert table["just after reversals"][1] == "7.3"
    assert table["falling branch"][1] == "7.2"
    assert table["noise floor"] == ("7.0", "7.0")
    assert table["repeatability of the record's own cycles"] == ("9.0", "9.0")
    assert table["likeness of neighbours (0 none, 1 full)"] == ("0.91", "0.02")


def test_what_is_not_known_is_a_dash_or_left_out() -> None:
    record = explanations.record(repeatability_rad=None)
    bare = replace(record, after=replace(record.after, reversal_rmse_rad=None))
    table = tables(bare)["Error of the fit."]
    assert table["just after reversals"][1] == "–"
    assert "repeatability of the record's own cycles" not in table


def test_coordinates_are_ordered_by_what_they_carry() -> None:
    table = tables(explanations.record())["What the residual of"]
    assert list(table.items()) == [
        ("Time", ("83 %", "below 0.001")),
        ("The order of the readings", ("79 %", "below 0.001")),
        ("Torque", ("11 %", "0.31")),
    ]


def test_evidence_alternatives_and_advice_are_said() -> None:
    text = said(explanations.record())
    assert "carries 94 % of the error that can be explained" in text
    assert "log evidence rises by 412" in text
    assert "on left-out blocks rises by 388 ± 27 (one standard error)" in text
    assert (
        "On these data viscous friction or microslip would leave hardly more error and cannot be "
        "ruled out; the drive's numbers are told as they are beside creep." in text
    )
    assert "To tell them apart: repeat the record at a second loading rate" in text
    assert "To do: hold the load for two minutes before each reading." in text


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [(-1.66, -0.5, "1.2 too low"), (1.0, -0.5, "1.5 too high"), (-0.6, -0.5, "20 % too low")],
)
def test_what_may_be_negative_is_off_by_so_much(before: float, after: float, words: str) -> None:
    level = explanations.around
    shift = Shift("c", False, before=level(before), after=level(after), deviations=5.0)
    assert spaced(off_words(shift)) == words


def test_parameters_of_an_effect_have_units_and_small_angles_are_in_microradian() -> None:
    table = tables(explanations.record())["Size of what was"]
    assert table["compliance"] == ("2.00", "2.10", "2.20", "µrad/Nm")
    assert table["time constant"] == ("33", "41", "49", "s")
    phase = explanations.creep(
        parameters={"phase": explanations.around(1.2)}, units={"phase": "rad"}
    )
    table = tables(explanations.record(effects=(phase,)))["Size of what was"]
    assert table["phase"] == ("1.14", "1.20", "1.26", "rad")


def test_the_bias_is_told_largest_first() -> None:
    record = explanations.record()
    sizes = [abs(shift.deviations or 0.0) for shift in shifts(record)]
    assert sizes == sorted(sizes, reverse=True)
    table = tables(record)["What the missing effect"]
    assert table["K_F"][2:] == ("12 % too low", "+4.4")
    assert table["μ"][2:] == ("36 % too high", "−8.9")
    assert "creep.compliance" not in table


def test_the_shift_is_in_standard_deviations_of_the_claim_before() -> None:
    record = explanations.record()
    shift = next(shift for shift in shifts(record) if shift.key == "K_F")
    assert shift.deviations == pytest.approx((78_200 - 69_000) / (0.03 * 69_000), rel=1e-3)
    flat = dict.fromkeys((0.05, 0.25, 0.5, 0.75, 0.95), 1.0)
    stuck = replace(record, parameters_before={"a": flat}, parameters_after={"a": flat})
    assert next(s for s in shifts(stuck) if s.key == "a").deviations is None
    assert tables(stuck)["What the missing effect"]["a"][3] == "–"


def test_a_record_without_bias_says_so() -> None:
    record = explanations.record()
    same = replace(
        record,
        parameters_before=record.parameters_after,
        figures_before=record.figures_after,
    )
    assert "No figure and no parameter moved by more than two standard deviations" in said(same)


def test_strained_parameters_are_told() -> None:
    assert "in prior standard deviations: μ by 3.4." in said(explanations.record())
    assert "prior standard deviations" not in said(explanations.record(strained={}))


def test_what_was_rejected_has_its_reason() -> None:
    table = tables(explanations.record())["Looked at and not"]
    assert table["Viscous friction"] == ("3", "1.1 ± 2.4", "gains too little")
    assert table["Kinematic error"] == ("–", "–", "needs output angle")


def test_a_fit_tells_the_size_of_the_effects_that_it_was_asked_for() -> None:
    """Only the draws of posterior.nc had it."""
    levels = {0.05: 2.0e-4, 0.25: 2.1e-4, 0.5: 2.14e-4, 0.75: 2.2e-4, 0.95: 2.3e-4}
    creep = EffectSummary("creep", {"amplitude": levels}, {"amplitude": "rad"})
    plain = drives.single_fit()
    test = replace(plain.tests[0], effects=("creep",), effect_summaries=(creep,))
    fit = replace(plain, tests=(test,))
    told_so = "Size of what was added to the drive model."
    told = Page(build_report(fit)).text.partition(told_so)[2]
    assert told.split("Creep ")[1].startswith("amplitude 200 214 230 µrad")
    assert told_so not in Page(build_report(plain)).text
    found = summary_json(fit)["tests"][0]["effect_parameters"]["creep"]["amplitude"]
    assert (found["unit"], found["q50"]) == ("rad", pytest.approx(2.14e-4))
    assert summary_json(plain)["tests"][0]["effect_parameters"] == {}
