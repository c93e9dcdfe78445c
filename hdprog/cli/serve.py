"""`hdprog serve`: the upload page, with workers beside it."""

from __future__ import annotations

import asyncio
import ipaddress
import math
import os
import secrets
import signal
import tempfile
from contextlib import ExitStack
from importlib.resources import as_file
from pathlib import Path
from typing import Annotated

import typer

from hdprog.cli.exits import ending_signals
from hdprog.cli.web_extra import DaskAddress, Data, DatabaseUrl, data_folder, needs_web
from hdprog.errors import UsageError
from hdprog.shipped import shipped

_DEMO = ("wearing-csf-25-80", "healthy-csf-25-80")


@needs_web
def serve(
    host: Annotated[str, typer.Option("--host", help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port.")] = 8000,
    data: Data = None,
    database: DatabaseUrl = None,
    workers: Annotated[
        int, typer.Option("--workers", min=0, help="Jobs that run here at the same time.")
    ] = 1,
    dask: DaskAddress = None,
    max_upload_mb: Annotated[
        float,
        typer.Option("--max-upload-mb", help="Most that a request may bring, from 0.1 MB on."),
    ] = 64.0,
    no_login: Annotated[
        bool, typer.Option("--no-login", help="Pages without login, on a loopback address only.")
    ] = False,
    proxy: Annotated[
        str | None,
        typer.Option(
            "--proxy",
            metavar="ADDRESS",
            help="Believe what a proxy at this address says of browsers (X-Forwarded-…).",
        ),
    ] = None,
    demo: Annotated[
        bool,
        typer.Option(
            "--demo", help="Start with the shipped drives, in a place that goes when it ends."
        ),
    ] = False,
) -> None:
    """Serve the upload page.

    Accounts are made with `hdprog user add NAME`, tokens of the API with `hdprog token add NAME`.
    """
    import uvicorn

    from hdprog.parallel import cores
    from hdprog.service.crew import crew
    from hdprog.service.web_settings import WebSettings
    from hdprog.store.store import open_store

    if no_login and not _is_loopback(host):
        raise UsageError(
            f"--no-login: found it with --host {host}, expected a loopback address such as "
            "127.0.0.1: anybody who reaches the port could change everything. Leave one of the "
            "two out."
        )
    if demo and (data is not None or database is not None):
        raise UsageError(
            "--demo: found it with a data folder or a database (--data, --database, or HDPROG_DATA "
            "or HDPROG_DATABASE in the environment), expected neither: its drives, its account and "
            "its settings would be among your own. Leave one of the two out."
        )
    if not 0.1 <= max_upload_mb < math.inf:  # NaN, too
        raise UsageError(
            f"--max-upload-mb: found {max_upload_mb:g}, expected a number of megabytes from 0.1 "
            "on. Give one such as 300."
        )
    if proxy is not None:
        _require_proxy(proxy)
    _require_free(host, port)
    with ExitStack() as held:
        if demo:
            place = held.enter_context(tempfile.TemporaryDirectory(prefix="hdprog-demo-"))
            data = Path(place)
        folder = data_folder(data)
        with open_store(folder, database) as store:
            if demo:
                _fill(store)
            typer.echo(f"Data: {store.files.root}", err=True)
        settings = WebSettings(
            data=folder,
            url=database,
            login=not no_login,
            max_upload_mb=max_upload_mb,
            readers=max(1, min(2, cores())),
            hosts=("localhost", "127.0.0.1", "[::1]", host) if no_login else (),
        )
        settings.to_environment()
        order = ["--data", str(folder)]
        order += ["--dask", dask] if dask else []
        order += ["--processes", str(max(1, cores() // max(1, workers)))]
        if database:
            os.environ["HDPROG_DATABASE"] = database  # a password is not for the list of processes
        held.enter_context(crew(workers, order))
        # Uvicorn ends well on SIGTERM, and knows no other sign but Ctrl-C.
        for sign in ending_signals():
            signal.signal(sign, lambda _number, _frame: signal.raise_signal(signal.SIGTERM))
        # It then raises that again: nothing is left to be done for it.
        signal.signal(signal.SIGTERM, lambda _number, _frame: None)
        uvicorn.run(
            # By name: the command line and the pages do not know each other.
            "hdprog.web.app:from_environment",
            factory=True,
            host=host,
            port=port,
            proxy_headers=proxy is not None,
            forwarded_allow_ips=proxy,
            server_header=False,
            log_level="info",
            timeout_graceful_shutdown=5,
        )


def _require_free(host: str, port: int) -> None:
    """Refuse an address that cannot be listened on, before anything is made or started."""

    async def bind() -> None:
        loop = asyncio.get_running_loop()
        server = await loop.create_server(asyncio.Protocol, host, port, start_serving=False)
        server.close()

    try:
        asyncio.run(bind())
    except (OSError, UnicodeError) as error:
        raise UsageError(
            f"--host, --port: found {host}, port {port}, where nothing can listen ({error}), "
            "expected an address of this machine and a port that is free. End what listens there, "
            "or give another --port or --host."
        ) from error


def _require_proxy(given: str) -> None:
    """Refuse what is no address of a proxy: it would be passed over, and each browser be it."""
    try:
        for one in () if given == "*" else given.split(","):
            ipaddress.ip_network(one.strip())
    except ValueError as error:
        raise UsageError(
            f"--proxy: found {given!r}, expected the address of the proxy or of its network, "
            "several between commas, or * for any. Give it such as 127.0.0.1 or 10.0.0.0/8."
        ) from error


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def _fill(store: object) -> None:
    """Take the shipped drives in and make an account that may do everything."""
    from hdprog.service.importing import take_in_folder
    from hdprog.service.queue import Queue
    from hdprog.store import accounts
    from hdprog.store.audit import COMMAND_LINE
    from hdprog.store.settings import ServiceSettings, change_settings
    from hdprog.store.store import Store

    assert isinstance(store, Store)
    queue = Queue(store.database.url)
    queue.prepare()
    with as_file(shipped("datasets")) as datasets:
        for name in _DEMO:
            take_in_folder(store, queue, datasets / name)
    queue.close()
    with store.writing() as session:
        password = secrets.token_urlsafe(9)
        accounts.add_user(session, COMMAND_LINE, "demo", password, "admin")
        change_settings(session, COMMAND_LINE, ServiceSettings("Demonstration", quick=True))
    typer.echo(f"Log in as demo with the password {password}", err=True)
