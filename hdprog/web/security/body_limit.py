"""A limit on what a request brings, kept while it streams in."""

from __future__ import annotations

from collections.abc import Callable

from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

Refuse = Callable[[Request, int, str], Response]
_HEARD_OUT = 4
"""A body of up to so many times the limit is thrown away to its end before it is refused: a browser
that still sends does not look at an answer."""

_FORMS = ("multipart/form-data", "application/x-www-form-urlencoded")
_MOST_BESIDE = 1_000_000
"""Bytes of a body that is no form: JSON is taken apart in memory, before it is known who asks."""


class _TooLargeError(Exception):
    """The body went over the limit."""


class BodyLimit:
    """Refuse bodies over a size: by what they claim at once, else as soon as they get there.

    Parameters
    ----------
    app : what lies behind
    most : bytes of a form; of anything else at most a megabyte
    refuse : makes the answer of a request, a status and words
    """

    def __init__(self, app: ASGIApp, most: int, refuse: Refuse) -> None:
        self.app, self.most, self.refuse = app, most, refuse

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, counting."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        form = headers.get("content-type", "").lower().startswith(_FORMS)
        most = self.most if form else min(self.most, _MOST_BESIDE)
        claimed = headers.get("content-length", "0")
        if not claimed.isdecimal() or int(claimed) > most:
            if claimed.isdecimal() and int(claimed) <= _HEARD_OUT * most:
                await _hear_out(receive)
            await self._refuse(scope, receive, send, most, form)
            return
        seen, begun, over = 0, False, False

        async def counted() -> Message:
            nonlocal seen, over
            message = await receive()
            seen += len(message.get("body", b""))
            if seen > most:
                over = True
                raise _TooLargeError
            return message

        async def passed(message: Message) -> None:
            nonlocal begun
            if over and not begun:
                return  # what lies behind took the end of the stream for a mistake in it
            begun = True
            await send(message)

        try:
            await self.app(scope, counted, passed)
        except _TooLargeError:
            if begun:
                raise
        if over and not begun:
            await self._refuse(scope, receive, send, most, form)

    async def _refuse(
        self, scope: Scope, receive: Receive, send: Send, most: int, form: bool
    ) -> None:
        advice = "Send records as multipart/form-data."
        if form:
            advice = (
                "Upload one test at a time, pack it with gzip or keep every tenth row; whoever "
                "runs the server can raise --max-upload-mb."
            )
        words = f"request: found more than {most / 1e6:g} MB; expected at most that. {advice}"
        answer = self.refuse(Request(scope), 413, words)
        answer.headers["connection"] = "close"
        await answer(scope, receive, send)


async def _hear_out(receive: Receive) -> None:
    """Take a body in, keeping nothing of it."""
    while (message := await receive())["type"] == "http.request" and message.get("more_body"):
        pass
