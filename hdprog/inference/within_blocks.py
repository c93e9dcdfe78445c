"""What readings inside the blocks of a reduced record say of the noise scale.

A block's mean is what parameters are fitted to. How its readings scatter about their own straight
line within the block, no parameter explains: if noise is white, that scatter has the scale of the
blocks' noise, and knows it better than a few hundred blocks do. Together they give the scale that
a fit of all readings would find. Where the two disagree (noise with a memory, rounded readings,
something that the model lacks), the blocks alone decide, as parameters are fitted to them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import fdtr

from hdprog.data.loop import Loop
from hdprog.data.reduce import ReducedLoop
from hdprog.physics.parameters import FloatArray

FALSE_ALARM_RATE = 0.01
"""Share of records with white noise whose blocks are taken to disagree with their readings."""

_FEWEST = 3  # readings of a block that leave anything beside a straight line


@dataclass(frozen=True)
class WithinBlocks:
    """Scatter of readings inside their blocks, in units of the reading's noise for s = 1.

    Attributes
    ----------
    squares : sum about each block's straight line
    degrees : of freedom of that sum
    """

    squares: float
    degrees: float

    @staticmethod
    def of(loop: Loop, reduced: ReducedLoop, slope: FloatArray, sd: FloatArray) -> WithinBlocks:
        """From a record and its reduction.

        Parameters
        ----------
        loop : the record
        reduced : its blocks
        slope : (blocks,) dΔθ/dT in rad/Nm, by which noise of torque moves the angle
        sd : (blocks,) standard deviation of a reading of each block for s = 1, in rad
        """
        used = np.flatnonzero(reduced.block_of >= 0)
        block, blocks = reduced.block_of[used], reduced.count.size
        missing = (loop.angle[used] - slope[block] * loop.torque[used]) / sd[block]

        def summed(values: FloatArray) -> FloatArray:
            return np.asarray(np.bincount(block, weights=values, minlength=blocks), np.float64)

        def about_mean(values: FloatArray) -> FloatArray:
            return np.asarray(values - (summed(values) / reduced.count)[block])

        missing, place = about_mean(missing), about_mean(used.astype(np.float64))
        along = summed(place * missing) ** 2 / np.maximum(summed(place**2), np.finfo(float).tiny)
        enough = reduced.count >= _FEWEST
        squares = (summed(missing**2) - along)[enough].sum()
        return WithinBlocks(float(squares), float((reduced.count[enough] - 2).sum()))

    def agrees(self, squares: float, degrees: float) -> bool:
        """Whether blocks with this sum of squares have the same noise, by an F test."""
        if min(self.degrees, degrees) < 1 or self.squares <= 0.0:
            return False
        ratio = (squares / degrees) / (self.squares / self.degrees)
        below = float(fdtr(degrees, self.degrees, ratio))
        return FALSE_ALARM_RATE / 2 < below < 1 - FALSE_ALARM_RATE / 2
