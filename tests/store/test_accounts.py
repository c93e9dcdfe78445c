"""Accounts, tokens, sessions and throttling."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta

import pytest

from hdprog.errors import BadInputError
from hdprog.store import accounts, logins
from hdprog.store.audit import COMMAND_LINE, trail
from hdprog.store.store import Store
from hdprog.store.tables import SessionRow, TokenRow, UserRow
from hdprog.store.tables.base import now

PASSWORD = "four words do well"


def made(store: Store, name: str = "ada", role: accounts.Role = "admin") -> UserRow:
    with store.writing() as session:
        return accounts.add_user(session, COMMAND_LINE, name, PASSWORD, role)


def test_the_right_password_and_no_other(store: Store) -> None:
    user = made(store)
    assert accounts.verify(user, PASSWORD)
    assert not accounts.verify(user, PASSWORD + " ")
    assert not accounts.verify(None, PASSWORD)
    assert PASSWORD not in user.password_hash
    assert user.password_hash.startswith("$argon2id$")


@pytest.mark.parametrize("name", ["", "a b", "x" * 61, "a/b", "<b>"])
def test_names_that_cannot_be(store: Store, name: str) -> None:
    with pytest.raises(BadInputError, match="the name"):
        made(store, name)


def test_short_passwords_are_refused(store: Store) -> None:
    with store.writing() as session, pytest.raises(BadInputError, match="9 characters"):
        accounts.add_user(session, COMMAND_LINE, "ada", "x" * 9, "viewer")


def test_a_name_is_taken_once(store: Store) -> None:
    made(store)
    with pytest.raises(BadInputError, match="a second time"):
        made(store)


def test_a_name_is_taken_once_in_the_same_instant(store: Store) -> None:
    with ThreadPoolExecutor(1) as other:
        with store.writing() as session:
            accounts.add_user(session, COMMAND_LINE, "ada", PASSWORD, "admin")
            session.flush()
            second = other.submit(made, store)
            with pytest.raises(TimeoutError):
                second.result(1.0)
        with pytest.raises(BadInputError, match="a second time"):
            second.result()


def test_the_last_administrator_stays(store: Store) -> None:
    user = made(store)
    with store.writing() as session, pytest.raises(BadInputError, match="only administrator"):
        accounts.change_user(
            session, COMMAND_LINE, session.get_one(UserRow, user.id), "viewer", disabled=False
        )


def test_a_token_is_found_by_its_text_and_kept_as_a_digest(store: Store) -> None:
    with store.writing() as session:
        text = accounts.add_token(session, COMMAND_LINE, "ci", "engineer")
    with store.writing() as session:
        row = accounts.find_token(session, text)
        assert isinstance(row, TokenRow)
        assert text not in row.digest
        assert accounts.find_token(session, text + "x") is None
        accounts.revoke_token(session, COMMAND_LINE, row)
    with store.reading() as session:
        assert accounts.find_token(session, text) is None
        actions = [line.action for line in trail(session)]
        assert actions == ["token revoked", "token added"]


def test_sessions_end(store: Store) -> None:
    user = made(store)
    with store.writing() as session:
        text = logins.open_session(session, session.get_one(UserRow, user.id))
    with store.writing() as session:
        row = logins.find_session(session, text)
        assert row is not None
        row.seen_at = now() - logins.IDLE - timedelta(seconds=1)
    with store.reading() as session:
        assert logins.find_session(session, text) is None


def test_a_new_password_logs_out_everywhere(store: Store) -> None:
    user = made(store)
    with store.writing() as session:
        text = logins.open_session(session, session.get_one(UserRow, user.id))
    with store.writing() as session:
        known = session.get_one(UserRow, user.id)
        accounts.set_password(session, COMMAND_LINE, known, "another four words")
    with store.reading() as session:
        assert logins.find_session(session, text) is None
        assert session.query(SessionRow).count() == 0


def test_wrong_passwords_throttle_one_account_at_one_address(store: Store) -> None:
    for _ in range(10):
        with store.writing() as session:
            assert not logins.throttled(session, "ada", "10.0.0.1")
            logins.count_failure(session, "ada", "10.0.0.1")
    with store.reading() as session:
        assert logins.throttled(session, "ada", "10.0.0.1")
        assert not logins.throttled(session, "ada", "10.0.0.2")
        assert not logins.throttled(session, "bob", "10.0.0.1")
