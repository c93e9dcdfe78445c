"""What each parameter does to the loop (the paper's Figs 12 and 13)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from hdprog.physics.figures import ARCMIN_PER_RAD, local_stiffness
from hdprog.physics.parameters import BY_NAME
from hdprog.reproduction.results import BranchPair, Finding, Sweep
from hdprog.reproduction.table2 import ALPHA, POST_TEST, TOP, as_draw, steady_loop

_FACTORS = (0.7, 1.0, 1.3)
_PRELOADS = (0.0, 0.5, 1.0)  # of T_i
_THRESHOLDS = (0.0, 15.0, 30.0, 45.0)  # Nm
_SLIGHT = 0.05  # change of stiffness that counts as slight
_HARDLY = 0.001  # change of width that counts as none


def sweeps() -> tuple[Sweep, ...]:
    """Preload and meshing threshold (Fig. 12); friction, wave generator and cup (Fig. 13)."""
    return (
        _sweep("T_i", "Fig. 12", tuple(factor * POST_TEST["T_i"] for factor in _PRELOADS)),
        _sweep("T_T", "Fig. 12", _THRESHOLDS),
        *(
            _sweep(name, "Fig. 13", tuple(factor * POST_TEST[name] for factor in _FACTORS))
            for name in ("mu", "K_W", "K_F")
        ),
    )


def findings(found: tuple[Sweep, ...]) -> tuple[Finding, ...]:
    """The paper's claims about them, and what came out."""
    by_name = {sweep.parameter: sweep for sweep in found}
    return (
        _preload(by_name["T_i"]),
        _threshold(by_name["T_T"]),
        _friction(by_name["mu"]),
        _wave_generator(by_name["K_W"]),
        _cup(by_name["K_F"]),
    )


def _sweep(name: str, figure: str, values: tuple[float, ...]) -> Sweep:
    loops = tuple(steady_loop({**POST_TEST, name: value}, f"{value:.4g}") for value in values)
    return Sweep(name, figure, values, loops)


def width_at_zero(loop: BranchPair) -> float:
    """Width at no load in arcmin."""
    return float(ARCMIN_PER_RAD * np.interp(0.0, loop.torque, loop.width))


def largest_width(loop: BranchPair) -> float:
    """Largest width in arcmin."""
    return float(ARCMIN_PER_RAD * loop.width.max())


def secant(loop: BranchPair) -> float:
    """Torque over angle at the loop's tip in Nm/rad."""
    return float(loop.torque[-1] / loop.rising[-1])


def bend(parameters: dict[str, float]) -> float:
    """Local stiffness of the stiffness curve (24) at 100 Nm over that at no load."""
    ends = [local_stiffness(torque, as_draw(parameters), ALPHA) for torque in (TOP, 0.0)]
    return float(ends[0][0] / ends[1][0])


def _rises(values: list[float]) -> bool:
    return all(b > a for a, b in pairwise(values))


def _preload(sweep: Sweep) -> Finding:
    widths = [width_at_zero(loop) for loop in sweep.loops]
    preloads = [-POST_TEST["c"] * value for value in sweep.values]
    said = ", ".join(
        f"{width:.3f} arcmin at {preload:.0f} Nm"
        for width, preload in zip(widths, preloads, strict=True)
    )
    return Finding(
        "Fig. 12",
        "At zero torque the hysteresis falls as the preload falls.",
        f"Width at no load: {said}.",
        "agrees" if _rises(widths) else "disagrees",
        {f"width_arcmin_at_preload_{p:.0f}Nm": w for p, w in zip(preloads, widths, strict=True)},
    )


def _threshold(sweep: Sweep) -> Finding:
    bends = [bend({**POST_TEST, "T_T": value}) for value in sweep.values]
    said = ", ".join(
        f"{ratio:.2f} at T_T = {value:.0f} Nm"
        for ratio, value in zip(bends, sweep.values, strict=True)
    )
    straight = abs(bends[0] - 1) < _SLIGHT
    return Finding(
        "Fig. 12",
        "The number of meshing teeth makes the stiffness nonlinear: it is linear where T_T = 0, "
        "and bends the more the larger T_T is.",
        f"Slope of the stiffness curve at {TOP:.0f} Nm over that at no load: {said}. With T_T = 0 "
        "and b kept the teeth stay as soft as at no load; Table 2's initial drive is another one.",
        "agrees" if straight and _rises(bends) else "disagrees",
        {f"bend_at_T_T_{v:.0f}Nm": b for v, b in zip(sweep.values, bends, strict=True)},
    )


def _ends(sweep: Sweep) -> tuple[list[float], list[float], list[float]]:
    """Widths at no load, largest widths and secant stiffnesses by rising parameter."""
    return (
        [width_at_zero(loop) for loop in sweep.loops],
        [largest_width(loop) for loop in sweep.loops],
        [secant(loop) for loop in sweep.loops],
    )


def _numbers(sweep: Sweep) -> dict[str, float]:
    zero, largest, stiffness = _ends(sweep)
    named: dict[str, float] = {}
    for value, width, most, k in zip(sweep.values, zero, largest, stiffness, strict=True):
        at = f"{sweep.parameter}_{value:.4g}"
        named[f"width_at_zero_arcmin_{at}"] = width
        named[f"largest_width_arcmin_{at}"] = most
        named[f"secant_stiffness_Nm_per_rad_{at}"] = k
    return named


def _change(values: list[float]) -> float:
    """Relative change from the first to the last."""
    return values[-1] / values[0] - 1


def _written(value: float) -> str:
    """Three digits, a large number with its thousands apart."""
    short = float(f"{value:.3g}")
    return f"{short:,.0f}".replace(",", " ") if short >= 1000.0 else f"{short:g}"


def _said(sweep: Sweep) -> str:
    zero, largest, stiffness = _ends(sweep)
    name = BY_NAME[sweep.parameter]
    unit = "" if name.unit == "-" else f" {name.unit}"
    first, last = (_written(value) for value in (sweep.values[0], sweep.values[-1]))
    return (
        f"From {name.symbol} = {first} to {last}{unit} the width at no load changes by "
        f"{100 * _change(zero):+.1f} %, the largest width by {100 * _change(largest):+.1f} % and "
        f"the secant stiffness at {TOP:.0f} Nm by {100 * _change(stiffness):+.2f} %."
    )


def _friction(sweep: Sweep) -> Finding:
    zero, largest, stiffness = _ends(sweep)
    good = _rises(zero) and _rises(largest) and 0 < _change(stiffness) < _SLIGHT
    return Finding(
        "Fig. 13",
        "With more friction the hysteresis grows and the stiffness rises slightly.",
        _said(sweep),
        "agrees" if good else "disagrees",
        _numbers(sweep),
    )


def _wave_generator(sweep: Sweep) -> Finding:
    zero, largest, stiffness = _ends(sweep)
    good = _rises(zero[::-1]) and _rises(largest[::-1]) and _rises(stiffness)
    return Finding(
        "Fig. 13",
        "A softer wave generator widens the hysteresis and lowers the stiffness.",
        _said(sweep),
        "agrees" if good else "disagrees",
        _numbers(sweep),
    )


def _cup(sweep: Sweep) -> Finding:
    zero, largest, stiffness = _ends(sweep)
    still = max(abs(_change(zero)), abs(_change(largest))) < _HARDLY
    return Finding(
        "Fig. 13",
        "A softer flexspline lowers the stiffness and hardly touches the hysteresis.",
        _said(sweep),
        "agrees" if still and _rises(stiffness) else "disagrees",
        _numbers(sweep),
    )
