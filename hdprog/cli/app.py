"""The `hdprog` command: its sub-commands and what holds for all of them."""

from __future__ import annotations

from typing import Annotated

import typer

from hdprog import __version__
from hdprog.cli.backtest import backtest
from hdprog.cli.check import check
from hdprog.cli.compare import compare
from hdprog.cli.demo import demo
from hdprog.cli.exits import GuardedGroup
from hdprog.cli.explain import explain
from hdprog.cli.fit import fit
from hdprog.cli.fleet import fleet
from hdprog.cli.prior import prior
from hdprog.cli.reproduce_paper import reproduce_paper
from hdprog.cli.run import run
from hdprog.cli.serve import serve
from hdprog.cli.simulate import simulate
from hdprog.cli.store import store
from hdprog.cli.token import token
from hdprog.cli.user import user
from hdprog.cli.worker import worker

EPILOG = (
    "Exit codes: 0 done; 1 a mistake in hdprog; 2 wrong usage; 3 bad input, nothing written; "
    "4 done, but a fit did not converge (the report says so); broken off: 129 its terminal closed, "
    "130 interrupted, 141 nobody reads its output, 143 told to end."
)

app = typer.Typer(
    cls=GuardedGroup,
    epilog=EPILOG,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help, which starts faster and reads the same in a file
    pretty_exceptions_enable=False,
)


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"hdprog {__version__}")
        raise typer.Exit


@app.callback()
def _describe(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    """Condition and remaining service life of strain wave gears from torque and torsion loops."""


_COMMANDS = (
    demo,
    check,
    fit,
    explain,
    compare,
    run,
    fleet,
    backtest,
    simulate,
    reproduce_paper,
    serve,
    worker,
)
for _command in _COMMANDS:
    app.command(epilog=EPILOG)(_command)
for _name, _group in {"prior": prior, "user": user, "token": token, "store": store}.items():
    app.add_typer(_group, name=_name, epilog=EPILOG)
    for _command_of_group in _group.registered_commands:
        _command_of_group.epilog = EPILOG
