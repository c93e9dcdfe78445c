"""Every model on one loop: fitted side by side, ranked, written as JSON and report."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from hdprog.arguments import checked_record, randomness
from hdprog.comparison.curves import SteadyCycle
from hdprog.comparison.fitted import fit_model
from hdprog.comparison.ranking import ranked
from hdprog.comparison.results import DRIVE, ComparedModel, Comparison, LeftOut
from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.prepare import prepare
from hdprog.inference.sampling_plan import FULL, QUICK
from hdprog.outcome import WithReport, in_a_line
from hdprog.parallel import prepare_numerics, process_executor, spread_over
from hdprog.physics.other_models import MODELS
from hdprog.progress import Progress, untold
from hdprog.results import Provenance

# Longest first, so that no process waits for one that began last.
_LONGEST = ("preisach", DRIVE, "tuttle", "dhaouadi", "seyfferth", "maxwell_slip")


@dataclass(frozen=True, repr=False)
class ComparisonOutcome(WithReport):
    """The models on one record, best first, ready to be written.

    Attributes
    ----------
    result : numbers of all models
    """

    result: Comparison
    file = "compare.json"

    def __repr__(self) -> str:
        """Return what this is, for a notebook; all numbers would fill pages."""
        return in_a_line(self, (model.id for model in self.models), converged=self.converged)

    @property
    def models(self) -> tuple[ComparedModel, ...]:
        """The models, best first."""
        return self.result.models

    @property
    def sentence(self) -> str:
        """The outcome in plain words, and the table."""
        from hdprog.reporting.comparison_words import screen

        return screen(self.result)

    def document(self) -> dict[str, Any]:
        """Content of compare.json (schema hdprog.compare/1)."""
        from hdprog.reporting.comparison_json import comparison_json

        return comparison_json(self.result)

    def report(self) -> str:
        """Content of report.html."""
        from hdprog.reporting.comparison import build_comparison_report

        return build_comparison_report(self.result)


def compare(
    loop: Loop,
    drive: Drive | None = None,
    *,
    rng: np.random.Generator | None = None,
    seed: int = 0,
    quick: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
) -> ComparisonOutcome:
    """Fit the drive model and every other model to one loop, and rank them.

    Parameters
    ----------
    loop : the record
    drive : what is declared of the drive; nothing if None
    rng : source of randomness; made from `seed` if None
    seed : of everything random where no `rng` is given; recorded as None where one is
    quick : fewer draws, marked as such
    workers : processes; one a core if None. The numbers do not depend on it.
    progress : called with stage, done, total

    Raises
    ------
    UsageError
        for a path where what was read of it belongs, or what is no generator or seed
    BadInputError
        for arrays that hold no loop, or a prior that does not exist
    """
    rng, recorded = randomness(rng, seed)
    progress = progress or untold
    loop, drive = checked_record(loop, drive)
    started = time.perf_counter()
    prepare_numerics()
    prepared = prepare(loop, drive, rng)
    cycle = SteadyCycle.of(prepared.record_course, prepared.operation.reference_torque)
    reasons = {model.id: model.missing(prepared.record_course) for model in MODELS}
    left_out = [
        LeftOut(model.id, model.words, why)
        for model in MODELS
        if (why := reasons[model.id]) is not None
    ]
    able = [DRIVE, *(model.id for model in MODELS if reasons[model.id] is None)]
    streams = dict(zip(able, rng.spawn(len(able)), strict=True))
    order = sorted(able, key=lambda one: _LONGEST.index(one) if one in _LONGEST else len(_LONGEST))
    count = len(order)
    fitted = []
    with process_executor(workers) as executor:
        spread = spread_over(executor)
        found = spread(
            fit_model,
            [prepared] * count,
            order,
            [cycle] * count,
            [streams[one] for one in order],
            [QUICK if quick else FULL] * count,
        )
        for one in found:
            fitted.append(one)
            progress("models", len(fitted), count)
    fitted.sort(key=lambda one: able.index(one.id))
    models = ranked(fitted)
    result = Comparison(
        loop=loop,
        operation=prepared.operation,
        two_sided=cycle.two_sided,
        amplitude=cycle.amplitude,
        width_torque=cycle.width_torque,
        noise_floor_rad=prepared.noise_floor,
        models=models,
        left_out=tuple(left_out),
        warnings=(*_not_converged(models), *prepared.warnings),
        provenance=Provenance.of({loop.source: loop.sha256}, recorded, quick),
        seconds={"compare": time.perf_counter() - started},
    )
    return ComparisonOutcome(result)


def _not_converged(models: tuple[ComparedModel, ...]) -> list[str]:
    names = [model.words for model in models if not model.converged]
    if not names:
        return []
    return [
        f"Not converged: {', '.join(names)}. Their numbers, and their place in the ranking, are "
        "provisional."
    ]
