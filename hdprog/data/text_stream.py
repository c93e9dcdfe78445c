"""A file's bytes as blocks of whole lines: gzip, encodings and line ends are settled here."""

from __future__ import annotations

import codecs
import gzip
import hashlib
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, cast

from hdprog.errors import BadInputError

__all__ = ["decode", "file_digest", "line_blocks", "looks_like_excel", "require_file"]

_BLOCK_BYTES = 8 << 20
_LARGEST_TEXT = 4 << 30
_BYTE_ORDER_MARKS = (
    # UTF-32 first: its mark begins with that of UTF-16.
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_CONTROL = bytes(set(range(32)) - set(b"\t\n\r\f\v\x1a"))


def require_file(path: Path) -> None:
    """Refuse what is not a file.

    Raises
    ------
    BadInputError
        A missing file, a folder, or something else that holds no bytes to read.
    """
    try:
        is_folder, is_file = path.is_dir(), path.is_file()
    except (OSError, ValueError) as error:
        raise _unreadable(path, str(error)) from error
    if is_folder:
        raise BadInputError(
            "a folder",
            str(path),
            "one loop file",
            "Give the path of a file in it; a folder with a drive.toml is a drive folder, for "
            "`hdprog check` and `hdprog run`.",
        )
    if not is_file:
        found = "something that is not a file" if path.exists() else "no such file"
        raise BadInputError(
            found, str(path), "a loop file (CSV, TSV, gzip or .xlsx)", "Correct the path."
        )


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file's bytes, in hexadecimal."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise _unreadable(path, error.strerror or str(error)) from error


def looks_like_excel(path: Path) -> bool:
    """Tell whether a file is a zip archive, as .xlsx files are.

    Raises
    ------
    BadInputError
        A workbook in the old binary format.
    """
    with path.open("rb") as file:
        start = file.read(8)
    if start == b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1":
        raise BadInputError(
            "an Excel workbook in the old binary format (.xls)",
            path.name,
            "text or .xlsx",
            "Save it as CSV or as .xlsx.",
        )
    return start.startswith(b"PK\x03\x04")


def decode(text: bytes) -> str:
    """Decode UTF-8, or Latin-1 where the bytes are not UTF-8."""
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode("latin-1")


def line_blocks(path: Path) -> Iterator[bytes]:
    r"""Yield a file's text in blocks of whole lines.

    Parameters
    ----------
    path : Path
        Text, or gzip of it, in UTF-8, Latin-1, or UTF-16 or UTF-32 with a byte-order mark.

    Yields
    ------
    bytes
        Some MiB that end with ``\n``, the only sign of a line's end in it; without a byte-order
        mark; what was UTF-16 or UTF-32 is UTF-8.

    Raises
    ------
    BadInputError
        A file that is no text, damaged gzip, or text larger than 4 GiB.
    """
    carry = b""
    for chunk in _with_newlines(_decoded(path)):
        if b"\0" in chunk:
            raise _no_text(path, "bytes of value zero")
        whole, newline, rest = chunk.rpartition(b"\n")
        if newline:
            block = carry + whole + newline
            # The end-of-file sign of old loggers, on a line of its own.
            if block.endswith(b"\n\x1a\n"):
                block = block[:-2]
            yield block
            carry = rest
        else:
            carry += rest
            if len(carry) > 2 * _BLOCK_BYTES:
                raise _no_text(path, f"more than {len(carry) >> 20} MiB without a line end")
    carry = carry.rstrip(b"\x1a")
    if carry:
        yield carry + b"\n"


def _raw(path: Path) -> Iterator[bytes]:
    """Yield the bytes of a file, unpacked where it is gzip."""
    size = 0
    try:
        with path.open("rb") as plain:
            packed = plain.read(2) == b"\x1f\x8b"
            plain.seek(0)
            file = cast(BinaryIO, gzip.GzipFile(fileobj=plain)) if packed else plain
            while chunk := file.read(_BLOCK_BYTES):
                size += len(chunk)
                if size > _LARGEST_TEXT:
                    raise BadInputError(
                        f"more than {_LARGEST_TEXT >> 30} GiB of text",
                        path.name,
                        "at most that much in one record",
                        "Split the record, or keep every tenth row.",
                    )
                yield chunk
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise BadInputError(
            f"damaged gzip data ({error})",
            path.name,
            "a complete gzip file",
            "Copy or pack the file again; `gzip -t` tests it.",
        ) from error
    except OSError as error:
        raise _unreadable(path, error.strerror or str(error)) from error


def _decoded(path: Path) -> Iterator[bytes]:
    """Yield the bytes without byte-order mark, UTF-16 and UTF-32 turned into UTF-8."""
    chunks = _raw(path)
    first = next(chunks, b"")
    encoding = next((name for mark, name in _BYTE_ORDER_MARKS if first.startswith(mark)), None)
    if encoding is None:
        head = first.removeprefix(codecs.BOM_UTF8)
        sample = head[:65536]
        if len(sample) - len(sample.translate(None, _CONTROL)) > 0.01 * len(sample):
            raise _no_text(path, "control characters")
        yield head
        yield from chunks
        return
    decoder = codecs.getincrementaldecoder(encoding)()
    try:
        yield decoder.decode(first).encode()
        for chunk in chunks:
            yield decoder.decode(chunk).encode()
        yield decoder.decode(b"", final=True).encode()
    except UnicodeError as error:
        raise _no_text(
            path, f"bytes that are not {encoding.upper()}, as their mark says"
        ) from error


def _with_newlines(chunks: Iterator[bytes]) -> Iterator[bytes]:
    r"""Turn ``\r\n`` and ``\r`` into ``\n``, also where a chunk ends between the two."""
    held = b""
    for chunk in chunks:
        text = held + chunk
        held = b""
        if text.endswith(b"\r"):
            text, held = text[:-1], b"\r"
        if b"\r" in text:
            text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        yield text
    if held:
        yield b"\n"


def _no_text(path: Path, what: str) -> BadInputError:
    return BadInputError(
        f"{what}: this is not a text file",
        path.name,
        "a table as text (CSV or TSV), gzip of it, or .xlsx",
        "Export the record as CSV in UTF-8.",
    )


def _unreadable(path: Path, reason: str) -> BadInputError:
    return BadInputError(
        f"a file that cannot be read ({reason})",
        str(path),
        "a readable file",
        "Check the path and its permissions.",
    )
