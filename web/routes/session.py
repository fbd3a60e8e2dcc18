"""The session of a browser, settings, and who has control."""

import time

from fastapi import APIRouter, Request, Response

from ... import __version__
from ..guard.headers import ControlLease
from ..guard.refusal import Refusal
from ..models.control import AskControl, ControlState, ControlTaken, TakeControl
from ..models.settings import AllSettings, Session, Settings, SignIn
from ..models.told import Said
from .site import TheSite

router = APIRouter(tags=["session"])


@router.get("/session")
async def get_session(request: Request, response: Response, site: TheSite) -> Session:
    """Whether this browser is signed in; on loopback without a token it is from now on."""
    signed_in = site.sessions.knows(request.cookies, request.headers)
    if not signed_in and not site.sessions.token_needed:
        site.sessions.set_cookie(response)
        signed_in = True
    return _session(site, signed_in)


@router.post("/session")
async def sign_in(asked: SignIn, response: Response, site: TheSite) -> Session:
    """Sign in with the token; the answer sets an HttpOnly cookie."""
    if not site.sessions.is_token(asked.token):
        raise Refusal(
            401,
            "WRONG_TOKEN",
            "the token is wrong",
            "it is the one that labrun web was started with",
        )
    site.sessions.set_cookie(response)
    return _session(site, True)


@router.delete("/session")
async def sign_out(response: Response, site: TheSite) -> Session:
    """Forget the cookie."""
    site.sessions.drop_cookie(response)
    return _session(site, False)


def _session(site: TheSite, signed_in: bool) -> Session:
    return Session(
        signed_in=signed_in, token_needed=site.sessions.token_needed,
        server_time_ms=time.time() * 1000, demo=site.options.demo, labrun=__version__,
    )  # fmt: skip


@router.get("/settings")
async def get_settings(site: TheSite) -> AllSettings:
    """Settings, and what this server is."""
    return AllSettings(settings=site.settings.read(), about=site.about())


@router.put("/settings")
async def put_settings(settings: Settings, site: TheSite) -> AllSettings:
    """Change the settings; they are kept beside the protocols."""
    site.settings.write(settings)
    return AllSettings(settings=settings, about=site.about())


@router.get("/control")
async def get_control(site: TheSite) -> ControlState:
    """Who has control."""
    return site.control.state()


@router.post("/control/take")
async def take_control(
    asked: TakeControl, site: TheSite, lease: ControlLease = None
) -> ControlTaken:
    """Take control, or renew your own; 423 where somebody has it and no reason is given."""
    return site.control.take(asked.name, asked.reason, lease)


@router.post("/control/release")
async def release_control(site: TheSite, lease: ControlLease = None) -> ControlState:
    """Give control back."""
    site.control.release(lease)
    return site.control.state()


@router.post("/control/ask")
async def ask_control(asked: AskControl, site: TheSite) -> Said:
    """Ask the holder for it."""
    return Said(text=site.control.ask(asked.name))
