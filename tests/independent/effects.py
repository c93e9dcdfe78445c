"""Deviations from the base model, in shapes that the package under test does not use.

Every effect is a function of what truly happened (`simulator.Trace`) that returns a
`Contribution` of arbitrary scale. `apply_effects` scales it: the *size* of an effect is the
root-mean-square change of the angle-against-torque record [rad] that it makes, its mean taken
out, because the angle zero of an encoder is free. Effects on the torque reading are converted by
the local compliance of the loop.

``EFFECTS`` holds them by name; several names can share one identifier of the physics page (two
kinds of creep), and those that no list contains carry the identifier ``unknown``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from .simulator import FloatArray, IntArray, Trace

Need = Literal["two-sided", "several rates", "time", "reversal"]


@dataclass(frozen=True)
class Contribution:
    """What an effect adds on the internal path, to no particular scale.

    Attributes
    ----------
    shape
        shape (m,).
    settings
        Constants drawn for it.
    temperature, output_angle
        shape (m,), where the effect follows a quantity that a rig would record [°C], [rad].
    """

    shape: FloatArray
    settings: dict[str, float] = field(default_factory=dict)
    temperature: FloatArray | None = None
    output_angle: FloatArray | None = None


EffectFunction = Callable[[Trace, np.random.Generator], Contribution]


@dataclass(frozen=True)
class Effect:
    """An effect and how it is to be recognised.

    Attributes
    ----------
    name
        Name in this module.
    identifier
        Identifier on the physics page, or ``unknown``.
    function
        Its shape.
    acts_on
        ``angle``, or ``torque`` where only the torque reading is wrong.
    needs
        What the record must have for the effect to show.
    """

    name: str
    identifier: str
    function: EffectFunction
    acts_on: Literal["angle", "torque"] = "angle"
    needs: tuple[Need, ...] = ()


@dataclass(frozen=True)
class EffectedTrace:
    """A trace with effects.

    Attributes
    ----------
    angle, torque
        shape (m,), torsion angle and torque as ideal sensors would show them [rad], [Nm].
    temperature, output_angle
        shape (m,) or None.
    truth
        One entry an effect: name, identifier, size, amplitude and settings.
    """

    angle: FloatArray
    torque: FloatArray
    temperature: FloatArray | None
    output_angle: FloatArray | None
    truth: list[dict[str, object]]


# ------------------------------------------------------------------------------- helpers


def _span(trace: Trace) -> float:
    """Return the largest torque [Nm]."""
    return float(np.max(np.abs(trace.torque)))


def _relative_time(trace: Trace) -> FloatArray:
    """Return time in units of the record's duration, zero where recording starts."""
    begin = trace.time[trace.recorded[0]]
    relative = (trace.time - begin) / (trace.time[trace.recorded[-1]] - begin)
    return np.asarray(relative, dtype=np.float64)


def _direction(trace: Trace) -> IntArray:
    """Return the direction of torque, a hold keeping the one before it; shape (m,), +-1."""
    sign = np.sign(trace.rate).astype(np.int64)
    index = np.where(sign != 0, np.arange(sign.size), 0)
    kept: IntArray = sign[np.maximum.accumulate(index)]
    kept[kept == 0] = 1
    return kept


def _stretches(trace: Trace) -> list[tuple[int, int]]:
    """Return first and last index of every stretch between reversals; neighbours share one."""
    turns = np.flatnonzero(np.diff(_direction(trace))) + 1
    edges = [0, *turns.tolist(), trace.torque.size - 1]
    return [(a, b) for a, b in itertools.pairwise(edges) if b > a]


def _stretch_starts(trace: Trace) -> IntArray:
    """Return, for every internal step, the index of the reversal before it."""
    starts = np.zeros(trace.torque.size, dtype=np.int64)
    for first, last in _stretches(trace):
        starts[first : last + 1] = first
    return starts


def _elastic_slip(trace: Trace, limits: FloatArray) -> FloatArray:
    """Return deflections of Jenkins elements, -1 to 1 of their limits; shape (m, k).

    On a stretch of monotone torque an element is carried along until it reaches its limit, and
    then stays there.
    """
    torque = trace.torque
    deflection = np.zeros((torque.size, limits.size))
    state = np.zeros(limits.size)
    for first, last in _stretches(trace):
        travel = torque[first : last + 1] - torque[first]
        moved = state + travel[:, None] / limits
        deflection[first : last + 1] = np.clip(moved, -1.0, 1.0)
        state = deflection[last]
    return deflection


def _relaxation(trace: Trace, drive: FloatArray, constant: float) -> FloatArray:
    """Integrate dx/dt = (drive - x)/constant from rest, by exact exponential steps."""
    decay = np.exp(-np.diff(trace.time) / constant)
    middle = 0.5 * (drive[1:] + drive[:-1])
    x, out = 0.0, [0.0]
    for keep, target in zip(decay.tolist(), middle.tolist(), strict=True):
        x = keep * x + (1.0 - keep) * target
        out.append(x)
    return np.array(out)


def _triangle_wave(phase: FloatArray) -> FloatArray:
    """Return a triangle wave of period 1 between -1 and 1."""
    wave = 4.0 * np.abs(phase - np.floor(phase + 0.5)) - 1.0
    return np.asarray(wave, dtype=np.float64)


def _smooth_step(x: FloatArray) -> FloatArray:
    """Return the cubic that rises from 0 to 1 over 0 < x < 1."""
    u = np.clip(x, 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)


# ------------------------------------------------------------- effects of the physics page


def torque_offset(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Zero error of the torque sensor that settles by a tenth while the amplifier warms up."""
    sign = float(rng.choice((-1.0, 1.0)))
    settled = 0.9 + 0.1 * np.exp(-3.0 * np.maximum(_relative_time(trace), 0.0))
    return Contribution(sign * settled, {"sign": sign})


def backlash(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Play as a smooth cubic dead zone: flat slopes outside, (3u - u^3)/2 within.

    A wide zone looks like a soft tooth mesh, and the base model swallows it; so it is narrow.
    """
    width = float(rng.uniform(0.006, 0.02)) * _span(trace)
    u = np.clip(trace.torque / width, -1.0, 1.0)
    return Contribution(0.5 * (3.0 * u - u**3), {"half_width_Nm": width})


def asymmetry(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Turn softer (or stiffer) and wider on the negative side, fading in below zero torque."""
    sign = float(rng.choice((-1.0, 1.0)))
    fade = float(rng.uniform(0.03, 0.08)) * _span(trace)
    weight = _smooth_step(-trace.torque / fade)
    return Contribution(sign * weight * trace.angle, {"sign": sign, "fade_Nm": fade})


def cup_hardening(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Let compliance fall or rise with load as |T|^1.5, the angle as |T|^2.5."""
    sign = float(rng.choice((-1.0, 1.0)))
    x = trace.torque / _span(trace)
    return Contribution(sign * np.sign(x) * np.abs(x) ** 2.5, {"sign": sign})


def coulomb_friction(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Widen the loop evenly: one Jenkins element that slips soon after every reversal."""
    limit = float(rng.uniform(0.008, 0.02)) * _span(trace)
    return Contribution(-_elastic_slip(trace, np.array([limit]))[:, 0], {"limit_Nm": limit})


def microslip(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Round the corners: thirty Jenkins elements with lognormal slip limits."""
    median = float(rng.uniform(0.06, 0.2)) * _span(trace)
    spread = float(rng.uniform(0.5, 0.9))
    limits = median * np.exp(spread * rng.standard_normal(30))
    weights = limits / limits.sum()
    shape = -_elastic_slip(trace, limits) @ weights
    return Contribution(shape, {"median_Nm": median, "log_spread": spread})


def viscous_friction(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Let width grow with a power of the loading rate."""
    power = float(rng.uniform(0.5, 0.8))
    quickest = float(np.max(np.abs(trace.rate)))
    speed = np.abs(trace.rate) / quickest
    lagged = -_direction(trace) * speed**power
    memory = 0.004 * float(trace.time[-1] - trace.time[0])
    return Contribution(_relaxation(trace, lagged, memory), {"power": power})


def stribeck_friction(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Let extra width fall with the loading rate, as a hyperbola."""
    speed = np.abs(trace.rate[trace.recorded[0] :])
    moving = speed[speed > 1e-9]
    knee = float(rng.uniform(0.6, 1.5)) * float(np.quantile(moving, 0.2))
    width = 1.0 / (1.0 + np.abs(trace.rate) / knee)
    limit = 0.01 * _span(trace)
    carried = _elastic_slip(trace, np.array([limit]))[:, 0]
    return Contribution(-width * carried, {"knee_Nm_per_s": knee})


def creep(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Creep under load and recover, with a quick and a slow time constant."""
    length = float(trace.time[trace.recorded[-1]])
    quick = float(rng.uniform(0.015, 0.04)) * length
    slow = quick * float(rng.uniform(6.0, 15.0))
    share = float(rng.uniform(0.35, 0.65))
    x = trace.torque / _span(trace)
    shape = share * _relaxation(trace, x, quick) + (1.0 - share) * _relaxation(trace, x, slow)
    return Contribution(shape, {"quick_s": quick, "slow_s": slow, "quick_share": share})


def creep_logarithmic(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Creep with the logarithm of time under load, by superposition of torque increments."""
    length = float(trace.time[trace.recorded[-1]])
    scale = float(rng.uniform(0.004, 0.02)) * length
    knots = np.unique(np.linspace(0, trace.time.size - 1, 360).astype(int))
    time, torque = trace.time[knots], trace.torque[knots] / _span(trace)
    born = 0.5 * (time[1:] + time[:-1])
    age = np.maximum(time[:, None] - born[None, :], 0.0)
    coarse = np.log1p(age / scale) @ np.diff(torque)
    return Contribution(np.interp(trace.time, time, coarse), {"scale_s": scale})


def _heat_up(
    trace: Trace, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, dict[str, float]]:
    """Return a first-order heat-up, 0 to about 1, the temperature it means and its constants."""
    constant = float(rng.uniform(0.25, 0.8))
    rise = float(rng.uniform(4.0, 15.0))
    ambient = float(rng.uniform(18.0, 26.0))
    warm = 1.0 - np.exp(-np.maximum(_relative_time(trace), 0.0) / constant)
    settings = {"time_constant_of_record": constant, "rise_C": rise, "ambient_C": ambient}
    return warm, ambient + rise * warm, settings


def thermal_drift(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Drift of the angle as the rig heats up like a first-order system."""
    sign = float(rng.choice((-1.0, 1.0)))
    warm, temperature, settings = _heat_up(trace, rng)
    return Contribution(sign * warm, {"sign": sign, **settings}, temperature=temperature)


def thermal_softening(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Soften the drive as it heats up like a first-order system."""
    warm, temperature, settings = _heat_up(trace, rng)
    shape = warm * trace.torque / _span(trace)
    return Contribution(shape, settings, temperature=temperature)


def kinematic_error(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Transmission error as a triangle wave and a weaker sine of the output's position.

    The rig lets the output creep round during the record, and writes its position down.
    """
    sweep = float(rng.uniform(0.15, 0.4)) * float(rng.choice((-1.0, 1.0)))
    start = float(rng.uniform(0.0, 2.0 * math.pi))
    lines = float(rng.choice((160.0, 80.0, 162.0))) * float(rng.uniform(0.98, 1.02))
    output = start + sweep * _relative_time(trace) + trace.angle
    turns = output / (2.0 * math.pi)
    phases = rng.random(2)
    shape = _triangle_wave(lines * turns + phases[0])
    shape = shape + 0.4 * np.sin(2.0 * math.pi * (2.13 * lines * turns + phases[1]))
    settings = {"lines_per_turn": lines, "sweep_rad": sweep, "start_rad": start}
    return Contribution(shape, settings, output_angle=output)


def angle_ripple(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Interpolation error of the encoder, two harmonics of the torsion angle."""
    period = float(np.ptp(trace.angle)) / float(rng.uniform(4.0, 12.0))
    phases = rng.random(2)
    turns = trace.angle / period
    shape = np.sin(2.0 * math.pi * (turns + phases[0]))
    shape += 0.45 * np.sin(2.0 * math.pi * (2.0 * turns + phases[1]))
    return Contribution(shape, {"period_rad": period})


def torque_sensor_hysteresis(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Lag of the torque reading by elastic slip that approaches its limit exponentially.

    After a reversal the lag turns over within a length set by the swing of torque, so that a
    small swing leaves a small lag.
    """
    length = float(rng.uniform(0.3, 0.8)) * _span(trace)
    torque = trace.torque
    lag = np.zeros_like(torque)
    for first, last in _stretches(trace):
        travel = torque[first : last + 1] - torque[first]
        end = float(np.sign(travel[-1]))
        lag[first : last + 1] = end - (end - lag[first]) * np.exp(-np.abs(travel) / length)
    return Contribution(-lag, {"length_Nm": length})


def tooth_damage(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Place a triangular bump at one torque, on both branches."""
    span = _span(trace)
    low = max(-span, float(trace.torque.min()))
    side = -1.0 if low < -0.5 * span and rng.random() < 0.5 else 1.0
    centre = side * float(rng.uniform(0.3, 0.75)) * span
    half = float(rng.uniform(0.05, 0.11)) * span
    shape = np.maximum(1.0 - np.abs(trace.torque - centre) / half, 0.0)
    return Contribution(shape, {"centre_Nm": centre, "half_width_Nm": half})


def slip_jump(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Shift the angle for good, along a short straight ramp in time."""
    when = float(rng.uniform(0.2, 0.8))
    lasts = float(rng.uniform(0.004, 0.015))
    sign = float(rng.choice((-1.0, 1.0)))
    shape = sign * np.clip((_relative_time(trace) - when) / lasts, 0.0, 1.0)
    return Contribution(shape, {"sign": sign, "when_of_record": when, "lasts_of_record": lasts})


# ----------------------------------------------------------------- effects that no list has


def reversal_ringing(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Oscillate in time after every reversal, like a resonance that dies away."""
    stretches = _stretches(trace)
    typical = float(np.median([trace.time[b] - trace.time[a] for a, b in stretches]))
    period = typical * float(rng.uniform(0.12, 0.25))
    decay = period * float(rng.uniform(1.2, 2.5))
    starts = _stretch_starts(trace)
    age = trace.time - trace.time[starts]
    swing = np.sin(2.0 * math.pi * age / period) * np.exp(-age / decay)
    shape = swing * _direction(trace).astype(np.float64)
    return Contribution(shape, {"period_s": period, "decay_s": decay})


def branch_dead_band(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Hold the angle back in the middle of the rising branch, then let it catch up at once."""
    span = _span(trace)
    centre = float(rng.uniform(0.35, 0.6)) * span
    half = float(rng.uniform(0.1, 0.18)) * span
    u = (trace.torque - centre) / half
    behind = np.where(u < 0.7, (u + 1.0) / 1.7, (1.0 - u) / 0.3)
    shape = np.clip(-behind, -1.0, 0.0) * (_direction(trace) > 0).astype(float)
    return Contribution(shape, {"centre_Nm": centre, "half_width_Nm": half})


def stiffness_dip(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Make the drive soft around one torque on both sides: a smooth rise of the angle there."""
    span = _span(trace)
    centre = float(rng.uniform(0.35, 0.65)) * span
    width = float(rng.uniform(0.03, 0.08)) * span
    size = np.abs(trace.torque)
    shape = np.sign(trace.torque) * 0.5 * (1.0 + np.tanh((size - centre) / width))
    return Contribution(shape, {"centre_Nm": centre, "width_Nm": width})


def torque_chirp(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Ripple in torque whose pitch rises with torque squared."""
    x = trace.torque / _span(trace)
    cycles = float(rng.uniform(3.0, 6.0))
    phase = float(rng.random())
    shape = (
        np.sign(x)
        * np.sin(2.0 * math.pi * (cycles * x * x + phase))
        * _smooth_step(np.abs(x) / 0.1)
    )
    return Contribution(shape, {"cycles": cycles})


def stick_slip_teeth(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Saw teeth on the falling branch only: the angle sticks and lets go again and again."""
    pitch = float(rng.uniform(0.12, 0.25)) * _span(trace)
    turns = trace.torque / pitch
    shape = np.where(_direction(trace) < 0, np.ceil(turns) - turns - 0.5, 0.0).astype(float)
    return Contribution(shape, {"pitch_Nm": pitch})


def swelling_hum(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Vibrate slowly in time with a swelling and fading amplitude, whatever the torque does."""
    cycles = float(rng.uniform(9.0, 17.0))
    when = float(rng.uniform(0.3, 0.7))
    time = _relative_time(trace)
    envelope = np.exp(-0.5 * ((time - when) / 0.18) ** 2)
    shape = np.sin(2.0 * math.pi * (cycles * time + rng.random())) * envelope
    return Contribution(shape, {"cycles_of_record": cycles, "when_of_record": when})


def crossed_branches(trace: Trace, rng: np.random.Generator) -> Contribution:
    """Pinch the loop at high torque and widen it in the middle, by an even wave of torque."""
    x = trace.torque / _span(trace)
    waves = float(rng.uniform(1.3, 2.2))
    shape = -_direction(trace) * np.sin(math.pi * waves * np.abs(x)) * (1.0 - x * x)
    return Contribution(shape, {"waves": waves})


EFFECTS: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        Effect("torque_offset", "torque_offset", torque_offset, "torque", ("two-sided",)),
        Effect("backlash", "backlash", backlash, needs=("two-sided",)),
        Effect("asymmetry", "asymmetry", asymmetry, needs=("two-sided",)),
        Effect("cup_hardening", "cup_hardening", cup_hardening),
        Effect("coulomb_friction", "coulomb_friction", coulomb_friction, needs=("reversal",)),
        Effect("microslip", "microslip", microslip, needs=("reversal",)),
        Effect(
            "viscous_friction",
            "viscous_friction",
            viscous_friction,
            needs=("time", "several rates"),
        ),
        Effect(
            "stribeck_friction",
            "stribeck_friction",
            stribeck_friction,
            needs=("time", "several rates"),
        ),
        Effect("creep", "creep", creep, needs=("time",)),
        Effect("creep_logarithmic", "creep", creep_logarithmic, needs=("time",)),
        Effect("thermal_drift", "thermal_drift", thermal_drift, needs=("time",)),
        Effect("thermal_softening", "thermal_drift", thermal_softening, needs=("time",)),
        Effect("kinematic_error", "kinematic_error", kinematic_error),
        Effect("angle_ripple", "angle_ripple", angle_ripple),
        Effect(
            "torque_sensor_hysteresis",
            "torque_sensor_hysteresis",
            torque_sensor_hysteresis,
            "torque",
            ("reversal",),
        ),
        Effect("tooth_damage", "tooth_damage", tooth_damage),
        Effect("slip_jump", "slip_jump", slip_jump),
        Effect("reversal_ringing", "unknown", reversal_ringing, needs=("time", "reversal")),
        Effect("branch_dead_band", "unknown", branch_dead_band),
        Effect("stiffness_dip", "unknown", stiffness_dip),
        Effect("torque_chirp", "unknown", torque_chirp),
        Effect("stick_slip_teeth", "unknown", stick_slip_teeth),
        Effect("swelling_hum", "unknown", swelling_hum, needs=("time",)),
        Effect("crossed_branches", "unknown", crossed_branches),
    )
}


def apply_effects(
    trace: Trace, sizes: Mapping[str, float], rng: np.random.Generator
) -> EffectedTrace:
    """Add effects to a trace.

    Parameters
    ----------
    trace
        What the base model gives.
    sizes
        By name in ``EFFECTS``, the root-mean-square change [rad]; see the head of this module.
    rng
        Source of the effects' constants.

    Raises
    ------
    ValueError
        If the record cannot carry an effect at all: one-sided for a two-sided one, say.
    """
    angle, torque = trace.angle.copy(), trace.torque.copy()
    temperature: FloatArray | None = None
    output_angle: FloatArray | None = None
    truth: list[dict[str, object]] = []
    seen = trace.recorded
    compliance = np.gradient(trace.angle[seen], np.arange(seen.size)) / _off_zero(
        np.gradient(trace.torque[seen], np.arange(seen.size))
    )
    middle = float(np.median(compliance))
    compliance = np.clip(compliance, 0.3 * middle, 6.0 * middle)
    for name, size in sizes.items():
        effect = EFFECTS[name]
        if "two-sided" in effect.needs and trace.torque[seen].min() > -0.2 * _span(trace):
            raise ValueError(f"{name} needs a record with torque of both signs")
        part = effect.function(trace, rng)
        change = part.shape[seen] * (compliance if effect.acts_on == "torque" else 1.0)
        # A constant torque error still shows, because the loop is symmetric about zero torque.
        scatter = float(np.std(change))
        if name == "torque_offset":
            scatter = float(np.sqrt(np.mean(change**2)))
        if scatter <= 0.0:
            raise ValueError(f"{name} leaves no mark on this record")
        amplitude = size / scatter
        if effect.acts_on == "torque":
            torque += amplitude * part.shape
        else:
            angle += amplitude * part.shape
        if part.temperature is not None:
            temperature = part.temperature
        if part.output_angle is not None:
            output_angle = part.output_angle
        truth.append(
            {
                "name": name,
                "identifier": effect.identifier,
                "size_rad": float(size),
                "acts_on": effect.acts_on,
                "amplitude": amplitude,
                "peak_to_peak": amplitude * float(np.ptp(part.shape[seen])),
                "settings": part.settings,
            }
        )
    return EffectedTrace(angle, torque, temperature, output_angle, truth)


def _off_zero(values: FloatArray) -> FloatArray:
    """Replace differences too small to divide by."""
    return np.where(np.abs(values) < 1e-6, 1e-6, values)
