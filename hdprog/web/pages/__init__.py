"""Pages for people; each works without a script, by keyboard and on a phone."""

from hdprog.web.pages import (
    audit,
    downloads,
    drive,
    drive_settings,
    fleet,
    jobs,
    login,
    new_drive,
    settings,
    style,
    test,
    uploads,
)

ROUTERS = (
    style.router,
    fleet.router,
    new_drive.router,
    drive.router,
    drive_settings.router,
    uploads.router,
    test.router,
    jobs.router,
    downloads.router,
    settings.router,
    audit.router,
    login.router,
)

__all__ = ["ROUTERS"]
