"""Faults to order, on the simulated lab only."""

from fastapi import APIRouter

from ..guard.headers import CommandKey
from ..guard.once import CommandRoute
from ..guard.refusal import Refusal
from ..models.demo import OrderFault
from ..models.told import Said
from .site import TheSite

commands = APIRouter(tags=["demo"], route_class=CommandRoute)


@commands.post("/demo/fault")
async def order_fault(asked: OrderFault, site: TheSite, key: CommandKey) -> Said:
    """Let something go wrong, to see what happens then; 404 without `--demo`."""
    if site.trouble is None:
        raise Refusal(404, "NO_DEMO", "faults can be ordered of `labrun web --demo` only")
    return Said(text=await site.trouble.order(asked))
