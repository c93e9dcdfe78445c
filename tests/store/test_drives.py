"""Drives: declared, changed, listed worst first."""

from __future__ import annotations

from typing import Any

import pytest

from hdprog.errors import BadInputError
from hdprog.store.audit import COMMAND_LINE, trail
from hdprog.store.drives import (
    DriveExistsError,
    add_drive,
    change_drive,
    content_of,
    find_drive,
    fleet,
)
from hdprog.store.store import Store
from tests.store.samples import add_sample, content

NAMES = ("Achse ä\u2013ö", "Achse a\u0308\u2014o", "\u8a66 3", "\u0430-1", "x", "_a.b+c-d")


def test_what_is_declared_comes_back(store: Store) -> None:
    said = content(alpha_deg=30.0) | {"forecast": {"horizon_hours": 9000.0}}
    with store.writing() as session:
        add_drive(session, COMMAND_LINE, said)
    with store.reading() as session:
        drive = find_drive(session, "cell3-axis2")
        assert drive is not None
        assert content_of(drive) == said


def test_an_id_is_taken_once(store: Store) -> None:
    with store.writing() as session:
        add_sample(session)
    with store.writing() as session, pytest.raises(DriveExistsError, match="already"):
        add_sample(session)


@pytest.mark.parametrize(
    "name",
    [
        "../up",
        "a/b",
        "a\\b",
        "<script>",
        "",
        " ",
        ".",
        "..",
        "a\nb",
        "x" * 101,
        "con:",
        "new",
        "New",
        "a\u202egpj.b",  # read from the right
        "a\u200bb",
        "a\uff0fb",  # a wide slash
        "\u0301a",
        ".hidden",
        "ends.",
        "a%2fb",
        "a?b",
        "a#b",
        "a&b",
        'a"b',
    ],
)
def test_ids_that_are_no_names(store: Store, name: str) -> None:
    with store.writing() as session, pytest.raises(BadInputError):
        add_drive(session, COMMAND_LINE, content(name))


@pytest.mark.parametrize("name", NAMES)
def test_ids_that_a_run_takes_are_taken(store: Store, name: str) -> None:
    with store.writing() as session:
        assert add_drive(session, COMMAND_LINE, content(name)).name == name


@pytest.mark.parametrize("prior", ["/etc/passwd", "x.toml", "../priors/generic"])
def test_no_prior_is_read_from_a_path(store: Store, prior: str) -> None:
    said = content() | {"prior": {"file": prior}}
    with store.writing() as session, pytest.raises(BadInputError, match="shipped prior"):
        add_drive(session, COMMAND_LINE, said)


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({"prior": {"file": "csf-99-80"}}, "csf-99-80"),
        ({"limits": [{"quantity": "K1_Nm_per_rad", "below": 9000.0}]}, "no T1 and T2"),
    ],
)
def test_what_an_analysis_would_refuse_is_refused_at_once(
    store: Store, said: dict[str, Any], words: str
) -> None:
    declared = content(model=None) | said
    with store.writing() as session, pytest.raises(BadInputError, match=words):
        add_drive(session, COMMAND_LINE, declared)


def test_limits_change_and_the_trail_tells(store: Store) -> None:
    with store.writing() as session:
        add_sample(session)
    after: dict[str, Any] = content() | {"limits": [{"quantity": "preload_Nm", "below": 40.0}]}
    with store.writing() as session:
        drive = find_drive(session, "cell3-axis2")
        assert drive is not None
        change_drive(session, COMMAND_LINE, drive, after)
    with store.reading() as session:
        drive = find_drive(session, "cell3-axis2")
        assert drive is not None
        assert content_of(drive)["limits"] == after["limits"]
        newest = trail(session)[0]
        assert newest.action == "drive changed"
        assert newest.details["before"]["limits"] == content()["limits"]


def test_the_fleet_is_worst_first_and_paged(store: Store) -> None:
    with store.writing() as session:
        for number, (rank, hours) in enumerate([(2, 50.0), (0, -0.9), (4, 9.0), (2, 10.0)]):
            drive = add_sample(session, f"d{number}")
            drive.rank, drive.rank_hours, drive.status = rank, hours, f"s{rank}"
    with store.reading() as session:
        assert [d.name for d in fleet(session).drives] == ["d1", "d3", "d0", "d2"]
        second = fleet(session, page=2, size=3)
        assert [d.name for d in second.drives] == ["d2"]
        assert second.counts == {"s0": 1, "s2": 2, "s4": 1}
        assert [d.name for d in fleet(session, status="s2").drives] == ["d3", "d0"]
        assert fleet(session, search="D1").found == 1
        assert fleet(session, search="%").found == 0
