"""A limit on the names that a server without a login answers to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import ASGIApp, Receive, Scope, Send

Refuse = Callable[[Request, int, str], Response]


class KnownHost:
    """Refuse requests that ask for the server by another name, as a page elsewhere may have it.

    Parameters
    ----------
    app : what lies behind
    names : by which the server may be asked for; IPv6 addresses with or without brackets
    refuse : makes the answer of a request, a status and words
    """

    def __init__(self, app: ASGIApp, names: Sequence[str], refuse: Refuse) -> None:
        self.app, self.refuse = app, refuse
        self.names = tuple(dict.fromkeys(name.strip("[]").lower() for name in names))

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on if it names this server."""
        if scope["type"] == "http":
            given = Headers(scope=scope).get("host", "")
            if _name(given) not in self.names:
                await self._refusal(scope, given)(scope, receive, send)
                return
        await self.app(scope, receive, send)

    def _refusal(self, scope: Scope, given: str) -> Response:
        known = ", ".join(f"[{name}]" if ":" in name else name for name in self.names)
        words = (
            f"Host: found {given[:80]!r}; expected one of {known}, as this server asks for no "
            "login. Open it by one of these names. To be reached by another, it must be started "
            "with accounts, not with --no-login."
        )
        return self.refuse(Request(scope), 400, words)


def _name(host: str) -> str | None:
    """Name or address without its port; None where it is none."""
    try:
        return urlsplit(f"//{host}").hostname
    except ValueError:
        return None
