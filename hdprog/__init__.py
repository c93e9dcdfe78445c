"""Condition and remaining service life of strain wave gears, with the uncertainty said.

The names below are imported when they are first used (PEP 562), so that `import hdprog` costs
nothing numeric.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hdprog.backtesting import backtest as backtest
    from hdprog.comparing import compare as compare
    from hdprog.config import Drive as Drive
    from hdprog.config import read_drive as read_drive
    from hdprog.data.loop import Loop as Loop
    from hdprog.data.readers import read_loop as read_loop
    from hdprog.physics.drive_model import predict as predict
    from hdprog.workflow import explain as explain
    from hdprog.workflow import fit as fit
    from hdprog.workflow import run as run

__version__ = "0.1.0"

_HOMES = {
    "Drive": "hdprog.config",
    "Loop": "hdprog.data.loop",
    "backtest": "hdprog.backtesting",
    "compare": "hdprog.comparing",
    "explain": "hdprog.workflow",
    "fit": "hdprog.workflow",
    "predict": "hdprog.physics.drive_model",
    "read_drive": "hdprog.config",
    "read_loop": "hdprog.data.readers",
    "run": "hdprog.workflow",
}

__all__ = [  # noqa: RUF022 - in the order of use
    "__version__",
    "Drive",
    "Loop",
    "read_drive",
    "read_loop",
    "predict",
    "fit",
    "explain",
    "compare",
    "run",
    "backtest",
]


def __getattr__(name: str) -> Any:
    """Import a public name from its home on first use."""
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module 'hdprog' has no attribute {name!r}")
    value = getattr(import_module(home), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Name what can be imported, whether it has been yet or not."""
    return sorted({*globals(), *_HOMES})
