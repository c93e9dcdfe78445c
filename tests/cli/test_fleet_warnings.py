"""What a fleet warns of is on the screen, beside JSON that stays JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hdprog import fleet_run
from hdprog.reporting.fleet_index import fleet_drive, shared_ids
from hdprog.reporting.summary import summary_json
from tests.cli.conftest import Invoke
from tests.reporting import drives


@pytest.mark.parametrize("as_json", [False, True])
def test_an_id_that_two_drives_have(
    as_json: bool, invoke: Invoke, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed = [fleet_drive(name, name, summary_json(drives.healthy())) for name in ("a", "b")]
    content = {"warnings": shared_ids(listed), "drives": listed, "left_out": []}
    ran = fleet_run.Fleet(Path("out"), content)
    monkeypatch.setattr(fleet_run, "run_fleet", lambda *_, **__: ran)
    shown = invoke("fleet", ".", *(["--json"] if as_json else []))
    assert shown.exit_code == 0
    assert shown.stderr.startswith("Warning: The drives in a and b have the same id")
    if as_json:
        assert json.loads(shown.stdout) == content
