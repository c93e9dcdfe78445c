"""The small picture of a figure's course in a list of drives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from hdprog.reporting.rounding import plain, significant

_WIDTH, _HEIGHT, _EDGE = 120, 32, 4
_LIMIT_DIGITS = 4  # of a limit that is converted to the reader's unit


def sparkline(course: Mapping[str, Any]) -> Markup:
    """Draw the tests' medians and the limit as an inline SVG; nothing for fewer than two tests.

    Parameters
    ----------
    course : name, unit, points and limit, as `hdprog.reporting.fleet_words.Course` has them
    """
    points = course.get("points", [])
    if len(points) < 2:
        return Markup("")
    limit = float(course["limit"])
    hours = [float(at) for at, _ in points]
    values = [float(value) for _, value in points]
    low, high = min(*values, limit), max(*values, limit)
    span = (high - low) or 1.0
    wide = (max(hours) - min(hours)) or 1.0

    def x(at: float) -> float:
        return _EDGE + (_WIDTH - 2 * _EDGE) * (at - min(hours)) / wide

    def y(value: float) -> float:
        return _HEIGHT - _EDGE - (_HEIGHT - 2 * _EDGE) * (value - low) / span

    path = " ".join(f"{x(at):.1f},{y(value):.1f}" for at, value in zip(hours, values, strict=True))
    words = (
        f"{course['name']}: {significant(values[0])} to {significant(values[-1])} {course['unit']} "
        f"over {len(values)} tests, limit {plain(float(f'{limit:.{_LIMIT_DIGITS}g}'))}"
    )
    return Markup(
        '<svg class="spark" width="{w}" height="{h}" viewBox="0 0 {w} {h}" role="img" '
        'aria-label="{words}"><title>{words}</title>'
        '<line class="limit" x1="0" x2="{w}" y1="{at:.1f}" y2="{at:.1f}"/>'
        '<polyline points="{path}"/><circle cx="{cx:.1f}" cy="{cy:.1f}" r="2.5"/></svg>'
    ).format(
        w=_WIDTH,
        h=_HEIGHT,
        words=words,
        at=y(limit),
        path=path,
        cx=x(hours[-1]),
        cy=y(values[-1]),
    )
