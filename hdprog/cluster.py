"""A Dask cluster, where one is given: its own scheduler, never one of ours."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import Any

from hdprog.errors import UsageError
from hdprog.extras import install_words


@contextmanager
def dask_client(address: str) -> Iterator[Any]:
    """Client of a Dask scheduler.

    Parameters
    ----------
    address : of the scheduler, tcp://HOST:8786

    Raises
    ------
    UsageError
        where Dask is not installed or its scheduler does not answer
    """
    try:
        from distributed import Client
    except ModuleNotFoundError as error:
        raise UsageError(
            "--dask: found an address and no Dask, expected the package distributed. Install it: "
            + install_words("dask")
        ) from error
    try:
        _require_host_and_port(address)
        client = Client(address, timeout="10s", set_as_default=False)
    except TypeError as error:  # of Dask itself, where it has no certificates for the address
        raise UsageError(
            f"--dask: found {address} and nothing to connect with ({error}), expected the "
            "certificates in Dask's configuration (distributed.comm.tls) for an address with "
            "tls:// or wss://. Name them there, or give an address with tcp://."
        ) from error
    except (OSError, ValueError) as error:
        raise UsageError(
            f"--dask: found no scheduler at {address} ({error}), expected one that takes "
            "connections. Start `dask scheduler` there, or leave --dask out."
        ) from error
    with client:
        yield client


def lost() -> tuple[type[Exception], ...]:
    """What a task raises that the cluster has lost, with its worker or with the scheduler."""
    from distributed import KilledWorker

    return KilledWorker, CancelledError


def _require_host_and_port(address: str) -> None:
    """Refuse what is no address before a client is made of it, which would not end by itself.

    Raises
    ------
    ValueError
        for a scheme that Dask does not know, or an address without a port
    """
    from distributed.comm.addressing import get_address_host

    if not address.startswith(("ws://", "wss://")):  # which have a port of their own
        get_address_host(address)
