"""Small records with a known course, and files that hold them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

PEAK = 40.0  # Nm
STIFFNESS = 2.0e4  # Nm/rad


def ramps(*corners: float, samples: int = 101) -> FloatArray:
    """Torque that runs straight from corner to corner in equal numbers of samples."""
    steps = np.linspace(0.0, len(corners) - 1.0, (len(corners) - 1) * (samples - 1) + 1)
    return np.interp(steps, np.arange(len(corners)), corners)


def twist(torque: FloatArray) -> FloatArray:
    """Angle that a constant friction holds back, to be a loop and not a line."""
    return torque / STIFFNESS - 2e-5 * np.sign(np.gradient(torque))


def two_sided() -> tuple[FloatArray, FloatArray]:
    torque = ramps(0, PEAK, -PEAK, PEAK, 0)
    return torque, twist(torque)


def rows(*columns: FloatArray, sign: str = ",") -> list[str]:
    return [sign.join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]


def table(header: str = "torque_Nm,angle_rad", sign: str = ",") -> str:
    return "\n".join([header, *rows(*two_sided(), sign=sign)]) + "\n"


def write(path: Path, text: str, encoding: str = "utf-8") -> Path:
    path.write_bytes(text.encode(encoding))
    return path
