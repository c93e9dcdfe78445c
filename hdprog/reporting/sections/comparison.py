"""Tables and words of a comparison's report."""

from __future__ import annotations

from hdprog.comparison.results import ComparedModel, Comparison
from hdprog.reporting.comparison_words import at_end, difference, width
from hdprog.reporting.geometry import MICRORADIAN
from hdprog.reporting.rounding import interval, rounded, significant
from hdprog.reporting.sections.method import Passage
from hdprog.reporting.sections.table import Cell, Group, Row, Table, Value
from hdprog.reporting.words import QUICK_RUN, contraction_words, torque_words

_NONE = "\u2013"
_DOUBTFUL = 0.02  # share of the blocks from which a warning is due
_MOST_LISTED = 20  # parameters of a model that a table lists; compare.json has all


def ranking(result: Comparison) -> Table:
    """One row a model, best first."""
    at, end = torque_words(result.width_torque), torque_words(result.amplitude)
    rows = [
        Row(
            one.words,
            (
                significant(MICRORADIAN * one.errors.rmse_rad, 3),
                significant(MICRORADIAN * one.errors.heldout_rmse_rad, 3),
                _elpd(one),
                difference(one),
                _heldout(one),
                f"{one.evidence.weight:.2f}",
                Value(*width(one)),
                _stiffness(one),
            ),
            doubtful=not one.converged,
        )
        for one in result.models
    ]
    return Table.flat(
        "Errors in µrad over all readings, and on parts left out in turn (whole cycles where the "
        "record has three or more, else tenths of it); elpd: expected log predictive density, by "
        "leave-one-out over blocks, ± standard error; how far behind the best by it, and by the "
        "left-out parts; stacking weight: share in the mixture of models that predicts best; width "
        f"of the loop at {at} in arcmin and local stiffness at {end} in Nm/rad, on a steady cycle "
        f"to {end}, with 90 % intervals.",
        (
            "model",
            "error",
            "left out",
            "elpd",
            "behind",
            "behind, left out",
            "weight",
            "width",
            "stiffness",
        ),
        rows,
    )


def _elpd(one: ComparedModel) -> str:
    spread = one.evidence.se
    return f"{rounded(one.evidence.elpd, spread)} ± {rounded(spread, spread)}"


def _heldout(one: ComparedModel) -> str:
    gap, spread = one.evidence.heldout_difference, one.evidence.heldout_difference_se
    if spread == 0:
        return "0"
    return f"{rounded(gap, spread)} ± {rounded(spread, spread)}"


def _stiffness(one: ComparedModel) -> Cell:
    if one.stiffness is None:
        return Value(_NONE, "rigid")
    texts = interval(*at_end(one.stiffness))
    return Value(texts[1], f"{texts[0]} to {texts[2]}")


def identities(result: Comparison) -> Table:
    """Where each model comes from and where it says something; those left out, and why."""
    rows = [Row(one.words, (one.equation, one.source, one.where)) for one in result.models]
    groups = [Group("", tuple(rows))]
    if result.left_out:
        out = [Row(one.words, (one.why, "", "")) for one in result.left_out]
        groups.append(Group("Not defined on this record", tuple(out)))
    return Table(
        "The models, with the equations of the paper that hdprog follows.",
        ("model", "equation", "source", "says something on"),
        tuple(groups),
    )


def parameters(result: Comparison) -> Table:
    """Posterior of the models' parameters."""
    groups = []
    for one in result.models:
        rows = [
            Row(
                name,
                (
                    Value.of(found.quantiles),
                    found.unit,
                    found.meaning,
                    contraction_words(found.contraction),
                ),
            )
            for name, found in list(one.parameters.items())[:_MOST_LISTED]
        ]
        hidden = len(one.parameters) - len(rows)
        if hidden > 0:
            rows = [
                Row("weights", (str(len(one.parameters)), "", "listed in compare.json", "")),
            ]
        if not rows:
            rows = [Row("none", ("", "", "nothing to fit", ""))]
        groups.append(Group(one.words, tuple(rows), doubtful=not one.converged))
    return Table(
        "Parameters: posterior median with the 90 % interval, and what the record told of each.",
        ("parameter", "value", "unit", "meaning", "record"),
        tuple(groups),
    )


def sampling(result: Comparison) -> Table:
    """How each posterior was had, and whether it is to be relied on."""
    rows = []
    for one in result.models:
        found = list(one.parameters.values())
        rhat = f"{max(p.rhat for p in found):.3f}" if found else _NONE
        draws = significant(min(min(p.ess_bulk, p.ess_tail) for p in found), 3) if found else _NONE
        rows.append(
            Row(
                one.words,
                (
                    one.method,
                    f"{one.sampling['steps']:.0f}",
                    rhat,
                    draws,
                    f"{100 * one.evidence.doubtful_blocks:.2g} %",
                    one.noise_model,
                    f"{one.seconds:.1f} s",
                ),
                doubtful=not one.converged,
            )
        )
    return Table.flat(
        "Sampling: largest R-hat (below 1.01 is wanted), fewest effective draws, share of blocks "
        "whose leave-one-out estimate is doubtful (Pareto k above 0.7), and the noise beside each "
        "model.",
        ("model", "posterior", "steps", "R-hat", "draws", "doubtful", "noise", "time"),
        rows,
    )


def warnings(result: Comparison) -> list[str]:
    """What should not be trusted, the gravest first."""
    found = list(result.warnings)
    found += [
        f"{one.words}: the leave-one-out estimate is doubtful at "
        f"{100 * one.evidence.doubtful_blocks:.2g} % of the blocks; look at the left-out parts "
        "instead."
        for one in result.models
        if one.evidence.doubtful_blocks > _DOUBTFUL
    ]
    if result.provenance.quick:
        found.append(QUICK_RUN)
    return found


def method(result: Comparison) -> list[Passage]:
    """How the numbers came about."""
    return [
        Passage(
            "One record, one likelihood",
            "All models see the same blocks of the record with the same reading noise; isolated "
            "spikes are set aside once, by the drive model. Angle offset and noise scale are "
            "integrated out in each. Where a model's residual is not white it gets white noise "
            "plus an Ornstein-Uhlenbeck term of its own, so that a model that misses the loop's "
            "shape is not rewarded with narrow intervals; and where that does not whiten it, its "
            "blocks count for fewer.",
        ),
        Passage(
            "Priors and posteriors",
            "Priors of the other models are weakly informative and scaled to the record: "
            "stiffnesses about its secant stiffness within a factor of three, friction torques "
            "about 3 % of its largest torque within a factor of ten; bending terms of either "
            "sign. The posteriors come from four independent emcee ensembles, those of models "
            "that are sums with nonnegative weights from exact Hamiltonian steps in four chains.",
        ),
        Passage(
            "Ranking",
            "Expected log predictive density by Pareto-smoothed importance sampling over the "
            "blocks, each given those before it where the noise is correlated (ArviZ). "
            "Differences below 4, or below two standard errors, count for nothing. The stacking "
            "weights are those of the mixture of predictive densities that predicts best. A model "
            "that misses the loop's shape smoothly is behind by less than its error suggests, as "
            "its noise term foretells a block from its neighbours. Beside it "
            "stand the errors on parts that were really left out and predicted from the rest; "
            "there the torque of the part stays known.",
        ),
        Passage(
            "Width and stiffness",
            f"Both are read on a steady cycle to {torque_words(result.amplitude)} that the record "
            "covers, so that no model is asked for what it has not seen.",
        ),
    ]
