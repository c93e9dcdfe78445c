"""Places of workers: freed by death, taken again after a cut, never held twice."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import cast

import pytest

from hdprog.service.slots import DatabasePlaces, Hold, places_of, taken_slot
from hdprog.store.database import normalised
from hdprog.store.store import Store
from tests.service.places import is_free
from tests.service.test_queue import wait_for
from tests.store.postgres import cut_all


@pytest.mark.postgres
def test_a_place_is_taken_again_unless_another_was_first(postgres_url: str) -> None:
    places = DatabasePlaces(normalised(postgres_url))
    with places.hold("here-1") as first:
        assert first is not None
        cut_all(postgres_url)
        assert not first.lost()
        assert not is_free(places, "here-1")
        cut_all(postgres_url)
        with places.hold("here-1") as second:
            assert second is not None
            assert first.lost()
            assert not second.lost()


def test_places_are_freed_by_death(store: Store) -> None:
    code = (
        "import sys, time; from pathlib import Path; from hdprog.service.slots import *\n"
        "from hdprog.store.store import Store\n"
        "with taken_slot(places_of(Store(Path(sys.argv[1]), sys.argv[2]))) as (name, hold):\n"
        "    print(name, flush=True); time.sleep(3600)"
    )
    other = subprocess.Popen(
        [sys.executable, "-c", code, str(store.files.root), store.database.url],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert other.stdout is not None
    first = other.stdout.readline().strip()
    places = places_of(store)
    with taken_slot(places) as (second, own):
        assert first != second
        assert not own.lost()
        with places.hold(first) as hold:
            assert hold is None
        other.kill()
        other.wait()
        other.stdout.close()
        wait_for(lambda: is_free(places, first))


class Counted:
    """Places of which the first so many are held by others."""

    def __init__(self, held: int) -> None:
        self.held, self.asked = held, 0

    @contextmanager
    def hold(self, name: str) -> Iterator[Hold | None]:
        self.asked += 1
        yield None if self.asked <= self.held else cast(Hold, name)


def test_as_many_workers_stand_on_a_machine_as_are_said() -> None:
    with taken_slot(Counted(511)) as (name, _):
        assert name.endswith("-512")
    with pytest.raises(RuntimeError, match="more than 512 workers"), taken_slot(Counted(512)):
        pass
