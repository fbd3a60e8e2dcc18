"""The application: the API under /api/v1, and its OpenAPI description."""

from typing import Any

from fastapi import APIRouter, FastAPI
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from ... import __version__
from ..access.fault import answer_fault
from ..local import refusal
from ..models.base import Fault
from ..models.updates import Notice, Patch, RunLog, RunPatch, Snapshot, WatchedRun
from ..routes import check, demo, devices, finding, protocols, results, runs, session

API = "/api/v1"
FAMILIES = (
    session.router, protocols.router, check.router, devices.router, devices.commands,
    runs.router, runs.commands, results.router, finding.router, demo.router, demo.commands,
)  # fmt: skip
FAULTS: dict[int | str, dict[str, Any]] = {
    "4XX": {"model": Fault, "description": "Nothing was done; the fault states why."}
}
ABOUT = """\
Runs, devices and protocols of one laboratory bench.

**Commands** carry `Idempotency-Key` (repeating a key gives the same answer; the command is done once),
`X-Control-Lease` (from `POST /control/take`) and `X-Deadline` (milliseconds by the server's clock;
a late command is refused with 408 and not done). `POST /stop` and `pause` need none of these.

**Sign-in** is a cookie: from `POST /session` with the token, or from any page's address with
`?token=TOKEN`; programs may send `Authorization: Bearer TOKEN` instead. With `--no-token`,
`GET /session` gives it to everybody.

**Push** is Socket.IO 4 on this port, namespace `/ui`; its messages are under *webhooks*. The client
may send `snapshot {}` and `watch {run}` (both acknowledged), `unwatch {run}`, and, volatile, `jog {id}`
and `stop {until_ms?}` (by the server's clock: a later one is refused as `LATE`).
"""


def make_app(app_state: Any) -> FastAPI:
    """The API of a site; None for its description alone."""
    app = FastAPI(
        title="labrun", version=__version__, description=ABOUT, openapi_url=f"{API}/openapi.json",
        docs_url=None, redoc_url=None, generate_unique_id_function=_name, responses=FAULTS,
    )  # fmt: skip
    app.state.app_state = app_state
    whole = APIRouter(prefix=API)
    for family in FAMILIES:
        whole.include_router(family)
    app.include_router(whole)
    for fault in (
        refusal.Refusal,
        RequestValidationError,
        HTTPException,
        ClientDisconnect,
        ImportError,
    ):
        app.add_exception_handler(fault, refusal.answer)
    app.add_exception_handler(Exception, answer_fault)
    _describe_updates(app)
    return app


def _name(route: APIRoute) -> str:
    """The name of a route in the types generated from OpenAPI."""
    return route.name


def _describe_updates(app: FastAPI) -> None:
    """The messages of the socket, so that types are generated for them too."""

    @app.webhooks.post("snapshot")
    def snapshot(body: Snapshot) -> None:
        """On every connection, and as the acknowledgement of `snapshot`."""

    @app.webhooks.post("patch")
    def patch(body: Patch) -> None:
        """Changes since the last patch."""

    @app.webhooks.post("run_patch")
    def run_patch(body: RunPatch) -> None:
        """Changes of a watched run."""

    @app.webhooks.post("log")
    def log(body: RunLog) -> None:
        """New lines of a watched run."""

    @app.webhooks.post("notice")
    def notice(body: Notice) -> None:
        """A message for the user."""

    @app.webhooks.post("watch")
    def watch(body: WatchedRun) -> None:
        """The acknowledgement of `watch {run}`."""
