"""What a page showed when it was opened, so that it does not undo what others changed meanwhile."""

from __future__ import annotations

import hashlib

from hdprog.errors import BadInputError


def seen(shown: object) -> str:
    """Digest of what a form shows, for a hidden field of it; `shown` is written out by `repr`."""
    return hashlib.sha256(repr(shown).encode()).hexdigest()[:16]


class UnseenError(BadInputError):
    """A form showed something else than there is now."""


def refuse_unseen(told: str, shown: object) -> None:
    """Refuse a form that showed something else than there is now; one that does not say is taken.

    Raises
    ------
    UnseenError
        in words for who sent it
    """
    if told and told != seen(shown):
        raise UnseenError(
            "a page that was opened before somebody else changed this",
            "form",
            "one that shows what holds now",
            "That stands below: look at it, and make your change again.",
        )
