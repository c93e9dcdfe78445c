"""Structure that a fit leaves and that nothing added accounts for: when it is said, and how."""

from __future__ import annotations

import math

from hdprog.explanation import Explanation
from hdprog.inference.noise import WHITE
from hdprog.reporting.fit_names import explanations
from hdprog.reporting.rounding import significant
from hdprog.reporting.words import agree, listed
from hdprog.results import DriveResult, TestResult

STRUCTURE = (
    "The residual is more than noise: something acts that the model lacks, and figures and "
    "forecast may be biased. The intervals are widened by the correlated noise model; look at the "
    "residual strip for its shape."
)
UNSOUGHT = (
    "The residual is more than noise, and not twice as much: slow errors of the rig or its "
    "encoder, or something that acts and that the model lacks. The intervals are widened by the "
    "correlated noise model; `hdprog explain` looks for what acts."
)
SLOW_ERRORS = (
    "Neighbouring readings share errors up to twice the noise, and no effect or curve accounts for "
    "them: they are taken for slow errors of the rig or its encoder, and the intervals are widened "
    "for them."
)
LOOK_IN_RIG = (
    "look for what else moves in the rig (play, creep, warming) before trusting its stiffness and "
    "width."
)
_CORRELATION = 0.3
_ABOVE = 1.2  # times the noise from which the verdict speaks of it
_SLOW = 2.0  # the same of what was sought in vain: slow errors of encoders are as large


def structure_remains(test: TestResult) -> bool:
    """Whether neighbouring residuals are alike: more than noise is left over.

    For independent residuals of n blocks the correlation scatters by 1/√n: five of these, and
    never less than 0.3.
    """
    needed = max(_CORRELATION, 5.0 / math.sqrt(test.fit.residual.size))
    return test.residual_correlation > needed


def unexplained(test: TestResult, explanation: Explanation | None) -> bool:
    """Whether structure remains on a test to which the search added nothing."""
    return structure_remains(test) and not (explanation is not None and explanation.effects)


def slow_errors(test: TestResult) -> bool:
    """Whether what is left may be slow errors, for which the noise model stands."""
    return test.noise_model != WHITE and test.rmse_rad <= _SLOW * test.noise_floor_rad


def structure_warnings(test: TestResult, explanation: Explanation | None) -> list[str]:
    """The warning of a test, if any; effects that were asked for are no reason to leave it out."""
    if not unexplained(test, explanation):
        return []
    if not slow_errors(test):
        return [STRUCTURE]
    return [UNSOUGHT if explanation is None else SLOW_ERRORS]


def structure_sentences(result: DriveResult) -> list[str]:
    """Say in the verdict which tests are left with structure; or nothing."""
    by_test = explanations(result)
    left = [
        test
        for test in result.tests
        if test.rmse_rad > _ABOVE * test.noise_floor_rad
        and structure_warnings(test, by_test.get(test.test_id)) not in ([], [SLOW_ERRORS])
    ]
    if not left:
        return []
    most = max(test.rmse_rad / test.noise_floor_rad for test in left)
    which = ""
    if len(result.tests) > 1:
        names = listed(test.test_id for test in left)
        which = f" of {agree(len(left), 'test', 'tests')} {names}"
    sought = "" if result.explanation is None else ", and no effect or curve accounts for it"
    acts = "something acts that the model lacks, and what is said here may be biased by it."
    if result.explanation is None and all(slow_errors(test) for test in left):
        acts = (
            "slow errors of the rig or its encoder, or something that acts and that the model "
            "lacks. Run `hdprog explain` before you rely on what is said here."
        )
    return [
        f"What the fit leaves{which} hangs together and is "
        f"{'up to ' if len(left) > 1 else ''}{significant(most, 2)} times the noise{sought}: {acts}"
    ]
