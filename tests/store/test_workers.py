"""Whether a worker lives is told from its marks."""

from __future__ import annotations

from datetime import timedelta

import pytest

from hdprog.store import workers
from hdprog.store.store import Store
from hdprog.store.tables.base import now


def test_a_worker_lives_while_it_leaves_marks(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    with store.writing() as session:
        workers.mark(session, "rig-2")
        workers.mark(session, "rig-1")
        workers.mark(session, "rig-1")
    with store.reading() as session:
        assert workers.alive(session) == ["rig-1", "rig-2"]
    with store.writing() as session:
        workers.forget(session, "rig-2")
        workers.forget(session, "rig-3")
    with store.reading() as session:
        assert workers.alive(session) == ["rig-1"]
    later = now() + timedelta(minutes=2)
    monkeypatch.setattr(workers, "now", lambda: later)
    with store.reading() as session:
        assert workers.alive(session) == []
