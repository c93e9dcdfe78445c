"""How to install the packages that only some commands need."""

from __future__ import annotations

import shlex
import sys


def install_words(extra: str) -> str:
    """Command that adds an extra to the Python that runs now, as the README installs.

    Parameters
    ----------
    extra : one of the optional dependencies in pyproject.toml, "web" say
    """
    python = shlex.quote(sys.executable or "python3")
    return f"in the checkout, {python} -m pip install -c constraints.txt '.[{extra}]'"
