"""A limit on what a request brings, kept while it streams in: a small one for who is not known."""

from __future__ import annotations

from collections.abc import Callable

from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

Refuse = Callable[[Request, int, str], Response]
Stranger = Callable[[Request], Response | None]
_HEARD_OUT = 4
"""A body of up to so many times the limit is thrown away to its end before it is refused: a browser
that still sends does not look at an answer."""

_FORMS = ("multipart/form-data", "application/x-www-form-urlencoded")
_MOST_BESIDE = 1_000_000
"""Bytes of a body that is no form: JSON is taken apart in memory, before it is known who asks."""


_MOST_OF_STRANGERS = 65_536
"""Bytes that are taken in before it is asked who sends them: a form is put down on the disk as it
streams in, before what lies behind looks at who asks. A login is far smaller."""


class _RefusedError(Exception):
    """No more of the body is taken in."""


class BodyLimit:
    """Refuse bodies over a size: by what they claim at once, else as soon as they get there.

    Parameters
    ----------
    app : what lies behind
    most : bytes of a form; of anything else at most a megabyte
    refuse : makes the answer of a request, a status and words
    stranger : makes the answer to who is not known, None for others; it may wait for the database
    """

    def __init__(self, app: ASGIApp, most: int, refuse: Refuse, stranger: Stranger) -> None:
        self.app, self.most, self.refuse, self.stranger = app, most, refuse, stranger

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
            await _close(self._too_large(scope, most, form), scope, receive, send)
            return
        seen, ended, begun = 0, False, False
        refusal: Response | None = None

        async def counted() -> Message:
            nonlocal seen, ended, refusal
            message = await receive()
            before, ended = seen, not message.get("more_body", False)
            seen += len(message.get("body", b""))
            if seen > most:
                refusal = self._too_large(scope, most, form)
            elif before <= _MOST_OF_STRANGERS < seen:
                refusal = await run_in_threadpool(self.stranger, Request(scope))
            if refusal is not None:
                raise _RefusedError
            return message

        async def passed(message: Message) -> None:
            nonlocal begun
            if refusal is not None and not begun:
                return  # what lies behind took the end of the stream for a mistake in it
            begun = True
            await send(message)

        try:
            await self.app(scope, counted, passed)
        except _RefusedError:
            if begun:
                raise
        if refusal is not None and not begun:
            if int(claimed) and not ended:
                await _hear_out(receive)
            await _close(refusal, scope, receive, send)

    def _too_large(self, scope: Scope, most: int, form: bool) -> Response:
        advice = "Send records as multipart/form-data."
        if form:
            advice = (
                "Upload one test at a time, pack it with gzip or keep every tenth row; whoever "
                "runs the server can raise --max-upload-mb."
            )
        words = f"request: found more than {most / 1e6:g} MB; expected at most that. {advice}"
        return self.refuse(Request(scope), 413, words)


async def _close(answer: Response, scope: Scope, receive: Receive, send: Send) -> None:
    """Answer, and take nothing more from that connection."""
    answer.headers["connection"] = "close"
    await answer(scope, receive, send)


async def _hear_out(receive: Receive) -> None:
    """Take a body in, keeping nothing of it."""
    while (message := await receive())["type"] == "http.request" and message.get("more_body"):
        pass
