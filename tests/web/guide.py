"""Snippets of the page on running the service, so that what is tested is what is written there."""

from __future__ import annotations

import re
from pathlib import Path

_PAGE = Path(__file__).resolve().parents[2] / "reports" / "guide" / "serving.md"


def snippet(language: str) -> str:
    """Give the one block of a language."""
    [found] = re.findall(rf"```{language}\n(.*?)```", _PAGE.read_text("utf-8"), re.DOTALL)
    return str(found)
