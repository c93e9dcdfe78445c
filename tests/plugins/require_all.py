"""With HDPROG_REQUIRE_ALL=1, a skipped test marked `measured`, `chromium`, `nginx` or `postgres`
fails the run.

Load with `python -m pytest -p tests.plugins.require_all`. A whole module skipped at its import
counts too, since its marks cannot be seen.
"""

from __future__ import annotations

import os

import pytest

REQUIRED = ("measured", "chromium", "nginx", "postgres")


class RequireAll:
    def __init__(self) -> None:
        self.skipped: list[str] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        marked = any(name in report.keywords for name in REQUIRED)
        if marked and report.skipped and not hasattr(report, "wasxfail"):
            self.skipped.append(report.nodeid)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.skipped:
            self.skipped.append(report.nodeid)

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if self.skipped and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if self.skipped:
            terminalreporter.section("required tests were skipped")
            for nodeid in sorted(set(self.skipped)):
                terminalreporter.line(nodeid)


def pytest_configure(config: pytest.Config) -> None:
    if os.environ.get("HDPROG_REQUIRE_ALL") == "1":
        config.pluginmanager.register(RequireAll(), "hdprog-require-all")
