"""Models ranked by expected log predictive density, with stacking weights (ArviZ)."""

from __future__ import annotations

from collections.abc import Sequence

from hdprog.comparison.fitted import Fitted
from hdprog.comparison.results import ComparedModel, Evidence
from hdprog.discovery.heldout import elpd_difference
from hdprog.inference.lazy_arviz import arviz


def ranked(fitted: Sequence[Fitted]) -> tuple[ComparedModel, ...]:
    """The models, best first.

    Differences count from the best model, positive where a model is worse (Vehtari, Gelman & Gabry,
    Stat. Comput. 27 (2017) 1413); weights make the mixture of predictive densities that predicts
    best (Yao et al., Bayesian Analysis 13 (2018) 917).
    """
    table = arviz().compare({one.id: one.loo for one in fitted}, ic="loo", method="stacking")
    by_id = {one.id: one for one in fitted}
    best = by_id[str(table.index[0])]
    return tuple(
        _compared(
            by_id[str(name)],
            best,
            difference=float(row["elpd_diff"]),
            difference_se=float(row["dse"]),
            weight=float(row["weight"]),
        )
        for name, row in table.iterrows()
    )


def _compared(
    one: Fitted, best: Fitted, *, difference: float, difference_se: float, weight: float
) -> ComparedModel:
    gain, gain_se = (0.0, 0.0) if one is best else elpd_difference(best.held, one.held)
    return ComparedModel(
        id=one.id,
        words=one.words,
        source=one.source,
        where=one.where,
        equation=one.equation,
        parameters=one.parameters,
        errors=one.errors,
        evidence=Evidence(
            elpd=float(one.loo.elpd_loo),
            se=float(one.loo.se),
            effective_parameters=float(one.loo.p_loo),
            difference=difference,
            difference_se=difference_se,
            weight=min(max(weight, 0.0), 1.0),
            doubtful_blocks=one.doubtful_blocks,
            heldout_difference=gain,
            heldout_difference_se=gain_se,
        ),
        width=one.width,
        stiffness=one.stiffness,
        fit=one.fit,
        converged=one.converged,
        method=one.method,
        noise_model=one.noise_model,
        sampling=one.sampling,
        seconds=one.seconds,
    )
