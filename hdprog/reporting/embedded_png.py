"""Dense marks inside an SVG are pixels of few colours: stored with a palette they weigh a third."""

from __future__ import annotations

import base64
import io
import re

from PIL import Image

_COLOURS = 64
_EMBEDDED = re.compile(r"data:image/png;base64,([A-Za-z0-9+/=\s]+)")


def with_palettes(svg: str) -> str:
    """SVG with each embedded PNG stored with a palette, where that is smaller."""
    return _EMBEDDED.sub(_smaller, svg)


def _smaller(found: re.Match[str]) -> str:
    before = base64.b64decode(found[1])
    image = Image.open(io.BytesIO(before)).convert("RGBA")
    few = image.quantize(_COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    few.save(buffer, format="png", optimize=True)
    after = min(before, buffer.getvalue(), key=len)
    return "data:image/png;base64," + base64.b64encode(after).decode()
