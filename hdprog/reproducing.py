"""The paper reproduced from its own numbers, written as JSON and report."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from hdprog.inference.sampling_plan import FULL, QUICK
from hdprog.outcome import WithReport
from hdprog.parallel import prepare_numerics, process_executor, spread_over
from hdprog.physics.figures import ARCMIN_PER_RAD
from hdprog.progress import Progress, untold
from hdprog.reproduction import mesh, records, sensitivity, stiffness
from hdprog.reproduction.results import BranchPair, Finding, Recovery, Reproduction
from hdprog.reproduction.table2 import INITIAL, POST_TEST, steady_loop
from hdprog.results import Provenance

_STRAIGHT = 0.05  # change of slope of a loop's middle that counts as none


@dataclass(frozen=True)
class ReproductionOutcome(WithReport):
    """What came out, ready to be written.

    Attributes
    ----------
    result : curves, numbers and findings
    """

    result: Reproduction
    file = "reproduction.json"

    @property
    def findings(self) -> tuple[Finding, ...]:
        """The paper's claims with what came out."""
        return self.result.findings

    @property
    def sentence(self) -> str:
        """The outcome in plain words, a line a claim."""
        from hdprog.reporting.reproduction_words import screen

        return screen(self.result)

    def document(self) -> dict[str, Any]:
        """Content of reproduction.json (schema hdprog.reproduce-paper/1)."""
        from hdprog.reporting.reproduction_json import reproduction_json

        return reproduction_json(self.result)

    def report(self) -> str:
        """Content of report.html."""
        from hdprog.reporting.reproduction import build_reproduction_report

        return build_reproduction_report(self.result)


def reproduce_paper(
    *,
    seed: int = 0,
    quick: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
) -> ReproductionOutcome:
    """Compute the paper's table and figures from Table 2, and compare with its claims.

    Parameters
    ----------
    seed : of the noise of the records that parameters are recovered from, and of the posteriors
    quick : fewer draws, marked as such
    workers : processes; one a core if None. The numbers do not depend on it.
    progress : called with stage, done, total
    """
    started, progress = time.perf_counter(), progress or untold
    prepare_numerics()
    seeds = np.random.SeedSequence(seed).spawn(3)
    with process_executor(workers) as executor:
        spread = spread_over(executor)
        plan = QUICK if quick else FULL
        recovering = spread(records.recovery, ("initial", "post-test"), seeds[:2], [plan] * 2)
        loops = (steady_loop(INITIAL, "initial"), steady_loop(POST_TEST, "post-test"))
        others, about_others = records.other_models(seeds[2])
        swept = sensitivity.sweeps()
        curves, local = stiffness.curves()
        recoveries = []
        for one in recovering:
            recoveries.append(one)
            progress("posteriors", len(recoveries), 2)
    result = Reproduction(
        loops=loops,
        others=others,
        sweeps=swept,
        stiffness=curves,
        local=local,
        mesh=mesh.curves(),
        recoveries=tuple(recoveries),
        findings=(
            *_loops(*loops),
            *about_others,
            *sensitivity.findings(swept),
            *stiffness.findings(),
            mesh.finding(),
            *records.recovery_findings(tuple(recoveries)),
        ),
        warnings=_warnings(recoveries),
        provenance=Provenance.of({}, seed, quick),
        seconds={"reproduction": time.perf_counter() - started},
    )
    return ReproductionOutcome(result)


def _warnings(recoveries: list[Recovery]) -> tuple[str, ...]:
    doubtful = [one.label for one in recoveries if not one.converged]
    if not doubtful:
        return ()
    return (
        f"Not converged: the posterior on the {' and the '.join(doubtful)} record. What is said "
        "of it is provisional.",
    )


def _loops(initial: BranchPair, post_test: BranchPair) -> tuple[Finding, ...]:
    """Claims about the two loops of Fig. 10."""
    widths = [sensitivity.width_at_zero(loop) for loop in (initial, post_test)]
    secants = [sensitivity.secant(loop) for loop in (initial, post_test)]
    slopes = [sensitivity.bend(parameters) for parameters in (INITIAL, POST_TEST)]
    numbers = {
        "width_initial_arcmin": widths[0],
        "width_post_test_arcmin": widths[1],
        "width_initial_rad": widths[0] / ARCMIN_PER_RAD,
        "width_post_test_rad": widths[1] / ARCMIN_PER_RAD,
        "secant_initial_Nm_per_rad": secants[0],
        "secant_post_test_Nm_per_rad": secants[1],
        "bend_initial": slopes[0],
        "bend_post_test": slopes[1],
    }
    straight = abs(slopes[0] - 1) < _STRAIGHT
    return (
        Finding(
            "Fig. 10",
            "After 100 h the hysteresis at no load is smaller.",
            f"With Table 2 its width at no load falls from {widths[0]:.3f} to {widths[1]:.3f} "
            "arcmin.",
            "agrees" if widths[1] < widths[0] else "disagrees",
            numbers,
        ),
        Finding(
            "Fig. 10",
            "The initial stiffness is linear; after 100 h it is lower and clearly nonlinear.",
            f"Slope of the stiffness curve at 100 Nm over that at no load: {slopes[0]:.2f} before, "
            f"{slopes[1]:.2f} after; the secant stiffness at 100 Nm falls from "
            f"{secants[0] / 1e3:.1f} to {secants[1] / 1e3:.1f} kNm/rad.",
            "agrees" if straight and slopes[1] > 2 and secants[1] < secants[0] else "disagrees",
            numbers,
        ),
        Finding(
            "Fig. 10",
            "The calculated curves coincide with the measured ones.",
            "The measurements are not published as numbers.",
            "cannot be checked",
            {},
        ),
    )
