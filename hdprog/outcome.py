"""What a fit, an explanation or a run hands back: the result, its posteriors, files to write."""

from __future__ import annotations

import importlib
import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from hdprog.atomic import atomic_directory
from hdprog.beside_report import require_no_other_report
from hdprog.config import ReportSettings
from hdprog.errors import UsageError
from hdprog.explanation import DriveExplanation, ErrorFigures, Explanation, FoundEffect
from hdprog.inference.lazy_arviz import arviz
from hdprog.inference.posterior import Posterior
from hdprog.parallel import process_executor, spread_over
from hdprog.results import DriveResult, Forecast, TestResult, TrendSummary

if TYPE_CHECKING:
    from arviz import InferenceData


RUN_KEY = "input.sha256"
"""Beside results in a fleet's folder: from which files and options they are."""

_RESULTS = ("posterior.nc", "posteriors/*.nc", "explain.json", "report.pdf", RUN_KEY)


def results_in(out: Path) -> tuple[str, ...]:
    """Patterns of an earlier run's results in a folder: they would pass for this one's."""
    return _RESULTS if (out / "summary.json").is_file() else ()


def in_a_line(result: object, names: Iterable[str], *, converged: bool) -> str:
    """Say what a result is and of what, for a notebook, whose pages all its numbers would fill."""
    state = "converged" if converged else "not converged"
    of = ", ".join(names)
    return f"<{type(result).__name__} of {of}: {state}; its words are in .sentence>"


def write_beside_report(out: Path, name: str, document: Mapping[str, Any], report: str) -> None:
    """Write a JSON document and report.html into a folder, each whole; a new folder at once.

    A report.pdf of before goes: it would be another report than the one beside it.
    """
    require_no_other_report(out, name)
    with atomic_directory(out, ("report.pdf",)) as folder:
        text = json.dumps(document, indent=1, allow_nan=False, ensure_ascii=False)
        (folder / name).write_text(text + "\n", "utf-8")
        (folder / "report.html").write_text(report, "utf-8")


@dataclass(frozen=True, repr=False)
class WithReport(ABC):
    """A result that is written as one JSON document beside its report.

    Attributes
    ----------
    result : numbers ready to be written, with their provenance
    file : name of the document
    """

    result: Any
    file: ClassVar[str]

    @property
    def converged(self) -> bool:
        """Whether everything that was sampled converged."""
        return bool(self.result.converged)

    @abstractmethod
    def document(self) -> dict[str, Any]:
        """Content of the JSON document."""

    @abstractmethod
    def report(self) -> str:
        """Content of report.html."""

    def write(self, out: str | Path, command: str = "Python API") -> None:
        """Write the document and report.html, each whole; a new folder at once."""
        stamped = replace(self, result=_stamped(self.result, command))
        write_beside_report(Path(out), self.file, stamped.document(), stamped.report())


def _stamped(result: Any, command: str) -> Any:
    """A result whose provenance tells the command, as typed."""
    return replace(result, provenance=replace(result.provenance, command=command))


@dataclass(frozen=True, repr=False)
class Outcome:
    """The result of a fit or a run, with its posteriors.

    Attributes
    ----------
    result : numbers ready to be written
    posteriors : one a test, in the order of `result.tests`
    single : a fit of one loop, not a drive's run
    """

    result: DriveResult
    posteriors: tuple[Posterior, ...]
    single: bool

    def __repr__(self) -> str:
        """Return what this is, for a notebook; the draws would fill pages."""
        return in_a_line(self, (test.test_id for test in self.tests), converged=self.converged)

    @property
    def tests(self) -> tuple[TestResult, ...]:
        """Results of the tests, by service hours."""
        return self.result.tests

    @property
    def trend(self) -> TrendSummary | None:
        """The trend over service hours; None for a single fit."""
        return self.result.trend

    @property
    def forecasts(self) -> tuple[Forecast, ...]:
        """First crossing of each limit, then of the first of them."""
        return self.result.forecasts

    @property
    def converged(self) -> bool:
        """Whether every fit and the trend converged, the drive model alone in every test too."""
        found = self.result.explanation
        if found is None:
            return self.result.converged
        alone = found.tests if isinstance(found, DriveExplanation) else (found,)
        return self.result.converged and all(test.converged for test in alone)

    @property
    def sentence(self) -> str:
        """The outcome in plain words."""
        from hdprog.reporting.verdict import verdict

        return verdict(self.result).text

    @property
    def verdict(self) -> str:
        """The outcome in plain words."""
        return self.sentence

    @property
    def doubts(self) -> tuple[str, ...]:
        """What in the records deserves a second look, by test."""
        each = zip(self.tests, self.posteriors, strict=True)
        return tuple(f"{test.test_id}: {text}" for test, fit in each for text in fit.loop.warnings)

    def reported(self, change: Callable[[ReportSettings], ReportSettings]) -> Self:
        """The same with the settings of its report changed; its numbers stay as they are."""
        drive = self.result.drive
        told = replace(drive, report=change(drive.report))
        return replace(self, result=replace(self.result, drive=told))

    def document(self) -> dict[str, Any]:
        """What a command prints as JSON: the summary."""
        return self.summary()

    @cached_property
    def idata(self) -> InferenceData:
        """Draws of a single fit as an ArviZ InferenceData.

        Raises
        ------
        UsageError
            for a run over several tests, where `idata_of` takes a test's name
        """
        if len(self.posteriors) != 1:
            raise UsageError("idata: this result has several tests; use idata_of(test_id)")
        return self.idata_of(self.tests[0].test_id)

    def idata_of(self, test_id: str) -> InferenceData:
        """Draws of one test as an ArviZ InferenceData."""
        names = [test.test_id for test in self.tests]
        if test_id not in names:
            raise UsageError(f"idata_of: found {test_id!r}, expected one of {', '.join(names)}")
        posterior = self.posteriors[names.index(test_id)]
        return _with_draws(posterior, *self._origin(posterior))

    def summary(self) -> dict[str, Any]:
        """Content of summary.json (schema hdprog.summary/1)."""
        from hdprog.reporting.summary import summary_json

        return summary_json(self.result)

    def write(
        self, out: str | Path, command: str = "Python API", workers: int | None = None
    ) -> None:
        """Write the JSON files, report.html and the posteriors, each whole; a new folder at once.

        Parameters
        ----------
        out : the folder
        command : as typed, for the provenance
        workers : processes; one a core if None

        Raises
        ------
        BadInputError
            where results of another kind lie, whose report would be lost
        """
        require_no_other_report(Path(out), "posterior.nc" if self.single else "posteriors")
        from hdprog.reporting.build import build_report
        from hdprog.reporting.explain_json import explain_json

        stamped = replace(self, result=_stamped(self.result, command))
        with (
            atomic_directory(Path(out), results_in(Path(out))) as folder,
            process_executor(workers) as executor,
        ):
            spread = spread_over(executor)
            if not self.single:
                (folder / "posteriors").mkdir()
            names = [
                "posterior.nc" if self.single else f"posteriors/{test.test_id}.nc"
                for test in self.tests
            ]
            each = [
                (posterior, *stamped._origin(posterior), folder / name)
                for posterior, name in zip(self.posteriors, names, strict=True)
            ]
            saved = spread(_save, *zip(*each, strict=True))
            summary = json.dumps(stamped.summary(), indent=1, allow_nan=False)
            (folder / "summary.json").write_text(summary + "\n", "utf-8")
            catalogue = self.posteriors[0].prior.catalogue
            report = build_report(stamped.result, catalogue, spread=spread)
            (folder / "report.html").write_text(report, "utf-8")
            if self.result.explanation is not None:
                explained = json.dumps(explain_json(stamped.result), indent=1, allow_nan=False)
                (folder / "explain.json").write_text(explained + "\n", "utf-8")
            for _ in saved:  # a failure in a worker is raised here
                pass

    def _origin(self, posterior: Posterior) -> tuple[int, dict[str, Any]]:
        """Seed of prior and predictive draws, and where a posterior comes from."""
        provenance = self.result.provenance
        attributes = {
            "hdprog_version": provenance.hdprog_version,
            "seed": "not recorded" if provenance.seed is None else provenance.seed,
            "command": provenance.command,
            "source_file": posterior.loop.source,
            "source_sha256": posterior.loop.sha256,
        }
        return provenance.seed or 0, attributes


def import_for_writing() -> None:
    """Import what `Outcome.write` needs; waiting for workers is the time for it."""
    for name in ("hdprog.reporting.build", "hdprog.inference.inference_data", "h5netcdf"):
        importlib.import_module(name)
    arviz()


def _with_draws(posterior: Posterior, seed: int, attributes: dict[str, Any]) -> InferenceData:
    from hdprog.inference.inference_data import inference_data

    return inference_data(posterior, np.random.default_rng(seed), attributes)


def _save(posterior: Posterior, seed: int, attributes: dict[str, Any], path: Path) -> None:
    """Write a posterior as netCDF."""
    from hdprog.inference.netcdf import netcdf

    path.write_bytes(netcdf(_with_draws(posterior, seed, attributes)))


@dataclass(frozen=True, repr=False)
class ExplainOutcome(Outcome):
    """The result of closing the loop on a record or a drive."""

    @property
    def explanation(self) -> Explanation | DriveExplanation:
        """Everything that was found."""
        assert self.result.explanation is not None
        return self.result.explanation

    @property
    def verdict(self) -> str:
        """One of adequate, explained, partly_explained and unexplained."""
        return self.explanation.verdict

    @property
    def sentence(self) -> str:
        """The outcome in plain words; that nothing was added answers what was asked, too."""
        if self.effects:  # which the verdict on the drive tells
            return super().sentence
        from hdprog.reporting.sections.effects_lead import lead
        from hdprog.reporting.words import tidy

        return f"{super().sentence} {tidy(lead(self.explanation))}"

    @property
    def effects(self) -> tuple[FoundEffect, ...]:
        """Effects that were added, the one that carries most first."""
        return self.explanation.effects

    @property
    def before(self) -> ErrorFigures:
        """Error of the drive model alone, pooled over the tests of a drive."""
        return self._errors(lambda one: one.before)

    @property
    def after(self) -> ErrorFigures:
        """Error with the effects."""
        return self._errors(lambda one: one.after)

    def document(self) -> dict[str, Any]:
        """Content of explain.json (schema hdprog.explain/1)."""
        from hdprog.reporting.explain_json import explain_json

        return explain_json(self.result)

    def _errors(self, which: Callable[[Explanation], ErrorFigures]) -> ErrorFigures:
        from hdprog.reporting.pooled import pooled_errors

        explanation = self.explanation
        if isinstance(explanation, Explanation):
            return which(explanation)
        return pooled_errors(explanation.tests, which)
