"""The session of a browser, settings, and who has control."""

import time

from fastapi import APIRouter, Request, Response

from ... import __version__
from ..access.headers import ControlLease
from ..local.refusal import Refusal
from ..models.base import Answer
from ..models.control import AskControl, ControlState, ControlTaken, TakeControl
from ..models.settings import AllSettings, Session, Settings, SignIn, TestMessage
from ..notify.notifying import NotDelivered
from .state import TheSite

router = APIRouter(tags=["session"])


@router.get("/session")
async def get_session(request: Request, response: Response, app_state: TheSite) -> Session:
    """Whether this browser is signed in; where it need not show a token it is from now on."""
    signed_in = app_state.sessions.knows(request.cookies, request.headers)
    if not signed_in and app_state.sessions.may_enter(request.scope, request.headers):
        app_state.sessions.set_cookie(response)
        signed_in = True
    return _session(app_state, signed_in)


@router.post("/session")
async def sign_in(asked: SignIn, response: Response, app_state: TheSite) -> Session:
    """Sign in with the token; the answer sets an HttpOnly cookie."""
    await app_state.sessions.admit(asked.token)
    app_state.sessions.set_cookie(response)
    return _session(app_state, True)


@router.delete("/session")
async def sign_out(response: Response, app_state: TheSite) -> Session:
    """Forget the cookie."""
    app_state.sessions.drop_cookie(response)
    return _session(app_state, False)


def _session(app_state: TheSite, signed_in: bool) -> Session:
    return Session(
        signed_in=signed_in, token_needed=app_state.sessions.token_needed,
        server_time_ms=time.time() * 1000, demo=app_state.options.demo, labrun=__version__,
    )  # fmt: skip


@router.get("/settings")
async def get_settings(app_state: TheSite) -> AllSettings:
    """Settings, and information about this server."""
    return AllSettings(settings=app_state.settings.read(), about=app_state.about())


@router.put("/settings")
async def put_settings(settings: Settings, app_state: TheSite) -> AllSettings:
    """Change the settings; they are stored beside the protocols, and who is told of runs in the lab."""
    try:
        app_state.settings.write(settings)
    except (OSError, ValueError) as fault:
        raise Refusal(409, "NOT_WRITTEN", f"not saved: {fault}") from fault
    return AllSettings(settings=settings, about=app_state.about())


@router.post("/settings/test")
async def test_message(asked: TestMessage, app_state: TheSite) -> Answer:
    """Send a test to a receiver; 502 says why it could not be delivered."""
    try:
        return Answer(text=await app_state.notifying.test(asked.to))
    except NotDelivered as fault:
        raise Refusal(502, "NOT_DELIVERED", str(fault)) from fault


@router.get("/control")
async def get_control(app_state: TheSite) -> ControlState:
    """Who has control."""
    return app_state.control.state()


@router.post("/control/take")
async def take_control(
    asked: TakeControl, app_state: TheSite, lease: ControlLease = None
) -> ControlTaken:
    """Take control, or renew your own; 423 if somebody else has it and no reason is given."""
    return app_state.control.take(asked.name, asked.reason, lease)


@router.post("/control/release")
async def release_control(app_state: TheSite, lease: ControlLease = None) -> ControlState:
    """Give control back."""
    app_state.control.release(lease)
    return app_state.control.state()


@router.post("/control/ask")
async def ask_control(asked: AskControl, app_state: TheSite) -> Answer:
    """Ask the holder for control."""
    return Answer(text=app_state.control.ask(asked.name))
