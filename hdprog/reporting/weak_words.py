"""What a test cannot tell, in words: what is known together, priors, the tooth angle, a side.

The sentences hold no numbers, so that tests of which the same is to be said are named in one.
"""

from __future__ import annotations

from collections.abc import Mapping

from hdprog.data.quality import sides_of
from hdprog.reporting.words import agree, capital, listed, parameter_name, quantity
from hdprog.results import Identification, TestResult

_NARROW = 0.05
"""Half of a 90 % interval, in parts of the median, below which a prior's share does no harm."""
OF_PARAMETERS = "Of the parameters,"
"""Begins what touches no figure that a limit may be set on, the preload aside."""
_SURE = 0.95
_UNINFORMED = 0.1
_FIRST_ORDER = ("K_W", "mu", "c", "preload_Nm")
LEAST_CHANGE, _OF_INTERVAL = 0.02, 0.25


def weak_words(test: TestResult) -> list[str]:
    """Sentences on what a test leaves open, those that touch a limit first."""
    found = _limited_by_prior(test) + _limited_by_angle(test) + _mirrored(test)
    found += _disagreements(test)
    state = test.identification
    covered: set[str] = set()
    if state is not None and state.one_spring:
        covered |= {"K_F", "a", "b", "T_T"}
        found.append(
            f"{OF_PARAMETERS} K_F, a, b and T_T lean on the prior: cup and teeth act as one "
            "spring, as on a new drive, and their combined stiffness K is known (see Parameters)."
        )
    if state is not None and not_reached(state):
        found.append(
            f"{OF_PARAMETERS} c, T_i and μ lean on each other and on the prior, and so does the "
            "preload: the load stayed below the preload torque T_i (see Parameters)."
        )
    silent = [
        name
        for name, told in test.parameters.items()
        if not told.contraction >= _UNINFORMED
        and name not in covered
        and not _disagrees(test, name)
    ]
    if silent:
        names = listed(map(parameter_name, silent))
        theirs = agree(len(silent), "its interval is", "their intervals are")
        found.append(f"{OF_PARAMETERS} the record says nothing of {names}; {theirs} the prior's.")
    return found


def not_reached(state: Identification) -> bool:
    """Whether the record stays below the preload torque, as far as can be told."""
    return state.beyond_record >= _SURE


def prior_driven(test: TestResult, key: str) -> bool:
    """Whether a figure leans on the prior, and is wide enough for that to matter."""
    found, levels = test.sensitivity.get(key), test.figures.get(key)
    if found is None or levels is None or found.diagnosis not in ("prior", "shared"):
        return False
    return _half_width(levels) > _NARROW * abs(levels[0.50])


def left_to_prior(test: TestResult, key: str) -> bool:
    """Whether a record does not fix a figure: where it is prior-driven, or preload out of reach."""
    state = test.identification
    out_of_reach = key == "preload_Nm" and state is not None and not_reached(state)
    return out_of_reach or prior_driven(test, key)


def moved_by_angle(test: TestResult) -> list[str]:
    """Parameters and figures that the other tooth angle moves by more than their interval hides."""
    other = test.other_tooth_angle
    if other is None:
        return []
    values = {name: found.quantiles for name, found in test.parameters.items()} | dict(test.figures)
    moved = dict(other.parameters) | dict(other.figures)
    return [
        name
        for name, levels in values.items()
        if name in moved and (name in _FIRST_ORDER or _tells(levels, moved[name][0.50]))
    ]


def _tells(levels: Mapping[float, float], other: float) -> bool:
    change = abs(other - levels[0.50])
    return change > max(LEAST_CHANGE * abs(levels[0.50]), _OF_INTERVAL * _half_width(levels))


def _half_width(levels: Mapping[float, float]) -> float:
    return 0.5 * (levels[0.95] - levels[0.05])


def _limited_by_prior(test: TestResult) -> list[str]:
    found = []
    for key in dict.fromkeys(limit.key for limit in test.drive.limits):
        if not prior_driven(test, key):
            continue
        said = (
            f"{capital(quantity(key).name)} has a limit and leans on the prior: the record tells "
            "it only in part. Make sure by an inspection before you replace anything."
        )
        state = test.identification
        if key == "preload_Nm" and state is not None and not_reached(state):
            said += " A test loaded beyond the preload torque T_i would tell it."
        found.append(said)
    return found


def _limited_by_angle(test: TestResult) -> list[str]:
    other = test.other_tooth_angle
    if other is None:
        return []
    return [
        f"{capital(quantity(key).name)} has a limit and depends on the gear-tooth angle, which is "
        "not declared. Set alpha_deg in drive.toml; Parameters shows what another angle gives."
        for key in dict.fromkeys(limit.key for limit in test.drive.limits)
        if key in other.figures and _tells(test.figures[key], other.figures[key][0.50])
    ]


def _mirrored(test: TestResult) -> list[str]:
    # By the blocks that were fitted: a spike to the other side is no load.
    if sides_of(test.fit.torque) == "two-sided":
        return []
    return [
        "The drive was loaded to one side only. Width, loss and lost motion are those of a whole "
        "cycle to both sides: the other side is taken to mirror this one, which the record does "
        "not show, and drift or creep in a single cycle passes for hysteresis. Load to both sides "
        "to measure it."
    ]


def _disagrees(test: TestResult, name: str) -> bool:
    found = test.sensitivity.get(name)
    return found is not None and found.diagnosis in ("conflict", "overruled")


def _disagreements(test: TestResult) -> list[str]:
    named: dict[str, list[str]] = {"conflict": [], "overruled": []}
    for name in test.parameters:
        found = test.sensitivity.get(name)
        if found is not None and found.diagnosis in named:
            named[found.diagnosis].append(parameter_name(name))
    check = "Check that the drive's model, its prior and the record's units are right."
    said = []
    if named["conflict"]:
        said.append(
            f"The prior and the record disagree about {listed(named['conflict'])}; what is given "
            f"is a compromise of the two. {check}"
        )
    if named["overruled"]:
        said.append(
            f"The record puts {listed(named['overruled'])} far from where the prior expected "
            f"{agree(len(named['overruled']), 'it', 'them')}; the record decides. {check}"
        )
    return said
