"""What a record is called: the name of its file without the endings that say what it holds."""

from __future__ import annotations

__all__ = ["record_name"]

_ENDINGS = (".csv", ".tsv", ".txt", ".dat", ".xlsx", ".xlsm", ".gz")


def record_name(file: str) -> str:
    """Return a file's name without the endings of tables, of which there may be several.

    Other dots stay: in names like ``12.03.2025_axis2.csv`` all that tells records apart may stand
    behind the first of them.

    Parameters
    ----------
    file : str
        Name of the file, without its folder.

    Returns
    -------
    str
        Never empty, and fit for the name of a file or folder itself.
    """
    name = file
    while ending := next((one for one in _ENDINGS if name.casefold().endswith(one)), ""):
        name = name[: -len(ending)]
    # A dot at the front hides a file, and Windows drops one at the end.
    return name.strip(". ") or file.strip(". ") or "record"
