"""The application: the API under /api/v1, and OpenAPI that says what there is."""

from typing import Any

from fastapi import APIRouter, FastAPI
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from .. import __version__
from .guard import refusal
from .guard.fault import answer_fault
from .models.push import Notice, Patch, RunLog, RunPatch, Snapshot, Watched
from .models.told import Fault
from .routes import check, demo, devices, protocols, results, runs, session

API = "/api/v1"
FAMILIES = (
    session.router, protocols.router, check.router, devices.router, devices.commands,
    runs.router, runs.commands, results.router, demo.commands,
)  # fmt: skip
FAULTS: dict[int | str, dict[str, Any]] = {
    "4XX": {"model": Fault, "description": "Nothing was done; the fault says why."}
}
ABOUT = """\
Runs, devices and protocols of one laboratory bench.

**Commands** carry `Idempotency-Key` (the same key again: the same answer, done once),
`X-Control-Lease` (from `POST /control/take`) and `X-Deadline` (milliseconds by the server's clock;
a late command is refused with 408 and not done). `POST /stop` and `pause` need none of them.

**Sign-in** is a cookie: `GET /session` gives it on loopback, `POST /session` for the token
elsewhere; programs may send `Authorization: Bearer TOKEN` instead.

**Push** is Socket.IO 4 on this port, namespace `/ui`; its messages are under *webhooks*. The client
may send `snapshot {}` and `watch {run}` (both acknowledged), `unwatch {run}`, and, volatile, `jog {id}`
and `stop {until_ms?}` (by the server's clock: a later one is refused as `LATE`).
"""


def make_app(site: Any) -> FastAPI:
    """The API of a site; None for its description alone."""
    app = FastAPI(
        title="labrun", version=__version__, description=ABOUT, openapi_url=f"{API}/openapi.json",
        docs_url=None, redoc_url=None, generate_unique_id_function=_name, responses=FAULTS,
    )  # fmt: skip
    app.state.site = site
    whole = APIRouter(prefix=API)
    for family in FAMILIES:
        whole.include_router(family)
    app.include_router(whole)
    for fault in (refusal.Refusal, RequestValidationError, HTTPException, ClientDisconnect):
        app.add_exception_handler(fault, refusal.answer)
    app.add_exception_handler(Exception, answer_fault)
    _describe_push(app)
    return app


def _name(route: APIRoute) -> str:
    """What a route is called in the types that are made from OpenAPI."""
    return route.name


def _describe_push(app: FastAPI) -> None:
    """The messages of the socket, so that types are made of them, too."""

    @app.webhooks.post("snapshot")
    def snapshot(body: Snapshot) -> None:
        """On every connection, and as the acknowledgement of `snapshot`."""

    @app.webhooks.post("patch")
    def patch(body: Patch) -> None:
        """What has changed since the last one."""

    @app.webhooks.post("run_patch")
    def run_patch(body: RunPatch) -> None:
        """A run that is watched."""

    @app.webhooks.post("log")
    def log(body: RunLog) -> None:
        """New lines of a run that is watched."""

    @app.webhooks.post("notice")
    def notice(body: Notice) -> None:
        """For a person to know."""

    @app.webhooks.post("watch")
    def watch(body: Watched) -> None:
        """The acknowledgement of `watch {run}`."""
