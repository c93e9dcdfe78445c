"""Random hysteresis loops with known truth, as a rig would record them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from .effects import EFFECTS, apply_effects
from .simulator import (
    INITIAL,
    POST_TEST,
    DriveParameters,
    FloatArray,
    MeasurementChain,
    Segment,
    SegmentShape,
    TorquePath,
    Trace,
    is_physical,
    make_path,
    measure,
    simulate,
)

LoopKind = Literal["one-sided", "two-sided", "multi-rate", "multi-cycle", "minor-loops"]
History = Literal["at rest", "preconditioned", "unknown"]
KINDS: tuple[LoopKind, ...] = get_args(LoopKind)


@dataclass(frozen=True)
class LoopRecord:
    """A recorded loop and the truth behind it.

    Attributes
    ----------
    torque, angle, time
        shape (n,), what the sensors showed [Nm], [rad], [s].
    true_torque, true_angle
        shape (n,), what an ideal rig would have shown: with effects on the angle, without noise,
        without errors of the torque reading and without angle zero.
    base_angle
        shape (n,), what the base model alone gives.
    temperature, output_angle
        shape (n,) or None, further columns [°C], [rad].
    truth
        Parameters, effects, noise and history; ready for JSON.
    """

    torque: FloatArray
    angle: FloatArray
    time: FloatArray
    true_torque: FloatArray
    true_angle: FloatArray
    base_angle: FloatArray
    temperature: FloatArray | None
    output_angle: FloatArray | None
    truth: dict[str, object]


# ------------------------------------------------------------------------------- parameters


def worn_parameters(
    teeth: float, preload: float | None = None, friction: float | None = None
) -> DriveParameters:
    """Return parameters on the way from Table 2's initial state (0) to its last (1) and beyond.

    Parameters
    ----------
    teeth
        Wear of the tooth mesh: T_T grows in proportion; b and the stiffness in full mesh change
        by equal ratios for equal wear, and ``a`` follows from the three. Also K_W.
    preload, friction
        Wear that T_i and c, and mu have seen; as ``teeth`` where not given.
    """
    preload = teeth if preload is None else preload
    friction = teeth if friction is None else friction
    threshold = max(POST_TEST.T_T * teeth, 0.02)
    full_mesh = INITIAL.b * ((POST_TEST.a * POST_TEST.T_T + POST_TEST.b) / INITIAL.b) ** teeth
    first_pair = INITIAL.b * (POST_TEST.b / INITIAL.b) ** teeth
    return DriveParameters(
        K_F=POST_TEST.K_F,
        K_W=INITIAL.K_W * (POST_TEST.K_W / INITIAL.K_W) ** teeth,
        a=max(full_mesh - first_pair, 0.0) / threshold,
        b=first_pair,
        T_T=threshold,
        c=INITIAL.c * (POST_TEST.c / INITIAL.c) ** preload,
        T_i=INITIAL.T_i * (POST_TEST.T_i / INITIAL.T_i) ** preload,
        mu=INITIAL.mu * (POST_TEST.mu / INITIAL.mu) ** friction,
    )


def scatter(
    parameters: DriveParameters, spread: Mapping[str, float], rng: np.random.Generator
) -> DriveParameters:
    """Multiply parameters by lognormal factors of the given standard deviations."""
    values = parameters.as_dict()
    factors = {
        name: values[name] * math.exp(sd * rng.standard_normal()) for name, sd in spread.items()
    }
    return replace(parameters, **factors)


def random_parameters(
    rng: np.random.Generator, alpha_deg: float = 30.0
) -> tuple[DriveParameters, float]:
    """Draw parameters widely around, between and beyond both states of Table 2.

    Every fourth draw has a T_T below 1.5 Nm, where a, b and T_T mean nothing apart.

    Returns
    -------
    parameters, torque_max
        ``torque_max`` [Nm] lies below T_i in two draws of five, else above it, and always well
        past the torque where the loading branch leaves stiction.
    """
    while True:
        drawn = worn_parameters(
            float(rng.uniform(0.0, 1.25)),
            float(rng.uniform(-0.1, 1.3)),
            float(rng.uniform(-0.5, 1.5)),
        )
        drawn = scatter(
            drawn,
            {"K_F": 0.3, "K_W": 0.3, "a": 0.4, "b": 0.3, "c": 0.06, "T_i": 0.2, "mu": 0.25},
            rng,
        )
        if rng.random() < 0.25:
            drawn = replace(drawn, T_T=float(rng.uniform(0.02, 1.5)))
        else:
            drawn = replace(drawn, T_T=min(drawn.T_T * math.exp(0.2 * rng.standard_normal()), 40.0))
        below = rng.random() < 0.4
        ratio = float(rng.uniform(0.5, 0.95) if below else rng.uniform(1.08, 1.7))
        torque_max = drawn.T_i * ratio
        alpha = math.radians(alpha_deg)
        grip = math.sin(alpha) - drawn.mu * math.cos(alpha)
        stick_end = -drawn.mu * drawn.c * drawn.T_i / (grip - drawn.mu * drawn.c)
        usable = is_physical(drawn, alpha_deg) and 0.02 < drawn.mu < 0.2
        if usable and 25.0 < torque_max < 180.0 and torque_max > 2.0 * stick_end:
            return drawn, torque_max


# ---------------------------------------------------------------------------- torque programmes


def _shape(rng: np.random.Generator) -> SegmentShape:
    """Draw how torque moves."""
    shapes: tuple[SegmentShape, ...] = ("ramp", "sine", "irregular")
    return shapes[int(rng.choice(3, p=(0.5, 0.25, 0.25)))]


def programme(
    kind: LoopKind,
    torque_max: float,
    ramp_time: float,
    rng: np.random.Generator,
    *,
    history: History = "preconditioned",
    holds: bool = False,
) -> list[Segment]:
    """Write a torque programme.

    Parameters
    ----------
    kind
        ``one-sided`` 0, T_max, 0; ``two-sided`` one cycle after the first loading; ``multi-rate``
        three cycles at rates in the ratio 1 : 4 : 14; ``multi-cycle`` three to five equal cycles
        of either sort; ``minor-loops`` a full cycle with smaller ones nested in it.
    torque_max
        Largest torque [Nm].
    ramp_time
        Time from zero to T_max [s].
    history
        What went before the first sample: nothing (``at rest``), two full cycles
        (``preconditioned``) or a random sequence of reversals (``unknown``).
    holds
        Whether torque rests for half a ramp time at the ends (a trapezoid).
    """
    shape = _shape(rng)
    segments: list[Segment] = []
    at = 0.0

    def go(target: float, speed: float = 1.0, *, recorded: bool = True) -> None:
        nonlocal at
        distance = abs(target - at) / torque_max
        if distance > 0.0:
            duration = max(distance, 0.02) * ramp_time / speed
            segments.append(Segment(target, duration, shape, recorded))
        at = target
        if holds and recorded and target != 0.0 and abs(target) >= 0.999 * torque_max:
            segments.append(Segment(target, 0.5 * ramp_time, "hold"))

    one_sided = kind == "one-sided" or (kind == "multi-cycle" and rng.random() < 0.4)
    low = 0.0 if one_sided else -torque_max
    if history == "preconditioned":
        for target in (torque_max, low, torque_max, low, 0.0):
            go(target, recorded=False)
    elif history == "unknown":
        for _ in range(int(rng.integers(2, 5))):
            go(float(rng.uniform(low, torque_max)), recorded=False)
        go(0.0, recorded=False)

    if kind == "one-sided":
        for _ in range(int(rng.integers(1, 3))):
            go(torque_max)
            go(0.0)
    elif kind == "two-sided":
        for target in (torque_max, -torque_max, torque_max):
            go(target)
        if rng.random() < 0.5:
            go(0.0)
    elif kind == "multi-rate":
        speeds = np.array([1.0, 4.0, 14.0])
        for speed in speeds[rng.permutation(3)]:
            for target in (torque_max, -torque_max, 0.0):
                go(target, float(speed))
    elif kind == "multi-cycle":
        for _ in range(int(rng.integers(3, 6))):
            go(torque_max)
            go(low)
        go(0.0)
    else:
        inner = float(rng.uniform(0.3, 0.5)) * torque_max
        outer = float(rng.uniform(0.65, 0.85)) * torque_max
        for target in (outer, inner, torque_max, inner, outer, -torque_max):
            go(target)
        for target in (-inner, -outer, 0.5 * inner, -0.3 * inner, torque_max, 0.0):
            go(target)
    return segments


# -------------------------------------------------------------------------------- recording


def record_loop(
    parameters: DriveParameters,
    segments: list[Segment],
    samples: int,
    rng: np.random.Generator,
    *,
    alpha_deg: float = 30.0,
    chain: MeasurementChain | None = None,
    effects: Mapping[str, float] | None = None,
    negative: DriveParameters | None = None,
    initial_slip: float = 0.0,
    absorption: bool = False,
) -> LoopRecord:
    """Simulate a torque programme and record it.

    Parameters
    ----------
    parameters
        Of the base model, for positive torque only where ``negative`` is given.
    segments
        Torque programme, from zero torque.
    samples
        Number of recorded samples n.
    rng
        Source of everything random.
    chain
        Sensors; those of the paper's rig where not given.
    effects
        Size [rad] by name in ``effects.EFFECTS``.
    initial_slip
        Deflection y of the wave generator before the first segment [rad].
    absorption
        Whether ``truth["unabsorbed_rmse_rad"]`` is wanted: what of the effects no change of the
        base model's parameters (within about a factor e), angle zero and first slip can imitate,
        to first order.
    """
    chain = MeasurementChain() if chain is None else chain
    path = make_path(0.0, segments, samples, rng)
    trace = simulate(
        path, parameters, alpha_deg=alpha_deg, initial_slip=initial_slip, negative=negative
    )
    changed = apply_effects(trace, effects or {}, rng)
    seen = trace.recorded
    stamps, torque, angle, spikes = measure(
        trace.time[seen], changed.torque[seen], changed.angle[seen], chain, rng
    )
    temperature = output_angle = None
    if changed.temperature is not None:
        temperature = changed.temperature[seen] + 0.05 * rng.standard_normal(seen.size)
    if changed.output_angle is not None:
        output_angle = changed.output_angle[seen]
    truth: dict[str, object] = {
        "alpha_deg": alpha_deg,
        "parameters": parameters.as_dict(),
        "negative_parameters": None if negative is None else negative.as_dict(),
        "torque_max_Nm": float(np.max(np.abs(trace.torque[seen]))),
        "slip_at_first_sample_rad": float(trace.slip[seen[0]]),
        "effects": changed.truth,
        "noise": asdict(chain),
        "spike_indices": np.flatnonzero(spikes).tolist(),
        "clean_rmse_rad": float(np.std(angle - trace.angle[seen])),
    }
    if absorption:
        reported = replace(trace, torque=changed.torque)
        truth["unabsorbed_rmse_rad"] = _unabsorbed(reported, changed.angle[seen], initial_slip)
    return LoopRecord(
        torque=torque,
        angle=angle,
        time=stamps,
        true_torque=trace.torque[seen],
        true_angle=changed.angle[seen],
        base_angle=trace.angle[seen],
        temperature=temperature,
        output_angle=output_angle,
        truth=truth,
    )


def _unabsorbed(trace: Trace, angle: FloatArray, initial_slip: float) -> float:
    """Return what the base model leaves of an angle when it imitates it as well as it can.

    To first order in the logarithms of the parameters, which are held to about a factor e by a
    penalty: without it a parameter that hardly matters could move without bounds. A fit of the
    bent model itself leaves as much or more.
    """
    step, slip_step, tolerance = 1e-3, 1e-5, 1e-6

    def predict(parameters: DriveParameters, slip: float = initial_slip) -> FloatArray:
        path = TorquePath(trace.time, trace.torque, trace.recorded)
        again = simulate(path, parameters, alpha_deg=trace.alpha_deg, initial_slip=slip)
        return again.angle[trace.recorded]

    base = predict(trace.parameters)
    columns = [
        (predict(replace(trace.parameters, **{name: value * (1.0 + step)})) - base) / step
        for name, value in trace.parameters.as_dict().items()
    ]
    held = len(columns)
    columns.append(np.full_like(base, 1e-3))
    columns.append((predict(trace.parameters, initial_slip + slip_step) - base) / slip_step * 1e-3)
    design = np.column_stack(columns)
    penalty = np.eye(design.shape[1])[:held] * tolerance
    left = angle - base
    move = np.linalg.lstsq(
        np.vstack((design, penalty)), np.concatenate((left, np.zeros(held))), rcond=None
    )[0]
    return float(np.sqrt(np.mean((left - design @ move) ** 2)))


def random_loop(
    rng: np.random.Generator,
    kind: LoopKind,
    *,
    effects: Mapping[str, float] | None = None,
    samples: int | None = None,
    history: History | None = None,
    chain: MeasurementChain | None = None,
    correlated: bool = False,
    spikes: bool = False,
    absorption: bool = False,
    alpha_deg: float = 30.0,
) -> LoopRecord:
    """Draw a drive, a torque programme and sensors, and record one loop.

    Parameters
    ----------
    kind
        See `programme`.
    effects
        Size [rad] by name in ``effects.EFFECTS``; see `suitable_effects`.
    samples
        Between 150 and 800 where not given, and at least 400 for the longer programmes.
    history
        Drawn where not given.
    chain
        Sensors; drawn around those of the paper's rig where not given.
    correlated
        Whether the encoder's noise has memory.
    spikes
        Whether 2 % of the samples carry isolated errors.
    absorption
        See `record_loop`.

    Raises
    ------
    ValueError
        If the kind is not known, or cannot carry one of the effects.
    """
    if kind not in KINDS:
        raise ValueError(f"unknown kind of loop {kind!r}; one of {', '.join(KINDS)}")
    parameters, torque_max = random_parameters(rng, alpha_deg)
    histories: tuple[History, ...] = get_args(History)
    if history is None:
        history = histories[int(rng.integers(3))]
    ramp_time = float(np.exp(rng.uniform(math.log(6.0), math.log(90.0))))
    holds = bool(rng.random() < 0.3)
    segments = programme(kind, torque_max, ramp_time, rng, history=history, holds=holds)
    if samples is None:
        few = 150 if kind in ("one-sided", "two-sided") else 400
        samples = int(rng.integers(few, 801))
    if chain is None:
        chain = MeasurementChain(
            torque_noise=float(rng.uniform(0.02, 0.1)),
            angle_noise=float(np.exp(rng.uniform(math.log(5e-6), math.log(2e-5)))),
            correlation_time=0.15 * ramp_time if correlated else 0.0,
            spike_share=0.02 if spikes else 0.0,
            angle_zero=float(rng.uniform(-math.pi, math.pi)),
        )
    record = record_loop(
        parameters,
        segments,
        samples,
        rng,
        alpha_deg=alpha_deg,
        chain=chain,
        effects=effects,
        absorption=absorption,
    )
    record.truth.update(
        {
            "kind": kind,
            "history": history,
            "holds": holds,
            "ramp_time_s": ramp_time,
            "T_max_over_T_i": torque_max / parameters.T_i,
            "torque_shape": segments[-1].shape,
        }
    )
    return record


def suitable_effects(kind: LoopKind) -> list[str]:
    """Return the names of the effects that show on every loop of a kind."""
    lacking: set[str] = set()
    if kind in ("one-sided", "multi-cycle"):
        lacking.add("two-sided")
    if kind != "multi-rate":
        lacking.add("several rates")
    return [name for name, effect in EFFECTS.items() if not lacking & set(effect.needs)]


def write_csv(record: LoopRecord, path: Path, *, with_time: bool = True) -> None:
    """Write a loop file with units in its header."""
    columns: dict[str, FloatArray] = {}
    if with_time:
        columns["time_s"] = record.time
    columns["torque_Nm"] = record.torque
    columns["angle_rad"] = record.angle
    if record.temperature is not None:
        columns["temperature_C"] = record.temperature
    if record.output_angle is not None:
        columns["output_angle_rad"] = record.output_angle
    formats = {"time_s": "%.5f", "torque_Nm": "%.4f", "temperature_C": "%.2f"}
    np.savetxt(
        path,
        np.column_stack(list(columns.values())),
        delimiter=",",
        header=",".join(columns),
        comments="",
        fmt=[formats.get(name, "%.9f") for name in columns],
    )
