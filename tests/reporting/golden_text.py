"""What a golden file holds of a report: its verdict, its structure and what its pictures find.

python -m tests.reporting.golden_text        writes all golden files anew; read their changes
"""

from __future__ import annotations

from pathlib import Path

from hdprog.reporting.build import build_report
from hdprog.reporting.verdict import verdict
from hdprog.results import DriveResult
from tests.reporting.page import Page, spaced
from tests.reporting.situations import SITUATIONS

FOLDER = Path(__file__).parent / "golden"


def golden_text(result: DriveResult) -> str:
    """Verdict in words, then headings with pictures and files in the order of the page."""
    said = verdict(result)
    lines = [f"[{said.status}] {said.label}", *said.sentences, ""]
    page = Page(build_report(result))
    for kind, text in page.outline:
        indent = "  " * (int(kind[1]) - 1) if kind.startswith("h") else "      "
        lines.append(f"{indent}{kind}: {' '.join(text.split())}")
    return spaced("\n".join(lines)) + "\n"


def path_of(name: str) -> Path:
    return FOLDER / f"{name}.txt"


if __name__ == "__main__":
    for name, make in SITUATIONS.items():
        path_of(name).write_text(golden_text(make()), "utf-8")
