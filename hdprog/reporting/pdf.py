"""A report as PDF, to file or to print: WeasyPrint lays out the same page (extra `pdf`)."""

from __future__ import annotations

import io
import logging
from pathlib import Path

from hdprog.atomic import atomic_write_bytes
from hdprog.errors import UsageError
from hdprog.extras import install_words


def require_pdf() -> None:
    """Refuse before the work what could not be written after it.

    Raises
    ------
    UsageError
        where WeasyPrint, or the libraries that it draws with, are not installed
    """
    try:
        import weasyprint  # noqa: F401
    except (ImportError, OSError) as error:
        raise UsageError(
            f"--pdf: found no WeasyPrint that works ({error}), expected the package and the Pango "
            f"library. Install them: {install_words('pdf')}, and on Debian, apt install "
            "libpango-1.0-0 libpangoft2-1.0-0"
        ) from error


def write_pdf(report: Path) -> Path:
    """Write report.pdf beside a report.html; whole or not at all.

    Parameters
    ----------
    report : the HTML file

    Returns
    -------
    path of the PDF
    """
    from weasyprint import HTML
    from weasyprint.urls import URLFetcher

    # Properties of screens that paper does not have are no news to the reader.
    logging.getLogger("weasyprint").setLevel(logging.ERROR)
    content = io.BytesIO()
    # Everything lies in the file itself; nothing is fetched from anywhere.
    inside = URLFetcher(allowed_protocols=("data",), fail_on_errors=True)
    page = report.read_text("utf-8")
    HTML(string=page, url_fetcher=inside).write_pdf(content)
    path = report.with_suffix(".pdf")
    atomic_write_bytes(path, content.getvalue())
    return path
