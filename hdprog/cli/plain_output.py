"""Words on standard output where its encoding lacks some of their signs."""

from __future__ import annotations

import codecs
import io
import sys
import unicodedata

_NAME = "hdprog.plain"
_PLAIN = str.maketrans(
    {
        "\u2212": "-",
        "\u2013": "-",
        "\u2192": "->",
        "\u00b5": "u",
        "\u03bc": "u",
        "\u00b7": "-",  # as in the names of units that options take: in-lbf
        "\u00b1": "+/-",
        "\u00d7": "x",
        "\u201c": '"',
        "\u201d": '"',
        "\u2019": "'",
    }
)


def write_plainly_where_needed() -> None:
    """Put plain signs for those that standard output or error cannot encode.

    A terminal or a file of a Western single-byte encoding has no narrow space: without this the
    outcome of hours of work could not be printed.
    """
    codecs.register_error(_NAME, _plain)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # not under a test that stands in for it
            stream.reconfigure(errors=_NAME)


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end].translate(_PLAIN)
    # Spaces, raised digits and letters with accents come apart into plain ones.
    apart = unicodedata.normalize("NFKD", lacking).translate(_PLAIN)
    kept = "".join(sign for sign in apart if not unicodedata.combining(sign))
    return kept.encode("ascii", "replace").decode("ascii"), error.end
