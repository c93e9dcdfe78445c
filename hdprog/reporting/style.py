"""One look for every picture, and its way into the page as a self-contained SVG.

No pyplot: figures are made one by one and nothing global is changed for the caller.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote

import matplotlib as mpl
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from hdprog.reporting.drawn_lines import drawn_lines
from hdprog.reporting.embedded_png import with_palettes
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.words import PROVISIONAL_NUMBERS, tidy

# Okabe and Ito's colours, which people with colour blindness tell apart; every role has its own
# line style or marker too, so that a grey print can be read.
MEASURED = "#3d4852"
FIT = "#0072B2"
BAND = "#0072B2"
LIMIT = "#C44601"
INSPECT = "#8F2D77"
SHUTDOWN = "#00785A"
MUTED = "#6b7280"
GRID = "#e3e6ea"
INK = "#1c2430"

RASTER_DPI = 110
"""Resolution of dense marks, in dots an inch."""

_STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.5,
    "axes.labelcolor": INK,
    "axes.edgecolor": MUTED,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "text.color": INK,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "path.simplify_threshold": 0.25,
    "svg.fonttype": "path",  # the same letters on every machine
    "svg.hashsalt": "hdprog",  # the same input gives the same bytes
}


@dataclass(frozen=True)
class Picture:
    """A picture in the page, with the words that go with it.

    Attributes
    ----------
    uri : `data:` address of the SVG
    width, height : its size in CSS pixels
    alt : the finding, for those who do not see it
    shows, good, bad, action : the caption: what is drawn, what a good and a bad one look like,
        what to do
    data : its numbers, to be saved as a CSV file; None where there are none to give
    """

    uri: str
    width: int
    height: int
    alt: str
    shows: str
    good: str
    bad: str
    action: str
    data: PictureData | None = None


@contextmanager
def house_style() -> Iterator[None]:
    """Apply the style to figures that are made and drawn inside."""
    with mpl.rc_context(_STYLE):
        yield


def new_figure(width: float, height: float) -> Figure:
    """Empty figure of a size in inches, bound to the SVG backend."""
    figure = Figure(figsize=(width, height), dpi=RASTER_DPI)
    FigureCanvasSVG(figure)
    return figure


def picture(
    figure: Figure,
    *,
    alt: str,
    shows: str,
    good: str,
    bad: str,
    action: str,
    data: PictureData | None = None,
    doubtful: bool = False,
) -> Picture:
    """Figure as a picture of the page; see `Picture` for the words.

    Without `data` the file of its numbers holds the lines as they are drawn. `doubtful` says first
    that a fit or trend behind it did not converge.
    """
    width, height = (round(96 * inches) for inches in figure.get_size_inches())
    return Picture(
        svg_data_uri(figure),
        width,
        height,
        tidy(f"{PROVISIONAL_NUMBERS} {alt}" if doubtful else alt),
        tidy(shows),
        tidy(good),
        tidy(bad),
        tidy(action),
        drawn_lines(figure, alt[:40]) if data is None else data,
    )


def svg_data_uri(figure: Figure) -> str:
    """Figure as the `data:` address of an SVG; equal figures give equal text.

    Drawn under `house_style`, with the date left out of the metadata. Escaped by character, which
    is a fifth shorter than base 64 and does not encode the pixels inside twice.
    """
    buffer = io.BytesIO()
    figure.savefig(
        buffer,
        format="svg",
        dpi=RASTER_DPI,
        metadata={"Date": None, "Creator": None, "Format": None, "Type": None},
    )
    return "data:image/svg+xml," + quote(
        compact(with_palettes(buffer.getvalue().decode())), safe=_PLAIN
    )


_PLAIN = " !$'()*+,/:;=?@[]^|~"
_HEAD = re.compile(r"^<\?xml.*?(?=<svg)", re.DOTALL)
_COMMENT = re.compile(r"<!--.*?-->|<metadata>.*?</metadata>", re.DOTALL)
_SPACE = re.compile(r"\s+")
_TAG_GAP = re.compile(r"\s*(?<=>)\s+(?=<)")
_STYLE_GAP = re.compile(r"(?<=[:;]) +(?=[^\"]*\")")
_STYLED = re.compile(r'style="[^"]*"')
# Numbers below one (scales, opacities) and the pixels of images keep all their digits.
_COORDINATE = re.compile(r"(?<![\w.+/])([1-9]\d*\.\d\d)\d+(?![\w+/])")


def compact(svg: str) -> str:
    """SVG without document type, comments and metadata, coordinates to 0.01 of a point.

    Attributes stand in single quotes where they can, which an address need not escape.
    """
    svg = _COMMENT.sub("", _HEAD.sub("", svg))
    svg = _TAG_GAP.sub("", _SPACE.sub(" ", svg))
    svg = _STYLED.sub(lambda found: _STYLE_GAP.sub("", found[0]), svg)
    svg = _COORDINATE.sub(r"\1", svg)
    return svg if "'" in svg else svg.replace('"', "'")
