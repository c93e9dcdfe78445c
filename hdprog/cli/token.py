"""`hdprog token`: tokens of the upload service's API."""

from __future__ import annotations

from typing import Annotated

import typer

from hdprog.cli.web_extra import Data, DatabaseUrl, Role, data_folder, needs_web, store_folder
from hdprog.errors import UsageError

token = typer.Typer(no_args_is_help=True, help="Tokens of the upload service's API.")
Name = Annotated[str, typer.Argument(metavar="NAME", help="Name of the program that uses it.")]


@token.command("add")
@needs_web
def add(
    name: Name, role: Role = "engineer", data: Data = None, database: DatabaseUrl = None
) -> None:
    """Make a token and print it alone; it is shown this once."""
    from hdprog.store import accounts
    from hdprog.store.audit import COMMAND_LINE
    from hdprog.store.store import open_store

    wanted = accounts.role_named(role)
    with open_store(data_folder(data), database) as store:
        with store.writing() as session:
            text = accounts.add_token(session, COMMAND_LINE, name, wanted)
        typer.echo(text)


@token.command("revoke")
@needs_web
def revoke(name: Name, data: Data = None, database: DatabaseUrl = None) -> None:
    """Make all tokens of a name worthless."""
    from hdprog.store import accounts
    from hdprog.store.audit import COMMAND_LINE
    from hdprog.store.store import open_store

    with open_store(store_folder(data), database) as store:
        with store.writing() as session:
            known = [one for one in accounts.tokens(session) if one.name == name]
            found = [one for one in known if one.revoked_at is None]
            if not found:
                raise UsageError(f"NAME: found no token {name!r}; see `hdprog token list`")
            for one in found:
                accounts.revoke_token(session, COMMAND_LINE, one)
        typer.echo(f"Tokens revoked: {len(found)}")


@token.command("list")
@needs_web
def list_tokens(data: Data = None, database: DatabaseUrl = None) -> None:
    """List the tokens by name; their text is not kept."""
    from hdprog.store import accounts
    from hdprog.store.store import open_store

    with open_store(store_folder(data), database) as store, store.reading() as session:
        for one in accounts.tokens(session):
            state = "revoked" if one.revoked_at else one.role
            typer.echo(f"{one.name:<30} {state:<10} made {one.created_at:%Y-%m-%d}")
