"""The calibration study in small: its loops, ranks and faults, and ten fits."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy.stats import chi2, norm

from hdprog.data.reduce import reduce_loop, whole_course
from hdprog.data.turning_points import turning_points
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.noise import NoiseModel
from hdprog.inference.ridge_coordinates import from_unconstrained, to_unconstrained
from tests.benchmarks.calibration import Outcome, read_outcomes
from tests.benchmarks.calibration.ecdf_band import uniformity
from tests.benchmarks.calibration.faults import (
    INTERVALS,
    LOG,
    NARROW,
    RIDGE,
    SLIP,
    SOFTPLUS,
    TWICE,
    WEIGHTED,
    FixedSlip,
    log_weights,
    narrowed,
)
from tests.benchmarks.calibration.loops import (
    ABOVE,
    BELOW,
    DRIVE,
    EARLY,
    KINDS,
    draw,
    kind_of,
)
from tests.benchmarks.calibration.picture import write_picture
from tests.benchmarks.calibration.ranks import (
    HIGHEST,
    LOG_LIKELIHOOD,
    QUANTITIES,
    Located,
    rank_of,
)
from tests.benchmarks.calibration.run import measured
from tests.benchmarks.calibration.summary import CONTROL, in_words, summary


def likelihood_of(index: int) -> tuple[LoopLikelihood, np.ndarray]:
    """Likelihood of a drawn loop with its true noise, and the true point (1, 9)."""
    drawn = draw(index)
    points = turning_points(drawn.loop.torque)
    whole = whole_course(drawn.loop, points, 0.0)
    reduced = reduce_loop(drawn.loop, points, 0.0, whole=whole)
    noise = NoiseModel.white(drawn.noise / np.sqrt(reduced.count))
    return LoopLikelihood(reduced, drawn.prior, DRIVE.alpha, noise), drawn.point[None, :]


def test_what_the_truth_leaves_is_white_noise() -> None:
    """Model, path and reduction add nothing to it: the residual's squares, one in 10^4."""
    squares = degrees = 0.0
    for index in range(60):
        likelihood, truth = likelihood_of(index)
        squares += float(np.sum(likelihood.residual(truth) ** 2))
        degrees += likelihood.blocks - 1
    assert chi2.ppf(5e-5, degrees) < squares < chi2.isf(5e-5, degrees)


def test_kinds_are_what_they_are_called() -> None:
    drawn = [draw(index) for index in range(100)]
    assert [one.kind for one in drawn] == [kind_of(index) for index in range(100)]
    by_kind = {kind: [one for one in drawn if one.kind == kind] for kind in KINDS}
    assert {len(group) for group in by_kind.values()} == {20}
    assert all(one.one_sided or one.loop.torque.min() < -20 for one in drawn)
    for kind in (BELOW, ABOVE):
        sides = [one.largest_torque < float(one.parameters["T_i"][0]) for one in by_kind[kind]]
        # 2 SD of the prior: one in 40 lies on the other side, and four of 20 once in 800 times.
        assert np.mean([side == (kind == BELOW) for side in sides]) >= 0.85
    assert max(float(one.parameters["T_T"][0]) for one in by_kind[EARLY]) < 5.0


def gaussian_ranks(
    loops: int, fault: str | None, rng: np.random.Generator
) -> tuple[list[list[int]], list[list[float]]]:
    """Ranks and shares of a made-up study: standard normal posteriors, the truth drawn from them.

    The log-likelihood is minus half the sum of squares of the others.
    """
    ranks, shares = [], []
    for _ in range(loops):
        draws = rng.standard_normal((len(QUANTITIES) - 1, 2000))
        truth = rng.standard_normal(len(QUANTITIES) - 1)
        found = Located(
            truth=named(truth),
            draws=named(draws),
            independent=named(draws[:, :HIGHEST]),
            points=draws.T,
        )
        if fault == INTERVALS:
            found = narrowed(found, 0.8)
        ranks.append(found.ranks(rng))
        shares.append(found.shares(1.0 * draws[0] if fault == "shifted" else None))
    return ranks, shares


def named(values: np.ndarray) -> dict[str, Any]:
    return dict(zip(QUANTITIES, [*values, -0.5 * np.sum(values**2, axis=0)], strict=True))


def test_weights_and_narrowing_do_what_they_say() -> None:
    """exp(x) moves a standard normal variable by one; 0.8 of the SD gives 0.8 of the interval."""
    rng = np.random.default_rng(8)
    draws = rng.standard_normal((len(QUANTITIES) - 1, 200_000))
    truth = np.full(len(QUANTITIES) - 1, 0.5)
    found = Located(named(truth), named(draws), named(draws[:, :HIGHEST]), draws.T)
    # Monte-Carlo error is 0.002 with these weights.
    assert found.shares(draws[0])[0] == pytest.approx(norm.cdf(-0.5), abs=0.01)
    assert found.shares(draws[0])[1] == pytest.approx(norm.cdf(0.5), abs=0.01)
    assert narrowed(found, 0.8).shares()[0] == pytest.approx(norm.cdf(0.5 / 0.8), abs=0.01)
    assert narrowed(found, 0.8).shares()[-1] == found.shares()[-1]


def test_equal_draws_leave_the_rank_to_chance() -> None:
    same = dict.fromkeys(QUANTITIES, np.zeros(HIGHEST))
    found = Located(dict.fromkeys(QUANTITIES, 0.0), same, same, np.zeros((HIGHEST, 1)))
    rng = np.random.default_rng(9)
    ranks = np.array([found.ranks(rng) for _ in range(100)]).ravel()
    assert uniformity(ranks.size, HIGHEST).p_value(ranks) > 1e-3
    assert [rank_of(share) for share in (0.0, 0.5, 1.0, -1e-9)] == [0, 192, HIGHEST, 0]


def test_log_weights_are_those_of_the_fault() -> None:
    """Against densities written out: prior, slopes of the transforms, a numerical Jacobian."""
    likelihood, truth = likelihood_of(1)
    points = truth + 1e-3 * np.random.default_rng(5).standard_normal((4, 9))
    prior = likelihood.prior
    by_fault = {fault: log_weights(fault, points, likelihood) for fault in WEIGHTED}
    density = np.sum(norm.logpdf(points[:, :8], prior.mean, prior.sd), axis=1)
    step = 1e-6 * np.eye(9)
    slopes = {
        name: np.log(
            prior.to_physical((points + step[at])[:, :8])[name]
            - prior.to_physical((points - step[at])[:, :8])[name]
        )
        for at, name in ((2, "a"), (4, "T_T"))
    }
    frame = likelihood.ridge_frame
    ridge = from_unconstrained(points[:, :8], *frame)
    moved = [
        (to_unconstrained(ridge + one, *frame)[0] - points[:, :8]) / 1e-6 for one in step[:8, :8]
    ]
    jacobian = np.linalg.slogdet(np.stack(moved, axis=1))[1]
    posterior = jacobian + likelihood.log_prior(points) + likelihood.log_likelihood(points)
    for fault, expected in (
        (TWICE, density),
        (SOFTPLUS, slopes["T_T"]),
        (LOG, slopes["a"]),
        (RIDGE, -jacobian),
        (NARROW, (1 / 0.9**2 - 1) * posterior),
    ):
        # Only differences between draws count.
        np.testing.assert_allclose(
            np.diff(by_fault[fault]), np.diff(expected), rtol=1e-3, atol=1e-7
        )
    with pytest.raises(ValueError, match="no fault with weights"):
        log_weights(SLIP, points, likelihood)


def test_fixed_slip_knows_no_other_slip() -> None:
    likelihood, truth = likelihood_of(1)
    wrong = FixedSlip(likelihood.reduced, likelihood.prior, likelihood.alpha, likelihood.noise)
    middle, other = truth.copy(), truth.copy()
    middle[0, 8], other[0, 8] = 0.0, 3.0
    np.testing.assert_array_equal(wrong.angle(other), likelihood.angle(middle))
    assert np.ptp(likelihood.angle(other) - likelihood.angle(middle)) > 0


@pytest.fixture(scope="module")
def study() -> list[Outcome]:
    """A made-up study: right, and with two faults."""
    rng = np.random.default_rng(12)
    ranks, shares = gaussian_ranks(200, None, rng)
    _, narrow = gaussian_ranks(200, INTERVALS, rng)
    _, shifted = gaussian_ranks(200, "shifted", rng)
    return [
        Outcome(
            index,
            "code",
            kind=kind_of(index),
            ranks=ranks[index],
            shares=shares[index],
            faults={
                NARROW: [rank_of(share) for share in narrow[index]],
                TWICE: [rank_of(share) for share in shifted[index]],
            },
            converged=index > 2,
            processor_seconds={"fit": 1.0},
        )
        for index in range(200)
    ]


def test_a_right_posterior_passes_and_wrong_ones_do_not(study: list[Outcome]) -> None:
    result = summary([*study, Outcome(200, "code", status="failed", reason="why")])
    faults = result["faults"]
    assert [faults[name]["caught"] for name in (CONTROL, NARROW, TWICE)] == [False, True, True]
    assert faults[TWICE]["plainest in"] == QUANTITIES[0]
    # The band's rate is 5 % at most; 1 000 repetitions pass 7.5 % once in 2 000 times.
    assert 0.01 < faults[CONTROL]["power"] < 0.075
    assert faults[TWICE]["power"] > 0.99
    assert result["failed"] == 1
    assert result["loops_by_kind"]["all"]["not converged, kept"] == 3
    for level in ("0.5", "0.9"):
        shares = [one["share"] for one in result["coverage"][level]["all"].values()]
        # 21 quantities, most of them independent: the mean's SD is below 0.01.
        assert np.mean(shares) == pytest.approx(float(level), abs=0.035)
    words = in_words(result)
    assert "**No quantity leaves the band**" in words
    assert "1 failed and are left out; 3 did not converge and are kept in" in words
    assert all(name in words for name in QUANTITIES)


def test_picture_and_file_of_loops(study: list[Outcome], tmp_path: Path) -> None:
    write_picture(study, summary(study), tmp_path / "calibration.png")
    with Image.open(tmp_path / "calibration.png") as image:
        assert np.asarray(image.convert("L")).std() > 20
    lines = [json.dumps(asdict(one)) for one in (study[1], study[0], replace(study[1], code="new"))]
    (tmp_path / "loops.jsonl").write_text("\n".join([*lines, lines[0][:40]]), "utf-8")
    found, unreadable = read_outcomes(tmp_path / "loops.jsonl")
    assert [(one.index, one.code) for one in found] == [(0, "code"), (1, "new")]
    assert unreadable == 1


def test_ten_fits_hold_their_truth() -> None:
    """The whole way with the quick plan, on loops of all kinds; false alarm at one in 1 000."""
    loops = [measured(index, "here", refit=False) for index in range(10)]
    assert [one.status for one in loops] == ["fitted"] * 10
    assert sum(one.converged for one in loops) >= 8
    ranks = np.array([one.ranks for one in loops])
    test = uniformity(len(loops), HIGHEST)
    assert min(test.p_value(column) for column in ranks.T) > 1e-3 / len(QUANTITIES)
    # A gross fault: the ranks that draws at a quarter of their standard deviation would give.
    scores = norm.ppf((ranks + 0.5) / (HIGHEST + 1)) / 0.25
    gross = np.array([[rank_of(share) for share in row] for row in norm.cdf(scores)])
    assert min(test.p_value(column) for column in gross.T) < 1e-3 / len(QUANTITIES)
    narrow = np.array([one.faults[NARROW] for one in loops])[:, -1]
    assert QUANTITIES[-1] == LOG_LIKELIHOOD
    # Too narrow a posterior lies where the likelihood is higher: the truth's rank falls.
    assert narrow.mean() < ranks[:, -1].mean()
