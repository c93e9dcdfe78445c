"""Which of a test's two fits a remark is about: the drive model alone, or with the effects."""

from __future__ import annotations

from hdprog.explanation import DriveExplanation, Explanation
from hdprog.reporting.effect_words import effect_name
from hdprog.reporting.words import listed
from hdprog.results import DriveResult, TestResult

_UNNAMED, _LEFT = "This fit ", "What the fit leaves "
_ALONE = "the fit of the drive model alone"


def explanations(result: DriveResult) -> dict[str, Explanation]:
    """Explanation of each test by its name; empty where effects were not looked for."""
    found = result.explanation
    if isinstance(found, DriveExplanation):
        return {test.test_id: test for test in found.tests}
    return {} if found is None else {test.test_id: found for test in result.tests}


def final_fit(explanation: Explanation | None) -> str:
    """Name of the fit that the results come from."""
    if explanation is None:
        return "the fit"
    if not explanation.effects:
        return _ALONE
    return f"the fit with {listed(effect_name(effect.id) for effect in explanation.effects)}"


def named_warnings(test: TestResult, explanation: Explanation | None) -> list[str]:
    """Warnings of a test, each once; what is said of a fit names it.

    The warnings of an explanation are those of both fits, the test's own are those of the final
    one.
    """
    if explanation is None:
        return list(dict.fromkeys(test.warnings))
    found = [_named(text, final_fit(explanation)) for text in test.warnings]
    found += [_named(text, _ALONE) for text in explanation.warnings if text not in test.warnings]
    return list(dict.fromkeys(found))


def _named(text: str, fit: str) -> str:
    if text.startswith(_LEFT):
        return f"What {fit} leaves {text.removeprefix(_LEFT)}"
    if text.startswith(_UNNAMED):
        return f"{fit[0].upper()}{fit[1:]} {text.removeprefix(_UNNAMED)}"
    return text


def doubtful_without_effects(result: DriveResult) -> list[str]:
    """Tests whose final fit converged and whose drive model alone did not."""
    by_test = explanations(result)
    return [
        test.test_id
        for test in result.tests
        if test.converged and test.test_id in by_test and not by_test[test.test_id].converged
    ]
