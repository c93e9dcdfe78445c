"""A second, incremental implementation of the harmonic-drive hysteresis model.

It shares no code with the package under test. The torsion angle is built up step by step along a
fine internal torque path: the tooth mesh by Gauss-Legendre quadrature of dT/K_T over every step,
the wave generator by deciding at every step from the balance of forces (eq. 20) whether the
contact sticks or slips. Equation numbers are those of the paper on harmonic-drive compliance and
hysteresis considering degradation.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
MeshForm = Literal["continuum", "as_printed"]
SegmentShape = Literal["ramp", "sine", "irregular", "hold"]

ARCMIN = math.pi / 180.0 / 60.0
ENCODER_STEP = math.radians(0.00056)
TORQUE_STEP = 0.1
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class DriveParameters:
    """Parameters of the base model.

    Attributes
    ----------
    K_F, K_W
        Stiffness of the flexspline cup and of the wave generator [Nm/rad].
    a, b
        Tooth-mesh stiffness K_T = a T + b below T_T [1/rad], [Nm/rad] (eq. 17).
    T_T
        Torque at which every tooth pair has come into mesh [Nm].
    c, T_i
        Slope [-] and end [Nm] of the no-load preload (eq. 16).
    mu
        Coefficient of friction in the tooth engagement [-].
    """

    K_F: float
    K_W: float
    a: float
    b: float
    T_T: float
    c: float
    T_i: float
    mu: float

    def as_dict(self) -> dict[str, float]:
        """Return the parameters by name."""
        return {name: float(value) for name, value in asdict(self).items()}


#: Table 2, new drive: cup and teeth in series give the one stiffness 50 923.2 Nm/rad (eq. 38).
INITIAL = DriveParameters(
    K_F=78197.8,
    K_W=101837.5,
    a=0.0,
    b=1.0 / (1.0 / 50923.2 - 1.0 / 78197.8),
    T_T=0.0,
    c=-1.177,
    T_i=115.5,
    mu=0.066,
)
#: Table 2, after 100 h at rated torque.
POST_TEST = DriveParameters(
    K_F=78197.8, K_W=98548.7, a=1833.5, b=5729.6, T_T=30.0, c=-1.152, T_i=70.2, mu=0.076
)


def is_physical(parameters: DriveParameters, alpha_deg: float = 30.0) -> bool:
    """Tell whether a parameter set lies inside the support of the model."""
    p, alpha = parameters, math.radians(alpha_deg)
    return (
        min(p.K_F, p.K_W, p.b) > 0.0
        and min(p.a, p.T_T, p.T_i) >= 0.0
        and p.c < 0.0
        and 0.0 < p.mu < min(math.tan(alpha), 1.0 / math.tan(alpha))
        and math.sin(alpha) + p.mu * (math.cos(alpha) + p.c) > 0.0
    )


# --------------------------------------------------------------------------- torque histories


@dataclass(frozen=True)
class Segment:
    """One stretch of a torque history.

    Attributes
    ----------
    target
        Torque at the end of the stretch [Nm]; a hold keeps the torque it starts from.
    duration
        [s].
    shape
        ``ramp`` linear, ``sine`` half a cosine, ``irregular`` monotone at a slowly varying rate,
        ``hold`` constant.
    recorded
        False for what happened before the recording began.
    """

    target: float
    duration: float
    shape: SegmentShape = "ramp"
    recorded: bool = True


@dataclass(frozen=True)
class TorquePath:
    """A fine internal torque history.

    Attributes
    ----------
    time, torque
        shape (m,), [s] and [Nm]; time is zero where the recording begins.
    recorded
        shape (n,), indices of the samples that are recorded.
    """

    time: FloatArray
    torque: FloatArray
    recorded: IntArray


def make_path(
    start: float,
    segments: Sequence[Segment],
    samples: int,
    rng: np.random.Generator,
    *,
    jitter: float = 0.15,
    oversampling: int = 20,
) -> TorquePath:
    """Lay a fine torque path through segments and choose the instants that are recorded.

    Samples are shared out between the segments half by duration and half by torque travelled, so
    that fast stretches keep enough of them. Reversals generally fall between two samples.

    Parameters
    ----------
    start
        Torque before the first segment [Nm].
    segments
        The history; those with ``recorded=False`` must come first.
    samples
        Number of recorded samples n.
    rng
        Source of the jitter and of irregular rates.
    jitter
        Standard deviation of the sampling instants, in sampling intervals.
    oversampling
        Internal steps between neighbouring samples.

    Raises
    ------
    ValueError
        If nothing is recorded or an unrecorded segment follows a recorded one.
    """
    flags = [segment.recorded for segment in segments]
    if not any(flags) or flags != sorted(flags):
        raise ValueError("unrecorded segments must come first and one segment must be recorded")
    durations = np.array([segment.duration for segment in segments])
    starts = np.concatenate(([0.0], np.cumsum(durations)))
    starts -= starts[flags.index(True)]
    ends = np.empty(len(segments) + 1)
    ends[0] = start
    for index, segment in enumerate(segments):
        ends[index + 1] = ends[index] if segment.shape == "hold" else segment.target

    mask = np.array(flags)
    travel = np.abs(np.diff(ends)) * mask
    lasting = durations * mask
    share = 0.5 * lasting / lasting.sum() + 0.5 * travel / max(travel.sum(), 1e-12)
    edges = np.round(np.concatenate(([0.0], np.cumsum(share / share.sum()))) * samples).astype(int)
    counts = np.diff(edges)

    knots: list[FloatArray] = []
    instants: list[FloatArray] = []
    for index, count in enumerate(counts):
        begin, length = starts[index], durations[index]
        if not flags[index]:
            knots.append(begin + length * np.arange(6) / 6.0)
            continue
        knots.append(np.array([begin]))
        if count:
            shift = np.clip(jitter * rng.standard_normal(count), -0.4, 0.4)
            instants.append(begin + length * (np.arange(count) + 0.5 + shift) / count)
    chosen = np.concatenate(instants)
    grid = np.unique(np.concatenate([*knots, chosen, starts[-1:]]))
    fractions = np.arange(oversampling) / oversampling
    time = (grid[:-1, None] + np.diff(grid)[:, None] * fractions).ravel()
    time = np.append(time, grid[-1])
    torque = np.empty_like(time)
    which = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, len(segments) - 1)
    for index, segment in enumerate(segments):
        inside = which == index
        u = (time[inside] - starts[index]) / durations[index]
        torque[inside] = ends[index] + (ends[index + 1] - ends[index]) * _progress(
            u, segment.shape, rng
        )
    recorded = np.searchsorted(grid, chosen) * oversampling
    return TorquePath(time, torque, recorded.astype(np.int64))


def _progress(u: FloatArray, shape: SegmentShape, rng: np.random.Generator) -> FloatArray:
    """Return how far a segment has come, from 0 to 1, at relative times u."""
    if shape == "sine":
        return 0.5 * (1.0 - np.cos(math.pi * u))
    if shape == "irregular":
        steps = rng.gamma(2.0, size=8) + 0.15
        level = np.concatenate(([0.0], np.cumsum(steps) / steps.sum()))
        return np.asarray(PchipInterpolator(np.linspace(0.0, 1.0, 9), level)(u), dtype=np.float64)
    return np.array(u, dtype=np.float64)


# --------------------------------------------------------------------------- the three springs


def mesh_angle(
    torque: FloatArray,
    parameters: DriveParameters,
    form: MeshForm = "continuum",
    negative: DriveParameters | None = None,
) -> FloatArray:
    """Return the torsion angle of the flexspline teeth along a torque path [rad].

    ``continuum`` adds up four-point Gauss-Legendre integrals of dT/K_T over every step, each step
    split where K_T has a corner (0 and +-T_T); ``as_printed`` is the sum of eq. (19).

    Parameters
    ----------
    torque
        shape (m,), in the order of time [Nm].
    parameters
        For positive torque, and for negative torque unless ``negative`` is given.
    """
    minus = parameters if negative is None else negative
    if form == "as_printed":
        return np.where(
            torque >= 0.0,
            _printed_sum(np.abs(torque), parameters),
            -_printed_sum(np.abs(torque), minus),
        )
    lead = np.linspace(0.0, float(torque[0]), 65)
    walk = np.concatenate((lead, torque[1:]))
    begin, end = walk[:-1], walk[1:]
    increment = np.zeros_like(begin)
    corners = (-np.inf, -minus.T_T, 0.0, parameters.T_T, np.inf)
    for low, high in itertools.pairwise(corners):
        side = parameters if high > 0.0 else minus
        left, right = np.clip(begin, low, high), np.clip(end, low, high)
        touched = np.flatnonzero(left != right)
        half = 0.5 * (right[touched] - left[touched])
        middle = 0.5 * (right[touched] + left[touched])
        points = np.abs(middle[:, None] + half[:, None] * _NODES)
        stiffness = side.a * np.minimum(points, side.T_T) + side.b
        increment[touched] += half * ((1.0 / stiffness) @ _WEIGHTS)
    angle = np.concatenate(([0.0], np.cumsum(increment)))
    return angle[lead.size - 1 :]


def _printed_sum(size: FloatArray, parameters: DriveParameters) -> FloatArray:
    """Return the staircase of eq. (19) for torques of either sign given by their size."""
    p = parameters
    inside = np.minimum(size, p.T_T)
    last = np.maximum(np.ceil(inside).astype(int) - 1, 0)
    terms = 1.0 / (p.a * np.arange(1, int(last.max(initial=0)) + 1) + p.b)
    total = np.concatenate(([0.0], np.cumsum(terms)))[last]
    beyond = np.maximum(size - p.T_T, 0.0) / (p.a * p.T_T + p.b)
    return np.asarray(total + beyond, dtype=np.float64)


def wave_generator_slip(
    torque: FloatArray,
    parameters: DriveParameters,
    alpha_deg: float = 30.0,
    initial_slip: float = 0.0,
    negative: DriveParameters | None = None,
) -> FloatArray:
    """Return the wave generator's deflection y along a torque path, by stick and slip [rad].

    The torque pushes the inclined tooth contact with T sin(alpha), the wave-generator spring
    holds it with K_W y cos(alpha). What is left has to be carried by friction, at most mu times
    the normal force, which is the preload plus (y > 0) or less (y < 0) the normal parts of
    torque and spring: the two flanks of the tooth. While friction can carry it nothing moves;
    otherwise y moves just until it can.
    """
    alpha = math.radians(alpha_deg)
    sine, cosine = math.sin(alpha), math.cos(alpha)
    minus = parameters if negative is None else negative
    positive = torque >= 0.0
    size = np.abs(torque)
    preload = np.where(
        positive,
        np.where(size < parameters.T_i, parameters.c * (size - parameters.T_i), 0.0),
        np.where(size < minus.T_i, minus.c * (size - minus.T_i), 0.0),
    )
    friction = np.where(positive, parameters.mu, minus.mu)
    spring = np.where(positive, parameters.K_W, minus.K_W)
    y = initial_slip
    slip: list[float] = []
    for push, press, t0, mu, stiffness in zip(
        (torque * sine).tolist(),
        (torque * cosine).tolist(),
        preload.tolist(),
        friction.tolist(),
        spring.tolist(),
        strict=True,
    ):
        force = stiffness * y
        left_over = push - force * cosine
        upward = downward = t0 + press + force * sine
        if force < 0.0:
            upward = downward = t0 - press - force * sine
        elif force == 0.0:
            downward = t0 - press
        if left_over > mu * max(upward, 0.0):
            y = _slide(force, push, press, t0, mu, sine, cosine) / stiffness
        elif left_over < -mu * max(downward, 0.0):
            y = -_slide(-force, -push, -press, t0, mu, sine, cosine) / stiffness
        slip.append(y)
    return np.array(slip)


def _slide(
    force: float,
    push: float,
    press: float,
    preload: float,
    mu: float,
    sine: float,
    cosine: float,
) -> float:
    """Return the spring force at which an upward slip comes to rest [Nm]."""
    if force < 0.0:
        rest = (push - mu * (preload - press)) / (cosine - mu * sine)
        if rest < 0.0:
            return rest
        if push <= mu * (preload + press):
            return 0.0
    return (push - mu * (preload + press)) / (cosine + mu * sine)


@dataclass(frozen=True)
class Trace:
    """What really happened on the internal path, before any measurement.

    Attributes
    ----------
    time, torque, rate, angle, slip
        shape (m,): [s], [Nm], [Nm/s], torsion angle [rad], wave-generator deflection [rad].
    recorded
        shape (n,), indices of the recorded samples.
    parameters, alpha_deg
        The truth behind it.
    """

    time: FloatArray
    torque: FloatArray
    rate: FloatArray
    angle: FloatArray
    slip: FloatArray
    recorded: IntArray
    parameters: DriveParameters
    alpha_deg: float


def simulate(
    path: TorquePath,
    parameters: DriveParameters,
    *,
    alpha_deg: float = 30.0,
    initial_slip: float = 0.0,
    mesh: MeshForm = "continuum",
    negative: DriveParameters | None = None,
) -> Trace:
    """Run the base model (eq. 21) along a path.

    Raises
    ------
    ValueError
        If the parameters lie outside the support of the model.
    """
    minus = parameters if negative is None else negative
    for side in (parameters, minus):
        if not is_physical(side, alpha_deg):
            raise ValueError(f"{side} lies outside the support of the model")
    torque = path.torque
    cup = torque / np.where(torque >= 0.0, parameters.K_F, minus.K_F)
    slip = wave_generator_slip(torque, parameters, alpha_deg, initial_slip, negative)
    teeth = mesh_angle(torque, parameters, mesh, negative)
    angle = cup + teeth + math.tan(math.radians(alpha_deg)) * slip
    rate = np.diff(torque) / np.diff(path.time)
    rate = np.append(rate, rate[-1])
    return Trace(path.time, torque, rate, angle, slip, path.recorded, parameters, alpha_deg)


# --------------------------------------------------------------------------- measurement


@dataclass(frozen=True)
class MeasurementChain:
    """Sensors of the rig.

    Attributes
    ----------
    torque_noise, torque_step
        Standard deviation and resolution of the torque sensor [Nm].
    angle_noise, angle_step
        The same of the output encoder [rad].
    correlation_time
        Where positive, ``correlated_share`` of the encoder's noise variance is an
        Ornstein-Uhlenbeck process with this memory [s].
    correlated_share
        Share of the variance, 0 to 1.
    spike_share, spike_size
        Share of samples with an isolated error, and its typical size [rad].
    angle_zero
        Encoder reading of the unloaded drive [rad].
    stamp_noise
        Error of the time stamps, in local sampling intervals.
    """

    torque_noise: float = 0.05
    torque_step: float = TORQUE_STEP
    angle_noise: float = 1.0e-5
    angle_step: float = ENCODER_STEP
    correlation_time: float = 0.0
    correlated_share: float = 0.7
    spike_share: float = 0.0
    spike_size: float = 3.0e-4
    angle_zero: float = 0.0
    stamp_noise: float = 0.02


def measure(
    time: FloatArray,
    torque: FloatArray,
    angle: FloatArray,
    chain: MeasurementChain,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray, FloatArray, npt.NDArray[np.bool_]]:
    """Pass true samples through the sensors.

    Returns
    -------
    stamps, torque, angle, spikes
        Each shape (n,); ``spikes`` marks the samples that carry an isolated error.
    """
    count = time.size
    interval = np.diff(time)
    stamps = time.copy()
    if chain.stamp_noise > 0.0:
        room = np.minimum(np.append(interval, interval[-1]), np.insert(interval, 0, interval[0]))
        error = np.clip(chain.stamp_noise * rng.standard_normal(count), -0.45, 0.45)
        stamps = time + room * error
    seen_torque = torque + chain.torque_noise * rng.standard_normal(count)
    white, slow = chain.angle_noise * rng.standard_normal((2, count))
    noise = white
    if chain.correlation_time > 0.0:
        memory = np.exp(-interval / chain.correlation_time)
        for index in range(1, count):
            kept = memory[index - 1]
            slow[index] = kept * slow[index - 1] + math.sqrt(1.0 - kept * kept) * slow[index]
        share = chain.correlated_share
        noise = math.sqrt(1.0 - share) * white + math.sqrt(share) * slow
    spikes = rng.random(count) < chain.spike_share
    kick = rng.choice((-1.0, 1.0), count) * chain.spike_size * (0.3 + rng.gamma(2.0, 0.5, count))
    seen_angle = angle + chain.angle_zero + noise + spikes * kick
    return (
        stamps,
        _quantise(seen_torque, chain.torque_step),
        _quantise(seen_angle, chain.angle_step),
        spikes,
    )


def _quantise(values: FloatArray, step: float) -> FloatArray:
    """Round to multiples of a step; a step of zero leaves the values alone."""
    return np.round(values / step) * step if step > 0.0 else values


# --------------------------------------------------------------------------- true figures


@dataclass(frozen=True)
class SteadyCycle:
    """The symmetric steady cycle between -T_max and T_max.

    Attributes
    ----------
    torque
        shape (n,), rising [Nm].
    loading, unloading
        shape (n,), angle on the branch of rising and of falling torque [rad].
    """

    torque: FloatArray
    loading: FloatArray
    unloading: FloatArray


def steady_cycle(
    parameters: DriveParameters,
    torque_max: float,
    *,
    alpha_deg: float = 30.0,
    at: Sequence[float] = (),
    points: int = 240,
    mesh: MeshForm = "continuum",
    negative: DriveParameters | None = None,
) -> SteadyCycle:
    """Go round 0, T_max, -T_max, T_max, -T_max and keep the last rise and the fall after it.

    Parameters
    ----------
    at
        Torques that have to be among the points, besides zero and +-T_max [Nm].
    """
    wanted = np.concatenate((np.asarray(at, dtype=np.float64), [0.0]))
    rise = np.linspace(-torque_max, torque_max, points)
    rise = np.unique(np.concatenate((rise, wanted, -wanted)))
    fall = rise[::-1]
    walk = np.concatenate((rise[rise >= 0.0], fall[1:], rise[1:], fall[1:]))
    path = TorquePath(np.arange(walk.size, dtype=float), walk, np.arange(walk.size))
    angle = simulate(path, parameters, alpha_deg=alpha_deg, mesh=mesh, negative=negative).angle
    n = rise.size
    return SteadyCycle(rise, angle[-2 * n + 1 : -n + 1], angle[-n:][::-1])


def true_figures(
    parameters: DriveParameters,
    *,
    reference_torque: float = 63.0,
    rated_torque: float = 63.0,
    secant_torque: float = 14.0,
    alpha_deg: float = 30.0,
) -> dict[str, float]:
    """Return the figures of merit of a symmetric steady cycle to +-reference torque.

    Lost motion is the difference of the loop's mid-line angles at +-4 % of rated torque. The
    mid-line is not quite the stiffness curve (eq. 24), which friction does not enter; what the
    stiffness curve gives stands under ``lost_motion_of_stiffness_curve_arcmin``. The secant
    stiffness is that of the stiffness curve.
    """
    small = 0.04 * rated_torque
    cycle = steady_cycle(parameters, reference_torque, alpha_deg=alpha_deg, at=(small,))
    middle = 0.5 * (cycle.loading + cycle.unloading)
    width = cycle.unloading - cycle.loading
    at = {level: int(np.argmin(np.abs(cycle.torque - level))) for level in (-small, 0.0, small)}
    gap = 0.5 * (width[1:] + width[:-1])
    p = parameters
    compliance = 1.0 / p.K_F + math.tan(math.radians(alpha_deg)) ** 2 / p.K_W

    def stiffness_curve(torque: float) -> float:
        teeth = mesh_angle(np.linspace(0.0, torque, 65), p)[-1]
        return torque * compliance + float(teeth)

    return {
        "hysteresis_width_arcmin": float(width[at[0.0]]) / ARCMIN,
        "hysteresis_loss_J": float(np.sum(gap * np.diff(cycle.torque))),
        "lost_motion_arcmin": float(middle[at[small]] - middle[at[-small]]) / ARCMIN,
        "lost_motion_of_stiffness_curve_arcmin": 2.0 * stiffness_curve(small) / ARCMIN,
        "preload_Nm": -p.c * p.T_i,
        f"secant_stiffness_Nm_per_rad@{secant_torque:g}Nm": secant_torque
        / stiffness_curve(secant_torque),
    }
