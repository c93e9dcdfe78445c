"""The second simulator against the reference table, against itself and against the envelopes."""

from __future__ import annotations

import json
import math
import time
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from .drives import (
    LAWS,
    REGULAR_LAWS,
    WearLaw,
    drifts,
    first_crossing,
    wear_curve,
    write_drive,
)
from .effects import EFFECTS
from .loops import (
    KINDS,
    LoopKind,
    programme,
    random_loop,
    random_parameters,
    record_loop,
    suitable_effects,
    worn_parameters,
    write_csv,
)
from .simulator import (
    INITIAL,
    POST_TEST,
    DriveParameters,
    FloatArray,
    MeasurementChain,
    Segment,
    make_path,
    mesh_angle,
    simulate,
    steady_cycle,
    true_figures,
    wave_generator_slip,
)

# Torque, then initial loading, initial unloading, post-test loading, post-test unloading and
# post-test loading with the printed sum.
REFERENCE = {
    0.0: (-6.106267e-05, 6.106267e-05, -4.348585e-05, 4.348585e-05, -4.348585e-05),
    10.0: (1.785168e-04, 2.900685e-04, 9.105894e-04, 9.879140e-04, 8.068909e-04),
    30.0: (6.310166e-04, 7.480803e-04, 1.732874e-03, 1.816274e-03, 1.641943e-03),
    50.0: (1.089414e-03, 1.206092e-03, 2.385559e-03, 2.469014e-03, 2.294628e-03),
    100.0: (2.235409e-03, 2.235409e-03, 4.000364e-03, 4.000364e-03, 3.909433e-03),
}


@pytest.mark.parametrize("torque", REFERENCE)
def test_reference_table(torque: float) -> None:
    """Reproduce every entry of the table to its last digit."""
    at = tuple(REFERENCE)
    initial = steady_cycle(INITIAL, 100.0, at=at)
    post = steady_cycle(POST_TEST, 100.0, at=at)
    printed = steady_cycle(POST_TEST, 100.0, at=at, mesh="as_printed")
    k = int(np.argmin(np.abs(initial.torque - torque)))
    found = (
        initial.loading[k],
        initial.unloading[k],
        post.loading[k],
        post.unloading[k],
        printed.loading[k],
    )
    np.testing.assert_allclose(found, REFERENCE[torque], rtol=0.0, atol=0.6e-9)


def test_width_at_the_smaller_tooth_angle() -> None:
    """Reproduce the widths at zero torque that go with a tooth angle of 20 degrees."""
    for parameters, width in ((INITIAL, 6.993e-5), (POST_TEST, 4.969e-5)):
        cycle = steady_cycle(parameters, 100.0, alpha_deg=20.0)
        k = int(np.argmin(np.abs(cycle.torque)))
        assert cycle.unloading[k] - cycle.loading[k] == pytest.approx(width, abs=0.6e-8)


def test_figures_of_table_2() -> None:
    """Reproduce the figures stated for both states at +-63 Nm."""
    for parameters, secant, width, lost in (
        (INITIAL, 43.6e3, 0.420, 0.40),
        (POST_TEST, 12.1e3, 0.299, 2.50),
    ):
        figures = true_figures(parameters)
        assert figures["secant_stiffness_Nm_per_rad@14Nm"] == pytest.approx(secant, abs=60.0)
        assert figures["hysteresis_width_arcmin"] == pytest.approx(width, abs=6e-4)
        assert figures["lost_motion_of_stiffness_curve_arcmin"] == pytest.approx(lost, abs=6e-3)
        assert figures["lost_motion_arcmin"] == pytest.approx(lost, abs=1.2e-2)


def test_mesh_quadrature_against_the_logarithm() -> None:
    """Integrate 1/(aT + b) by quadrature as exactly as its antiderivative gives it."""
    torque = np.concatenate((np.linspace(3.0, 70.0, 821), np.linspace(70.0, -90.0, 1731)[1:]))
    p = POST_TEST
    size = np.abs(torque)
    exact = np.log(1.0 + p.a * np.minimum(size, p.T_T) / p.b) / p.a
    exact = np.sign(torque) * (exact + np.maximum(size - p.T_T, 0.0) / (p.a * p.T_T + p.b))
    np.testing.assert_allclose(mesh_angle(torque, p), exact, rtol=0.0, atol=1e-12)


def _envelopes(torque: float, p: DriveParameters, alpha_deg: float) -> tuple[float, float]:
    """Return the slip between which the wave generator may rest (eqs 26, 28)."""
    s, k = math.sin(math.radians(alpha_deg)), math.cos(math.radians(alpha_deg))
    size = abs(torque)
    t0 = max(p.c * (size - p.T_i), 0.0)
    if size <= p.mu * t0 / (s + p.mu * k):
        inner = (size * (s + p.mu * k) - p.mu * t0) / (p.K_W * (k - p.mu * s))
    elif size <= p.mu * t0 / (s - p.mu * k):
        inner = 0.0
    else:
        inner = (size * (s - p.mu * k) - p.mu * t0) / (p.K_W * (k + p.mu * s))
    outer = (size * (s + p.mu * k) + p.mu * t0) / (p.K_W * (k - p.mu * s))
    return (inner, outer) if torque >= 0.0 else (-outer, -inner)


@pytest.mark.parametrize("seed", range(6))
def test_slip_rests_between_the_envelopes(seed: int) -> None:
    """Let friction alone decide, and find the slip moved onto an envelope or not moved at all."""
    rng = np.random.default_rng(seed)
    parameters, torque_max = random_parameters(rng)
    turns = np.concatenate(([0.0], rng.uniform(-torque_max, torque_max, 25)))
    torque = np.interp(np.linspace(0.0, 25.0, 2501), np.arange(26), turns)
    slip = wave_generator_slip(torque, parameters)
    low, high = np.array([_envelopes(t, parameters, 30.0) for t in torque]).T
    tolerance = 1e-15
    assert np.all(slip >= low - tolerance)
    assert np.all(slip <= high + tolerance)
    step = np.diff(slip, prepend=0.0)
    assert np.allclose(slip[step > 0.0], low[step > 0.0], rtol=0.0, atol=tolerance)
    assert np.allclose(slip[step < 0.0], high[step < 0.0], rtol=0.0, atol=tolerance)
    assert np.count_nonzero(step == 0.0) > 20


@pytest.mark.parametrize("seed", range(6))
def test_steady_cycle_is_closed_odd_and_loses_energy(seed: int) -> None:
    """Come back to the starting point, mirror under T to -T, and enclose a positive area."""
    rng = np.random.default_rng(seed)
    parameters, torque_max = random_parameters(rng)
    cycle = steady_cycle(parameters, torque_max)
    assert cycle.loading[0] == pytest.approx(cycle.unloading[0], abs=1e-13)
    assert cycle.loading[-1] == pytest.approx(cycle.unloading[-1], abs=1e-13)
    np.testing.assert_allclose(cycle.loading, -cycle.unloading[::-1], rtol=0.0, atol=1e-12)
    width = cycle.unloading - cycle.loading
    assert width.min() > -1e-13
    assert true_figures(parameters, reference_torque=torque_max)["hysteresis_loss_J"] > 0.0
    again = steady_cycle(parameters, torque_max, points=960)
    np.testing.assert_allclose(
        np.interp(cycle.torque, again.torque, again.loading), cycle.loading, rtol=0.0, atol=2e-6
    )


def test_first_loading_differs_from_the_steady_cycle() -> None:
    """Start from rest at zero slip, above the steady loading branch and below the unloading."""
    rng = np.random.default_rng(1)
    path = make_path(0.0, [Segment(63.0, 10.0), Segment(0.0, 10.0)], 200, rng)
    trace = simulate(path, POST_TEST)
    cycle = steady_cycle(POST_TEST, 63.0)
    rising = path.time < 10.0
    steady = np.interp(path.torque[rising], cycle.torque, cycle.loading)
    first = trace.angle[rising]
    early = path.torque[rising] < 2.0
    assert trace.angle[0] == 0.0
    assert np.all(first[early][:-1] > steady[early][:-1] + 1e-5)
    assert trace.angle[-1] == pytest.approx(-cycle.loading[cycle.torque == 0.0][0], abs=1e-12)


def test_different_sides_have_their_own_parameters() -> None:
    """Use the negative set below zero torque only."""
    soft = replace(POST_TEST, K_F=40000.0, b=4000.0)
    rng = np.random.default_rng(0)
    path = make_path(0.0, [Segment(50.0, 5.0), Segment(-50.0, 10.0)], 300, rng)
    both = simulate(path, POST_TEST, negative=soft)
    one = simulate(path, POST_TEST)
    positive = path.torque >= 0.0
    np.testing.assert_allclose(both.angle[positive], one.angle[positive], rtol=0, atol=1e-12)
    assert both.angle.min() < one.angle.min() - 1e-4


@pytest.mark.parametrize("shape", ["ramp", "sine", "irregular"])
def test_torque_programmes_reach_their_targets(shape: str) -> None:
    """Pass every target, keep holds still, move one way within a segment and in time."""
    rng = np.random.default_rng(3)
    segments = [
        Segment(40.0, 5.0, shape, recorded=False),  # type: ignore[arg-type]
        Segment(0.0, 5.0, shape, recorded=False),  # type: ignore[arg-type]
        Segment(60.0, 5.0, shape),  # type: ignore[arg-type]
        Segment(60.0, 3.0, "hold"),
        Segment(-20.0, 9.0, shape),  # type: ignore[arg-type]
    ]
    path = make_path(0.0, segments, 151, rng)
    assert path.recorded.size == 151
    assert np.all(np.diff(path.time) > 0.0)
    assert path.time[path.recorded[0]] >= 0.0
    assert np.interp([-5.0, 0.0, 5.0, 8.0, 17.0], path.time, path.torque) == pytest.approx(
        [40.0, 0.0, 60.0, 60.0, -20.0], abs=1e-9
    )
    hold = (path.time > 5.0) & (path.time < 8.0)
    assert np.ptp(path.torque[hold]) == 0.0
    assert np.all(np.diff(path.torque[path.time >= 8.0]) <= 0.0)


def test_unrecorded_segments_come_first() -> None:
    """Refuse a gap in the recording."""
    with pytest.raises(ValueError, match="unrecorded segments must come first"):
        make_path(
            0.0,
            [Segment(10.0, 1.0), Segment(0.0, 1.0, recorded=False)],
            20,
            np.random.default_rng(0),
        )


def test_measurement_chain() -> None:
    """Find resolution, noise, memory and spikes of the sensors in a record.

    The bounds are five standard errors and more: false alarms below 1e-5, at a fixed seed.
    """
    rng = np.random.default_rng(5)
    segments = programme("two-sided", 63.0, 30.0, rng)
    plain = record_loop(POST_TEST, segments, 4000, rng, chain=MeasurementChain(angle_zero=0.7))
    error = plain.angle - plain.true_angle - 0.7
    expected = math.hypot(1.0e-5, 9.77e-6 / math.sqrt(12.0))
    assert np.std(error) == pytest.approx(expected, rel=0.06)
    steps = plain.torque / 0.1
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert abs(_lag_one(error)) < 0.08
    assert np.all(np.diff(plain.time) > 0.0)
    dirty = record_loop(
        POST_TEST,
        segments,
        4000,
        rng,
        chain=MeasurementChain(correlation_time=5.0, spike_share=0.02),
    )
    spikes = np.array(dirty.truth["spike_indices"], dtype=int)
    assert 40 < spikes.size < 125
    rest = np.delete(dirty.angle - dirty.true_angle, spikes)
    assert _lag_one(rest) > 0.4


def _lag_one(values: FloatArray) -> float:
    """Return the correlation of neighbours."""
    return float(np.corrcoef(values[1:], values[:-1])[0, 1])


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_changes_the_loop_as_much_as_asked(name: str) -> None:
    """Find the size asked for, and a part of it that the base model could not imitate.

    The drive is a worn one: where the mesh is not soft, a torque offset is an angle zero. The
    part is smallest for backlash, most of which passes for a soft mesh.
    """
    size = 5e-5
    segments = programme("multi-rate", 100.0, 20.0, np.random.default_rng(4))
    record = record_loop(
        POST_TEST,
        segments,
        600,
        np.random.default_rng(11),
        effects={name: size},
        absorption=True,
    )
    bare = record_loop(POST_TEST, segments, 600, np.random.default_rng(11))
    entries = record.truth["effects"]
    assert isinstance(entries, list)
    (entry,) = entries
    assert entry["identifier"] == EFFECTS[name].identifier
    if EFFECTS[name].acts_on == "angle":
        assert np.std(record.true_angle - bare.base_angle) == pytest.approx(size, rel=1e-6)
    else:
        moved = record.torque - bare.torque
        assert np.std(record.true_angle - bare.base_angle) == 0.0
        assert np.sqrt(np.mean(moved**2)) > 0.2
    left = float(str(record.truth["unabsorbed_rmse_rad"]))
    assert left > (0.02 if name == "backlash" else 0.05) * size
    assert (record.temperature is not None) == name.startswith("thermal")
    assert (record.output_angle is not None) == (name == "kinematic_error")


def test_without_effects_nothing_is_left_over() -> None:
    """Leave nothing that the base model could not imitate where there is no effect."""
    record = random_loop(np.random.default_rng(2), "minor-loops", absorption=True)
    assert float(str(record.truth["unabsorbed_rmse_rad"])) < 1e-12


def test_effects_that_a_record_cannot_show_are_refused() -> None:
    """Refuse play in a record that has torque of one sign only."""
    assert "backlash" not in suitable_effects("one-sided")
    with pytest.raises(ValueError, match="torque of both signs"):
        random_loop(np.random.default_rng(0), "one-sided", effects={"backlash": 5e-5})


@pytest.mark.parametrize("kind", KINDS)
def test_random_loops(kind: LoopKind, tmp_path: Path) -> None:
    """Draw loops within their promised ranges, the same for the same seed, and write them."""
    ratios = []
    for seed in range(25):
        record = random_loop(np.random.default_rng(seed), kind)
        assert 150 <= record.torque.size <= 800
        assert np.all(np.isfinite(record.angle))
        assert np.all(np.diff(record.time) > 0.0)
        ratios.append(float(str(record.truth["T_max_over_T_i"])))
    assert min(ratios) < 1.0 < max(ratios)
    again = random_loop(np.random.default_rng(24), kind)
    np.testing.assert_array_equal(record.angle, again.angle)
    json.dumps(record.truth)
    write_csv(record, tmp_path / "loop.csv")
    read = np.genfromtxt(tmp_path / "loop.csv", delimiter=",", names=True)
    assert read.dtype.names == ("time_s", "torque_Nm", "angle_rad")
    np.testing.assert_allclose(read["angle_rad"], record.angle, rtol=0.0, atol=1e-9)


def test_a_loop_is_fast() -> None:
    """Make a loop of 500 samples in under 50 ms, at the median."""
    taken = []
    for seed in range(9):
        begin = time.perf_counter()
        random_loop(np.random.default_rng(seed), "multi-cycle", samples=500)
        taken.append(time.perf_counter() - begin)
    assert float(np.median(taken)) < 0.05


def test_worn_parameters_pass_through_table_2() -> None:
    """Meet both states of Table 2 in what can be told apart."""
    new, worn = worn_parameters(0.0), worn_parameters(1.0)
    assert worn.as_dict() == pytest.approx(POST_TEST.as_dict(), rel=1e-12)
    a, b = steady_cycle(new, 100.0), steady_cycle(INITIAL, 100.0)
    np.testing.assert_allclose(a.loading, b.loading, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("law", [*LAWS, *REGULAR_LAWS])
def test_wear_laws(law: WearLaw) -> None:
    """Rise from 0 to 1 and never fall."""
    curve = wear_curve(law, np.random.default_rng(0))
    assert (curve[0], curve[-1]) == (0.0, 1.0)
    assert np.all(np.diff(curve) >= 0.0)


def test_a_drift_is_as_wide_as_it_says() -> None:
    """Find the spread that log T_i and log mu have drifted by at the horizon."""
    rng = np.random.default_rng(0)
    ends = [
        {group: path[-1] for group, path in drifts(0.07, 161, rng).items()} for _ in range(2000)
    ]
    # Two thousand draws know a standard deviation to 1.6 %.
    assert np.std([0.5 * end["preload"] for end in ends]) == pytest.approx(0.07, rel=0.06)
    assert np.std([0.14 * end["friction"] for end in ends]) == pytest.approx(0.07, rel=0.06)


def test_first_crossing() -> None:
    """Interpolate the first passage, and know never and from the start."""
    hours = np.array([0.0, 10.0, 20.0, 30.0])
    values = np.array([0.0, 1.0, 0.5, 4.0])
    assert first_crossing(hours, values, 0.25, "above") == pytest.approx(2.5)
    assert first_crossing(hours, values, 5.0, "above") is None
    assert first_crossing(hours, values, 0.1, "below") == 0.0
    assert first_crossing(hours, -values, -2.25, "below") == pytest.approx(25.0)


@pytest.mark.parametrize("law", LAWS)
def test_drive_folder(law: WearLaw, tmp_path: Path) -> None:
    """Write a folder whose limits are crossed at the hours that its truth states."""
    folder = tmp_path / "cell1-axis2"
    truth = write_drive(folder, np.random.default_rng(LAWS.index(law)), law=law, samples=150)
    settings = tomllib.loads((folder / "drive.toml").read_text(encoding="utf-8"))
    assert json.loads((folder / "truth.json").read_text(encoding="utf-8")) == truth
    rows = (folder / "tests.csv").read_text(encoding="utf-8").splitlines()
    tests = truth["tests"]
    limits = truth["limits"]
    assert isinstance(tests, list)
    assert isinstance(limits, list)
    assert 8 <= len(tests) == len(rows) - 1 <= 12
    assert all(row.count(",") == 8 for row in rows)
    for row in rows[1:]:
        assert (folder / row.split(",")[1]).exists()
    assert len(settings["limits"]) == len(limits) >= 1
    life = truth["life"]
    assert isinstance(life, dict)
    for declared, known in zip(settings["limits"], limits, strict=True):
        assert declared[known["direction"]] == known["limit"]
        assert 0.0 < known["crossing_hours"] <= settings["forecast"]["horizon_hours"]
        torque = known["at_torque_Nm"]
        name = known["quantity"] if torque is None else f"{known['quantity']}@{torque:g}Nm"
        at = np.interp(known["crossing_hours"], life["hours"], life["figures"][name])
        assert at == pytest.approx(known["limit"], rel=1e-9)
