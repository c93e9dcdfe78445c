"""ArviZ, imported when first used and without its notice of a coming rewrite."""

from __future__ import annotations

import importlib
import warnings
from typing import Any


def arviz() -> Any:
    """The module arviz; it takes more than a second to import."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)
        return importlib.import_module("arviz")
