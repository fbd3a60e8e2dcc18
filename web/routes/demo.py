"""Injected faults, on the simulated lab only."""

from fastapi import APIRouter

from ..access.headers import CommandKey
from ..access.once import CommandRoute
from ..demo.trouble import Trouble
from ..local.refusal import Refusal
from ..models.base import Answer
from ..models.demo import DeviceFaults, OrderFault
from .state import TheSite

router = APIRouter(tags=["demo"])
commands = APIRouter(tags=["demo"], route_class=CommandRoute)


@router.get("/demo/faults/{device}")
async def get_faults(device: str, app_state: TheSite) -> DeviceFaults:
    """The faults that a device can have, and those that were injected; 404 without `--demo`."""
    return _trouble(app_state).of(device)


@commands.post("/demo/fault")
async def order_fault(asked: OrderFault, app_state: TheSite, key: CommandKey) -> Answer:
    """Inject a fault; 404 without `--demo`."""
    return Answer(text=await _trouble(app_state).order(asked))


def _trouble(app_state: TheSite) -> Trouble:
    if app_state.trouble is None:
        raise Refusal(404, "NO_DEMO", "faults can be injected with `labrun web --demo` only")
    return app_state.trouble
