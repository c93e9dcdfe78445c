"""From a posterior to the numbers that are reported of a test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hdprog.config import Drive
from hdprog.inference.against_record import against_record
from hdprog.inference.identification import identification
from hdprog.inference.posterior import Posterior
from hdprog.inference.power_scaling import loop_sensitivities
from hdprog.inference.shown_draws import shown_draws
from hdprog.inference.tooth_angle import assumed, with_other_tooth_angle
from hdprog.physics.figures import FigureRequest, Operation, standard_requests
from hdprog.physics.parameters import NAMES
from hdprog.results import EffectSummary, LoopFit, ParameterSummary, TestResult, by_level


def figure_requests(drive: Drive, operation: Operation) -> tuple[FigureRequest, ...]:
    """Figures of a summary: the standard ones and every quantity that has a limit."""
    requests = {request.key: request for request in standard_requests(operation)}
    for limit in drive.limits:
        requests.setdefault(limit.key, FigureRequest.of(limit))
    return tuple(requests.values())


def parameter_summaries(posterior: Posterior) -> dict[str, ParameterSummary]:
    """Summary of each of the eight parameters in its physical unit."""
    diagnostics, contraction = posterior.diagnostics, posterior.contraction
    return {
        name: ParameterSummary(
            mean=float(values.mean()),
            sd=float(values.std(ddof=1)),
            quantiles=by_level(values),
            rhat=float(diagnostics.rhat[index]),
            ess_bulk=float(diagnostics.ess_bulk[index]),
            ess_tail=float(diagnostics.ess_tail[index]),
            contraction=contraction[name],
        )
        for index, (name, values) in enumerate((name, posterior.parameters[name]) for name in NAMES)
    }


def loop_fit(posterior: Posterior) -> LoopFit:
    """The fit along the blocks of the record."""
    angles = posterior.fitted_angles
    low, fitted, high = np.quantile(angles, (0.05, 0.5, 0.95), axis=0)
    reduced = posterior.likelihood.reduced
    scale = float(np.median(posterior.noise_scale))
    return LoopFit(
        torque=reduced.path.torque,
        angle=reduced.angle,
        count=reduced.count,
        fitted=fitted,
        low=low,
        high=high,
        residual=reduced.angle - fitted,
        noise=scale * posterior.likelihood.noise.scatter,
        position=reduced.position,
    )


def effect_summaries(posterior: Posterior) -> tuple[EffectSummary, ...]:
    """Parameters of each effect fitted beside the drive model, in their physical units."""
    likelihood, values = posterior.likelihood, posterior.effect_values
    scales = likelihood.reduced.course.scales
    described = {effect.id: effect.told_parameters(scales) for effect in likelihood.effects}
    return tuple(
        EffectSummary(
            effect,
            {one.name: by_level(values[effect][one.name][:, 0]) for one in parameters},
            {one.name: one.unit for one in parameters},
        )
        for effect, parameters in described.items()
    )


def summarise(
    posterior: Posterior,
    requests: Sequence[FigureRequest],
    test_id: str,
    meta: Mapping[str, str | float | None],
) -> TestResult:
    """Everything that is reported of a test.

    Parameters
    ----------
    posterior : of the test's loop
    requests : figures of merit to report
    test_id : name of the test
    meta : service_hours, date, note, event; each may be missing
    """
    fit, drive = loop_fit(posterior), posterior.drive
    standard = fit.residual / fit.noise
    parameters = parameter_summaries(posterior)
    drawn = posterior.figures(requests)
    figures = {key: by_level(values) for key, values in drawn.items()}
    by_parameter, by_figure = loop_sensitivities(posterior, drawn)
    other = None
    if assumed(drive.alpha, drive.alpha_declared):
        quantiles = {name: found.quantiles for name, found in parameters.items()}
        other = with_other_tooth_angle(posterior, requests, quantiles, figures)
    hours = meta.get("service_hours")
    return TestResult(
        test_id=test_id,
        service_hours=float(hours) if hours is not None else None,
        date=_text(meta.get("date")),
        note=_text(meta.get("note")),
        event=_text(meta.get("event")),
        loop=posterior.loop,
        drive=drive,
        prior_name=posterior.prior.name,
        converged=posterior.converged,
        parameters=parameters,
        figures=figures,
        figures_with_effects={
            key: by_level(values) for key, values in posterior.figures_with_effects().items()
        },
        read_off=against_record(posterior, requests),
        effects=posterior.effects,
        effect_summaries=effect_summaries(posterior),
        fit=fit,
        rmse_rad=float(np.sqrt(np.mean(posterior.record_residual[posterior.kept] ** 2))),
        noise_floor_rad=posterior.noise_floor,
        outlier_fraction=posterior.outlier_fraction,
        residual_correlation=float(np.corrcoef(standard[:-1], standard[1:])[0, 1]),
        noise_model=posterior.likelihood.noise.words,
        diagnostics=dict(posterior.sampling),
        warnings=posterior.warnings,
        identification=identification(posterior),
        sensitivity=by_parameter | by_figure,
        other_tooth_angle=other,
        draws=shown_draws(posterior),
    )


def _text(value: str | float | None) -> str | None:
    return None if value is None else str(value)
