"""`hdprog user`: accounts of the upload service."""

from __future__ import annotations

import getpass
import sys
from typing import Annotated

import typer

from hdprog.cli.web_extra import Data, DatabaseUrl, Role, data_folder, needs_web, store_folder
from hdprog.errors import UsageError

user = typer.Typer(no_args_is_help=True, help="Accounts of the upload service.")
Name = Annotated[str, typer.Argument(metavar="NAME", help="Name of the account.")]


@user.command("add")
@needs_web
def add(
    name: Name, role: Role = "engineer", data: Data = None, database: DatabaseUrl = None
) -> None:
    """Make an account; the first one is an administrator.

    The password is asked for, or read as one line from standard input.
    """
    from hdprog.store import accounts
    from hdprog.store.audit import COMMAND_LINE
    from hdprog.store.store import open_store

    wanted = accounts.role_named(role)
    with open_store(data_folder(data), database) as store:
        password = _password()
        with store.writing() as session:
            first = not accounts.users(session)
            made = accounts.add_user(
                session, COMMAND_LINE, name, password, "admin" if first else wanted
            )
        typer.echo(f"Account {made.name}, role {made.role}")


@user.command("password")
@needs_web
def password(name: Name, data: Data = None, database: DatabaseUrl = None) -> None:
    """Give an account a new password."""
    from hdprog.store import accounts
    from hdprog.store.audit import COMMAND_LINE
    from hdprog.store.store import open_store

    with open_store(store_folder(data), database) as store:
        new = _password()
        with store.writing() as session:
            found = accounts.find_user(session, name)
            if found is None:
                raise UsageError(f"NAME: found no account {name!r}; see `hdprog user list`")
            accounts.set_password(session, COMMAND_LINE, found, new)
        typer.echo(f"Password of {found.name} changed")


@user.command("list")
@needs_web
def list_users(data: Data = None, database: DatabaseUrl = None) -> None:
    """List the accounts."""
    from hdprog.store import accounts
    from hdprog.store.store import open_store

    with open_store(store_folder(data), database) as store, store.reading() as session:
        for one in accounts.users(session):
            typer.echo(f"{one.name:<30} {one.role}{', switched off' if one.disabled else ''}")


def _password() -> str:
    """Ask for a password twice, or read it where nobody can be asked."""
    if not sys.stdin.isatty():
        return sys.stdin.readline().rstrip("\r\n")
    first = getpass.getpass("Password: ")
    if getpass.getpass("Once more: ") != first:
        raise UsageError("password: found two that differ; expected the same twice. Start again.")
    return first
