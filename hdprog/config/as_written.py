"""A value of a TOML file, as the file has it: what a message quotes can then be looked up there."""

from __future__ import annotations

__all__ = ["as_written"]


def as_written(value: object) -> str:
    """Write a value as in TOML (``true``, ``2026-01-01``), and not as in Python.

    Parameters
    ----------
    value : what the TOML reader made of it
    """
    match value:
        case bool():
            return str(value).lower()
        case str():
            return repr(value)
        case list() | tuple():
            return f"[{', '.join(map(as_written, value))}]"
        case dict():
            entries = ", ".join(f"{key} = {as_written(entry)}" for key, entry in value.items())
            return f"{{{entries}}}"
        case None:  # From JSON: TOML has none.
            return "null"
        case _:
            return str(value)
