"""Injected faults, on the simulated lab only."""

from fastapi import APIRouter

from ..access.headers import CommandKey
from ..access.once import CommandRoute
from ..local.refusal import Refusal
from ..models.base import Answer
from ..models.demo import OrderFault
from .state import TheSite

commands = APIRouter(tags=["demo"], route_class=CommandRoute)


@commands.post("/demo/fault")
async def order_fault(asked: OrderFault, app_state: TheSite, key: CommandKey) -> Answer:
    """Inject a fault; 404 without `--demo`."""
    if app_state.trouble is None:
        raise Refusal(404, "NO_DEMO", "faults can be injected with `labrun web --demo` only")
    return Answer(text=await app_state.trouble.order(asked))
