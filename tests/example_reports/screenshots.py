"""README's pictures, taken of the example reports by a browser."""

from __future__ import annotations

import io
from pathlib import Path

from PIL import Image

from tests.browser import CHROMIUM, chromium
from tests.example_reports.build import REPORTS

_SHOTS = (
    ("wearing-drive", "report.png", "light", 1000, 1080, 1),
    ("wearing-drive", "report-phone.png", "dark", 390, 780, 2),
)
_COLOURS = 128


def take() -> list[Path]:
    """Take every picture; none, with words, where there is no browser."""
    if CHROMIUM is None:
        print("No Chromium browser is installed: README's pictures stay as they are.")
        return []
    missing = {name for name, *_ in _SHOTS if not (REPORTS / f"{name}.html").is_file()}
    if missing:
        print(f"README's pictures stay as they are: no report {', '.join(sorted(missing))} yet.")
        return []
    taken = []
    with chromium() as browser:
        for name, file, scheme, width, height, scale in _SHOTS:
            page = browser.new_page(
                viewport={"width": width, "height": height},
                color_scheme="dark" if scheme == "dark" else "light",
                device_scale_factor=scale,
            )
            page.goto((REPORTS / f"{name}.html").as_uri())
            path = REPORTS / "guide" / file
            image = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
            image.quantize(_COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)
            page.close()
            taken.append(path)
    return taken
