"""Tables of the comparisons in Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def updated(page: str, found: Mapping[str, Any]) -> str:
    """The guide page with its tables made anew."""
    details = "\n\n".join(_record(name, entry) for name, entry in found.items())
    for mark, text in (("table", overview(found)), ("records", details)):
        begin, end = f"<!-- {mark} -->", f"<!-- end of {mark} -->"
        head, _, rest = page.partition(begin)
        _, _, tail = rest.partition(end)
        page = f"{head}{begin}\n{text}\n{end}{tail}"
    return page


def overview(found: Mapping[str, Any]) -> str:
    """Held-out error in µrad, bold where level with the best."""
    names: dict[str, str] = {}
    for entry in found.values():
        names |= {one["id"]: one["words"] for one in entry["models"]}
    head = f"| model | {' | '.join(found)} |"
    lines = [head, "|---|" + "---:|" * len(found)]
    for model_id, words in sorted(names.items(), key=lambda item: _mean_rank(found, item[0])):
        cells = []
        for entry in found.values():
            one = next((m for m in entry["models"] if m["id"] == model_id), None)
            cells.append("–" if one is None else _error(one))
        lines.append(f"| {words} | {' | '.join(cells)} |")
    floors = [_micro(entry["noise_floor_rad"]) for entry in found.values()]
    lines.append(f"| *noise floor* | {' | '.join(floors)} |")
    return "\n".join(lines)


def _mean_rank(found: Mapping[str, Any], model_id: str) -> float:
    ranks = [
        [one["id"] for one in entry["models"]].index(model_id) / len(entry["models"])
        for entry in found.values()
        if any(one["id"] == model_id for one in entry["models"])
    ]
    return sum(ranks) / len(ranks)


def _error(one: Mapping[str, Any]) -> str:
    text = _micro(one["heldout_rmse_rad"]) + ("" if one["converged"] else "\\*")
    return f"**{text}**" if one["level"] else text


def _micro(value: float) -> str:
    """A value in rad as µrad, to three digits."""
    micro = float(f"{1e6 * value:.3g}")
    return f"{micro:,.0f}".replace(",", " ") if micro >= 100 else f"{micro:.3g}"


def _stiffness(value: float | None) -> str:
    return "–" if value is None else f"{float(f'{value:.3g}'):,.0f}".replace(",", " ")


def _record(name: str, entry: Mapping[str, Any]) -> str:
    quick = ", quick" if entry["quick"] else ""
    lines = [
        f"### {name}",
        f"{entry['made']}: {entry['samples']} readings, noise floor "
        f"{1e6 * entry['noise_floor_rad']:.3g} µrad, cycle to {entry['amplitude_Nm']:.3g} Nm; "
        f"{entry['seconds']:.0f} s{quick}.",
        "",
        "| model | error | left out | behind in elpd | behind, left out | weight | width | "
        "stiffness |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    lines += [
        f"| {one['words']}{'' if one['converged'] else ' (not converged)'} | "
        f"{_micro(one['rmse_rad'])} | {_micro(one['heldout_rmse_rad'])} | "
        f"{one['elpd_difference']:.0f} ± {one['elpd_difference_se']:.0f} | "
        f"{one['heldout_elpd_difference']:.0f} ± {one['heldout_elpd_difference_se']:.0f} | "
        f"{one['stacking_weight']:.2f} | {abs(one['width_arcmin']):.2f} | "
        f"{_stiffness(one['stiffness_Nm_per_rad'])} |"
        for one in entry["models"]
    ]
    lines += [f"\nNot defined: {model}: {why}." for model, why in entry["left_out"].items()]
    return "\n".join(lines)
