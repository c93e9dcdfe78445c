"""The application: its parts put together."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.resources import files

from fastapi import FastAPI
from starlette.staticfiles import StaticFiles

from hdprog import __version__
from hdprog.service.web_settings import WebSettings
from hdprog.web import health, refusals
from hdprog.web.api import drives as api_drives
from hdprog.web.api import jobs as api_jobs
from hdprog.web.api import tests as api_tests
from hdprog.web.head import HeadAsGet
from hdprog.web.pages import ROUTERS
from hdprog.web.security.body_limit import BodyLimit
from hdprog.web.security.headers import SecurityHeaders
from hdprog.web.security.known_host import KnownHost
from hdprog.web.service import Service


def create_app(settings: WebSettings) -> FastAPI:
    """Make the application; the store is opened when it starts."""

    @asynccontextmanager
    async def life(app: FastAPI) -> AsyncIterator[None]:
        service = Service(settings)
        await asyncio.to_thread(service.open)
        app.state.service = service
        yield
        await asyncio.to_thread(service.close)

    app = FastAPI(
        title="hdprog",
        version=__version__,
        summary="Condition and remaining service life of strain wave gears",
        openapi_url="/api/v1/openapi.json",
        docs_url=None,  # they load scripts from elsewhere
        redoc_url=None,
        lifespan=life,
    )
    for router in (api_drives.router, api_tests.router, api_jobs.router, health.router):
        app.include_router(router)
    for router in ROUTERS:
        app.include_router(router, include_in_schema=False)
    static = files("hdprog.web") / "static"
    app.mount("/static", StaticFiles(directory=str(static)), name="static")
    refusals.install(app)
    app.add_middleware(HeadAsGet)
    app.add_middleware(
        BodyLimit,
        most=settings.max_bytes,
        refuse=refusals.refuse,
        stranger=refusals.answer_to_stranger,
    )
    if settings.hosts:
        # Without a login a page elsewhere must not reach this one under a name of its own.
        app.add_middleware(KnownHost, names=settings.hosts, refuse=refusals.refuse)
    app.add_middleware(SecurityHeaders)
    return app


def from_environment() -> FastAPI:
    """Make the application as `hdprog serve` settled it."""
    return create_app(WebSettings.from_environment())
