"""How a route reaches the parts of the server: shelf, bench, runs, results."""

from typing import Annotated

from fastapi import Depends, Request

from ..app_state.state import AppState


async def of(request: Request) -> AppState:
    """The one site of this server."""
    return request.app.state.app_state


TheSite = Annotated[AppState, Depends(of)]
