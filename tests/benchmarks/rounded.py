"""Figures of results short enough to be checked in."""

from __future__ import annotations


def rounded(value: object, digits: int = 5) -> object:
    """A document of dicts and lists with its figures to so many significant digits."""
    if isinstance(value, dict):
        return {key: rounded(item, digits) for key, item in value.items()}
    if isinstance(value, list):
        return [rounded(item, digits) for item in value]
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value
