"""The written pages: their links lead somewhere, and what they show is as the code has it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from hdprog.config import drive_from_mapping
from hdprog.physics.parameters import PARAMETERS

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*ROOT.glob("*.md"), *ROOT.glob("reports/guide/*.md"), *ROOT.glob("datasets/*/*.md")]
FILES = (ROOT / "reports/guide/files.md").read_text("utf-8")


def anchors(text: str) -> set[str]:
    """Names that a page's headings have in links to them."""
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", line.lower()).replace(" ", "-") for line in headings}


def dead(page: Path) -> list[str]:
    """Links and paths of a page that lead nowhere."""
    text = page.read_text("utf-8")
    found = []
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        if link.startswith("https://"):
            continue
        if not target.exists() or (anchor and anchor not in anchors(target.read_text("utf-8"))):
            found.append(link)
    for module in re.findall(r"python -m (tests[\w.]+)", text):
        place = ROOT.joinpath(*module.split("."))
        if not place.with_suffix(".py").exists() and not (place / "__main__.py").exists():
            found.append(module)
    named = re.findall(r"\b(?:tests|hdprog|priors)/[\w/]+\.(?:py|json|toml)\b", text)
    return found + [path for path in named if not (ROOT / path).exists()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_and_paths_lead_somewhere(page: Path) -> None:
    assert dead(page) == []


def test_what_leads_nowhere_is_seen(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "# A head\n[a](#a-head) [b](#b) [c](c.md)\n`python -m tests.none` tests/none.py", "utf-8"
    )
    assert dead(page) == ["#b", "c.md", "tests.none", "tests/none.py"]


def test_the_drive_shown_is_read() -> None:
    [shown] = re.findall(r"```toml\n(.*?)```", FILES, re.DOTALL)
    drive = drive_from_mapping(tomllib.loads(shown))
    assert (drive.id, len(drive.limits)) == ("cell3-axis2", 2)


def test_the_eight_parameters_are_all_there_with_their_units() -> None:
    section = FILES.partition("## The eight parameters")[2].partition("\n## ")[0]
    rows = dict(re.findall(r"^\| `(\w+)` \| (\S+) \|", section, re.MULTILINE))
    units = {one.name: one.unit.replace("-", "–") for one in PARAMETERS}
    assert rows == units
