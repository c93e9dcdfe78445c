"""A record before anything is fitted: torsion angle over torque, as it was read."""

from __future__ import annotations

import numpy as np

from hdprog.data.loop import Loop
from hdprog.physics.parameters import FloatArray
from hdprog.reporting.geometry import ARCMIN
from hdprog.reporting.style import FIT, MUTED, house_style, new_figure, svg_data_uri

_MOST_POINTS = 4000


def raw_loop(loop: Loop) -> str:
    """Picture of a record as the `data:` address of an SVG, 640 by 400 pixels.

    Parameters
    ----------
    loop : the record; of a long one every so many samples are drawn
    """
    every = max(1, len(loop) // _MOST_POINTS)
    torque: FloatArray = loop.torque[::every]
    angle: FloatArray = ARCMIN * (loop.angle[::every] - float(np.mean(loop.angle)))
    with house_style():
        figure = new_figure(640 / 96, 400 / 96)
        axes = figure.add_axes((0.11, 0.14, 0.86, 0.82))
        axes.axhline(0.0, color=MUTED, linewidth=0.6)
        axes.axvline(0.0, color=MUTED, linewidth=0.6)
        axes.plot(torque, angle, color=FIT, linewidth=0.9, rasterized=len(torque) > 1500)
        axes.plot(torque[:1], angle[:1], "o", color=FIT, markersize=5, label="start")
        axes.legend(loc="upper left")
        axes.set_xlabel("Torque in Nm")
        axes.set_ylabel("Torsion angle in arcmin, less its mean")
        return svg_data_uri(figure)
