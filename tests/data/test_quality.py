from __future__ import annotations

import numpy as np
import pytest

from hdprog.config import Drive, NoiseResolution
from hdprog.data.loop import Loop
from hdprog.data.quality import assess
from hdprog.data.usable import branch_coverage
from hdprog.errors import BadInputError
from tests.data.samples import PEAK, STIFFNESS, FloatArray, ramps, twist, two_sided


def noisy(torque: FloatArray, sd: float = 0.05) -> FloatArray:
    return torque + sd * np.random.default_rng(5).standard_normal(torque.size)


def warned(loop: Loop, drive: Drive | None = None) -> str:
    return " ".join(assess(loop, drive).warnings)


def test_the_facts_of_a_timed_two_sided_loop() -> None:
    torque, angle = two_sided()
    loop = Loop(
        torque, angle, time=0.1 * np.arange(torque.size), temperature=np.linspace(20, 25, 401)
    )
    quality = assess(loop)
    assert (quality.samples, quality.branches, quality.sides) == (401, 4, "two-sided")
    # 0 → 40 → -40 → 40 → 0: 240 Nm of travel, a cycle is 160 Nm.
    assert quality.cycles == pytest.approx(1.5)
    assert (quality.torque_min, quality.torque_max) == (-PEAK, PEAK)
    assert quality.angle_span == pytest.approx(np.ptp(angle))
    assert quality.secant_stiffness == pytest.approx(STIFFNESS, rel=0.02)
    assert quality.duration == pytest.approx(40.0)
    assert quality.loading_rates == pytest.approx((4.0, 8.0, 8.0, 4.0))
    assert (quality.temperature_min, quality.temperature_max) == (20.0, 25.0)
    assert quality.warnings == ()


def test_the_facts_of_an_untimed_one_sided_loop() -> None:
    torque = ramps(0, PEAK, 0, PEAK, 0)
    quality = assess(Loop(torque, twist(torque)))
    assert (quality.sides, quality.cycles) == ("one-sided", 2.0)
    assert quality.duration is None
    assert quality.loading_rates == ()
    assert quality.temperature_min is None


def test_resolution_and_noise_are_reported() -> None:
    torque, angle = two_sided()
    coarse = np.round(noisy(torque, 0.3) / 0.1) * 0.1
    quality = assess(Loop(coarse, angle))
    assert quality.torque_step == pytest.approx(0.1)
    # 401 samples: the estimate's sd is about 6 %.
    assert quality.torque_noise == pytest.approx(0.3, rel=0.3)
    assert quality.angle_step is None


@pytest.mark.parametrize(("torque_by", "angle_by"), [(1000, 1), (0.001, 1), (1, 1000), (1, 0.001)])
@pytest.mark.parametrize("rated", [None, 40.0])
def test_a_thousandfold_mistake_is_seen(
    torque_by: float, angle_by: float, rated: float | None
) -> None:
    torque, angle = two_sided()
    loop = Loop(torque_by * torque, angle_by * angle)
    drive = Drive(rated_torque=rated)
    assert "Check the units" in warned(loop, drive)
    assert "Check the units" not in warned(Loop(torque, angle), drive)


@pytest.mark.parametrize(
    ("peak", "stiffness"), [(4.0, 1.9e3), (30.0, 9e3), (300.0, 2e5), (9e3, 2e6)]
)
@pytest.mark.parametrize("share", [0.1, 1.0])
def test_an_angle_1000_times_off_is_seen_on_every_size_of_drive(
    peak: float, stiffness: float, share: float
) -> None:
    torque = ramps(0, share * peak, -share * peak, 0)
    angle = torque / stiffness - 0.01 * share * peak / stiffness * np.sign(np.gradient(torque))
    assert warned(Loop(torque, angle)) == ""
    assert "Check the units" in warned(Loop(torque, angle / 1000))
    if share == 1.0:
        assert "Check the units" in warned(Loop(torque, 1000 * angle))


@pytest.mark.parametrize(("torque_by", "seen"), [(1e-3, "stiffness"), (1e3, "largest torque is")])
def test_a_torque_1000_times_off_is_seen_on_a_soft_drive(torque_by: float, seen: str) -> None:
    torque = ramps(0, PEAK, -PEAK, 0)
    message = warned(Loop(torque_by * torque, torque / 9e3 - 2e-5 * np.sign(np.gradient(torque))))
    assert seen in message
    assert "from mNm or Nmm to Nm" in message


def test_plastic_gears_twist_by_degrees() -> None:
    torque = ramps(0, PEAK, -PEAK, 0)
    assert warned(Loop(torque, torque / 300 - 0.02 * np.sign(np.gradient(torque)))) == ""


@pytest.mark.parametrize("share", [0.04, 1.0, 3.0])
def test_tests_below_and_above_rated_torque_are_welcome(share: float) -> None:
    torque = ramps(0, PEAK, -PEAK, 0)
    assert warned(Loop(torque, twist(torque)), Drive(rated_torque=PEAK / share)) == ""


@pytest.mark.parametrize("ratio", [50, 80, 160])
def test_torque_of_the_input_is_too_small_for_the_drive(ratio: int) -> None:
    """A CSF-25-80's, 1/80 of rated torque, passed for a gentle test."""
    torque = ramps(0, PEAK, -PEAK, 0)
    message = warned(Loop(torque / ratio, twist(torque)), Drive(rated_torque=PEAK))
    assert f"{1 / ratio:.3g} times the drive's rated torque" in message
    assert "the motor's at the input" in message


def test_torque_that_clips_while_the_angle_goes_on() -> None:
    torque, angle = two_sided()
    message = warned(Loop(np.clip(torque, -33, 36), angle))
    assert "clip at its largest value, 36 Nm" in message
    assert "clip at its smallest value, -33 Nm" in message


def test_noisy_torque_that_clips() -> None:
    torque = ramps(0, PEAK, PEAK, -PEAK, 0)
    loop = Loop(np.minimum(noisy(torque, 0.2), PEAK - 1), twist(torque))
    assert "clip" in warned(loop)


def test_noise_may_come_in_behind_what_clips() -> None:
    torque, angle = two_sided()
    message = warned(Loop(noisy(np.clip(torque, -PEAK, 0.9 * PEAK), 0.05), noisy(angle, 2e-6)))
    assert "clip at its largest value" in message
    assert "clip at its smallest value" not in message
    assert warned(Loop(noisy(torque, 0.05), noisy(angle, 2e-6))) == ""


@pytest.mark.parametrize("sd", [0.0, 0.2])
def test_a_hold_does_not_clip(sd: float) -> None:
    torque = ramps(0, PEAK, PEAK, -PEAK, -PEAK, 0)
    creep = 5e-5 * np.clip(np.arange(torque.size) - 100, 0, 100) / 100
    loop = Loop(noisy(torque, sd), twist(torque) + creep)
    assert warned(loop) == ""


def test_coarse_torque_does_not_clip() -> None:
    torque, angle = two_sided()
    assert warned(Loop(np.round(torque), angle)) == ""


def test_a_coarse_sine_does_not_clip() -> None:
    torque = PEAK * np.sin(np.linspace(0, 4 * np.pi, 4000))
    assert warned(Loop(np.round(torque), twist(torque))) == ""


@pytest.mark.parametrize(
    ("declared", "seen"),
    [
        (NoiseResolution(0.1, 9.77e-6), ""),  # the torque, an even ramp, shows no noise
        (NoiseResolution(None, 9.77e-6 * 180 / np.pi), "angle resolution of 0.00056 rad"),
        (NoiseResolution(100.0, None), "torque resolution of 100 Nm"),
    ],
)
def test_a_declared_resolution_far_coarser_than_the_record(
    declared: NoiseResolution, seen: str
) -> None:
    torque = ramps(0, PEAK, -PEAK, PEAK, 0, samples=401)
    read = Loop(np.round(torque, 1), 9.77e-6 * np.round(twist(torque) / 9.77e-6))
    message = warned(read, Drive(noise=declared))
    assert seen in message
    assert bool(message) == bool(seen)


def test_an_encoder_that_begins_a_new_turn() -> None:
    torque, angle = two_sided()
    message = warned(Loop(torque, np.mod(angle, 2 * np.pi)))
    assert "new turn" in message
    assert "wrong sign" not in message


def test_an_output_that_passes_from_the_end_of_a_turn_to_the_next() -> None:
    torque, angle = two_sided()
    output = np.linspace(6.0, 6.8, torque.size)
    message = warned(Loop(torque, angle, output_angle=np.mod(output, 2 * np.pi)))
    assert "The output angle jumps by 6.28 rad" in message
    assert "leave it out with --columns output_angle=" in message
    assert warned(Loop(torque, angle, output_angle=output)) == ""


def test_gaps_in_time() -> None:
    torque, angle = two_sided()
    time = 0.1 * np.arange(torque.size)
    time[150:] += 5.0
    message = warned(Loop(torque, angle, time=time))
    assert "1 gap in time, the longest of 5.1 s after sample 150" in message


def test_gaps_without_time() -> None:
    torque, angle = two_sided()
    kept = np.r_[0:130, 165:401]
    message = warned(Loop(torque[kept], angle[kept]))
    assert "The torque jumps from" in message
    assert "after sample 130" in message


def test_runs_put_one_after_the_other_are_gaps() -> None:
    """Five jumps at most were told: eight runs passed for a sound record."""
    run = ramps(0, PEAK, -PEAK)
    torque = np.tile(run, 8)
    message = warned(Loop(torque, twist(torque)))
    assert "The torque jumps 7 times, first from -40 to 0 Nm after sample 201" in message


def test_torque_that_is_loaded_in_steps_has_no_gaps() -> None:
    held = np.repeat(ramps(0, PEAK, -PEAK, PEAK, 0, samples=6), 20)
    assert "jumps" not in warned(
        Loop(held, twist(ramps(0, PEAK, -PEAK, PEAK, 0, samples=106))[:420])
    )


def test_a_spike_is_no_gap() -> None:
    torque, angle = two_sided()
    torque[150] += 15
    assert warned(Loop(torque, angle)) == ""


def test_an_unloading_that_stops_early() -> None:
    torque = ramps(0, PEAK, 0.25 * PEAK)
    assert "unloading is much shorter" in warned(Loop(torque, twist(torque)))


@pytest.mark.parametrize(("end", "covered"), [(0, "0%"), (0.75, "75%")])
def test_a_side_that_is_loaded_in_part(end: float, covered: str) -> None:
    """The other side had its whole loading and unloading, and the read-off left the loss out."""
    torque = ramps(PEAK, -PEAK, end * PEAK)
    message = warned(Loop(torque, twist(torque)))
    assert (
        f"loading on the positive side is much shorter than the other branch: it covers {covered}"
        in message
    )
    whole = ramps(PEAK, -PEAK, 0.95 * PEAK)
    assert warned(Loop(whole, twist(whole))) == ""


def test_branches_of_unequal_length() -> None:
    torque = np.concatenate([ramps(0, PEAK, samples=200), ramps(PEAK, 0, samples=20)[1:]])
    assert "falling torque have 19 samples" in warned(Loop(torque, twist(torque)))


def test_sides_of_unequal_size() -> None:
    torque = ramps(0, PEAK, -0.3 * PEAK, 0)
    assert "one side is much shorter" in warned(Loop(torque, twist(torque)))


def test_a_sign_that_is_turned_round() -> None:
    torque, angle = two_sided()
    with pytest.raises(BadInputError, match="falls while the torque rises"):
        assess(Loop(torque, -angle))
    # Where noise leaves little of the slope it is for a second look.
    noise = angle.std() * np.random.default_rng(1).standard_normal(torque.size)
    assert "wrong sign" in warned(Loop(torque, -angle + 1.5 * noise))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", range(6))
def test_an_angle_of_noise_alone_is_told(seed: int) -> None:
    """A dead encoder made a usable record, of a stiff drive or one with a wrong sign.

    Correlations of 401 pairs of noise have a standard deviation of 0.05: 0.3 is never reached.
    """
    torque, angle = two_sided()
    noise = np.random.default_rng(seed).standard_normal(torque.size)
    found = warned(Loop(torque, 1e-3 * noise))
    assert "The angle hardly goes with the torque (correlation " in found
    assert "wrong sign" not in found
    assert warned(Loop(torque, angle + 1e-3 * noise)) == ""


@pytest.mark.parametrize("by", [1e-300, 1e160, 1e308 / PEAK])
def test_numbers_that_nothing_can_be_computed_from_are_refused(by: float) -> None:
    torque, angle = two_sided()
    with pytest.raises(BadInputError, match="expected torque that a drive can have"):
        assess(Loop(torque * by, angle))
    with pytest.raises(BadInputError, match="expected angle that a drive can have"):
        assess(Loop(torque, angle / np.abs(angle).max() * (by * PEAK)))


def test_a_temperature_below_absolute_zero_is_refused() -> None:
    torque, angle = two_sided()
    temperature = np.full(torque.size, 21.0)
    temperature[7] = -300.0
    with pytest.raises(BadInputError, match="-300 °C; expected no temperature below"):
        assess(Loop(torque, angle, temperature=temperature))


def test_minor_loops_do_not_interrupt_a_branch() -> None:
    assert branch_coverage(np.array([0.0, 20, 15, 40, 30, 35, 0])) == (1.0, 1.0)
    assert branch_coverage(np.array([0.0, 40])) == (1.0, 0.0)
    assert branch_coverage(np.array([-40.0, 40])) in {(1.0, 0.0), (0.0, 1.0)}


@pytest.mark.parametrize("turns", [(0, PEAK, -PEAK, PEAK, 0), (0, PEAK, 0, PEAK, 0)])
def test_a_loop_that_gives_back_more_work_than_it_takes(turns: tuple[float, ...]) -> None:
    torque = ramps(*turns)
    angle = twist(torque)
    assert "backwards" not in warned(Loop(torque, angle))
    assert "backwards" in warned(Loop(torque[::-1], angle[::-1]))
    late = np.concatenate([np.full(8, angle[0]), angle[:-8]])
    assert "backwards" not in warned(Loop(torque, late))
    filtered = np.concatenate([np.full(8, torque[0]), torque[:-8]])
    assert "backwards" in warned(Loop(filtered, angle))


@pytest.mark.parametrize("seed", range(5))
def test_a_line_with_noise_runs_neither_way(seed: int) -> None:
    rng = np.random.default_rng(seed)
    torque = ramps(0, PEAK, -PEAK, 0)
    span = 2 * PEAK / 9e3
    angle = torque / 9e3 + 0.02 * span * rng.standard_normal(torque.size)
    assert "backwards" not in warned(Loop(torque, angle))


def test_an_encoder_that_stands_still_or_is_at_its_end() -> None:
    torque, angle = two_sided()
    dead = np.where(np.arange(angle.size) < angle.size // 2, angle, angle[angle.size // 2])
    assert "stand still" in warned(Loop(torque, dead))
    assert "stand still" in warned(Loop(torque, np.minimum(angle, 0.7 * angle.max())))
    coarse = 5e-5 * np.round(angle / 5e-5)
    assert "stand still" not in warned(Loop(torque, coarse))
    hold = ramps(0, PEAK, PEAK, -PEAK, -PEAK, 0)
    assert "stand still" not in warned(Loop(hold, twist(hold)))


def test_a_noisy_encoder_at_its_end_is_told_by_a_few_readings() -> None:
    """Taken for a damaged tooth at the largest torque, where not even a tenth is cut off."""
    torque, angle = two_sided()
    seen = noisy(angle, 6e-6)
    message = warned(Loop(noisy(torque, 0.04), np.minimum(seen, 0.95 * angle.max())))
    assert "stand still or to be at its end" in message
    assert warned(Loop(noisy(torque, 0.04), seen)) == ""


def test_degrees_for_radians_in_a_declared_resolution() -> None:
    torque = ramps(0, PEAK, -PEAK, PEAK, 0, samples=401)
    angle = noisy(twist(torque), 1e-5)
    read = Loop(torque, 9.77e-6 * np.round(angle / 9.77e-6))
    assert "far coarser" in warned(read, Drive(noise=NoiseResolution(None, 9.77e-6 * 57.3)))
    assert "far coarser" not in warned(read, Drive(noise=NoiseResolution(None, 1e-4)))
