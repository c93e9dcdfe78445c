"""A discrete Preisach model, identified by nonnegative least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.other_models.base import ModelParameter, Setting
from hdprog.physics.other_models.nonnegative import (
    NonnegativeModel,
    ramps,
    spread,
    weight,
)
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

_CELLS = 6  # along each axis of the plane
_FINE = 10  # strips of a cell
_PIECES = 12  # of the reversible part
_BEND = 1.4


@dataclass(frozen=True)
class Preisach(NonnegativeModel):
    """Δθ = Σ v_j·e_j(T) + Σ w_ij·γ_ij[T], v, w ≥ 0.

    γ_ij is the share of relays that are up in a cell of the Preisach plane: relays that go up at
    α in the i-th interval of torque and down at β ≤ α in the j-th. The density is even inside a
    cell, so that the angle follows torque without steps. The first sum is the reversible part
    (relays with α = β), torque's share in each interval.
    """

    id = "preisach"
    words = "Preisach (discrete)"
    source = (
        "introduction; Ruderman, Bertram & Iwasaki, Mechatronics 24 (2014); Preisach, Z. Phys."
        " 94 (1935) 277"
    )
    where = "any record with a reversal, and there only between the torques that it reached"
    odd = False

    def parameters(self, setting: Setting) -> tuple[ModelParameter, ...]:
        """v_j in rad/Nm, w_ij in rad."""
        soft, turn = 1 / setting.stiffness, 0.1 * setting.angle
        reversible = [
            weight(f"v_{index + 1}", "rad/Nm", "reversible compliance of an interval", 3 * soft)
            for index in range(_PIECES)
        ]
        relays = [
            weight(f"w_{up + 1}_{down + 1}", "rad", "angle of a cell of relays", turn)
            for up, down in _cells()
        ]
        return (*reversible, *relays)

    def features(self, path: TorquePath, setting: Setting) -> FloatArray:
        """See `NonnegativeModel.features`."""
        reversible = ramps(path.torque, spread(_PIECES, setting.torque, _BEND))
        return np.hstack([reversible, self._relays(path, setting)])

    def _relays(self, path: TorquePath, setting: Setting) -> FloatArray:
        """Share of relays up in each cell, (samples, cells)."""
        edges = spread(_CELLS * _FINE, setting.torque, _BEND)
        strips = edges.size - 1
        # Row a: relays that go up in strip a; column b: those that go down in strip b.
        exists = np.tri(strips, dtype=bool)
        state = self._before(path.torque[0], edges)
        blocks = np.empty((path.torque.size, strips // _FINE, strips // _FINE))
        for number, (start, end) in enumerate(zip(path.starts, path.ends, strict=True)):
            rising = bool(path.rising[number])
            reached = _share(np.append(path.torque[start:end], path.reached[number]), edges)
            blocks[start:end] = _swept(state, reached[:-1], exists, rising)
            last = reached[-1]
            state = np.maximum(state, last[:, None]) if rising else np.minimum(state, last)
        many = _by_cell(exists.astype(float))
        up, down = np.array(_cells()).T
        return np.asarray(blocks[:, up, down] / many[up, down])

    def _before(self, torque: float, edges: FloatArray) -> FloatArray:
        """State of the relays at the first torque, (strips, strips)."""
        strips = edges.size - 1
        up = np.broadcast_to(_share(np.array([torque]), edges)[0][:, None], (strips, strips))
        down = np.broadcast_to(_share(np.array([torque]), edges)[0], (strips, strips))
        if self.history == 1:  # rows below the torque are up, all else is down
            return np.asarray(up.copy())
        if self.history == -1:  # columns above the torque are down, all else is up
            return np.asarray(down.copy())
        middle = 0.5 * (edges[1:] + edges[:-1])
        never = (middle[:, None] + middle[None, :] < 0).astype(float)
        return np.asarray(np.minimum(np.maximum(never, up), down))


def _cells() -> list[tuple[int, int]]:
    """Cells of the plane with α ≥ β."""
    return [(up, down) for up in range(_CELLS) for down in range(up + 1)]


def _share(torque: FloatArray, edges: FloatArray) -> FloatArray:
    """How far torques (samples,) have come through each strip, (samples, strips), 0 to 1."""
    return np.asarray(np.clip((torque[:, None] - edges[:-1]) / np.diff(edges), 0.0, 1.0))


def _swept(
    state: FloatArray, reached: FloatArray, exists: NDArray[np.bool_], rising: bool
) -> FloatArray:
    """Relays up in each cell along a stretch, (samples, cells, cells), in strips.

    A strip's place is all that torque changes: where it has come through, the row (the column, when
    torque falls) is up (down), where it has not, the row is as before.
    """
    strips, cells = state.shape[0], state.shape[0] // _FINE
    if not rising:  # columns are rows of the transposed plane, and down is up with signs turned
        turned = _swept(1 - state.T, 1 - reached, exists.T, True)
        many = _by_cell(exists.astype(float))
        return np.asarray(many - turned.transpose(0, 2, 1))
    found = np.empty((len(reached), cells, cells))
    first = np.arange(0, strips, _FINE)
    for row in range(cells):
        total = np.zeros((len(reached), strips))
        for strip in range(row * _FINE, (row + 1) * _FINE):
            there = exists[strip]
            total += np.maximum(state[strip], reached[:, strip : strip + 1]) * there
        found[:, row] = np.add.reduceat(total, first, axis=1)
    return found


def _by_cell(plane: FloatArray) -> FloatArray:
    """Sums over cells of a plane of strips."""
    first = np.arange(0, plane.shape[0], _FINE)
    return np.asarray(np.add.reduceat(np.add.reduceat(plane, first, axis=0), first, axis=1))
