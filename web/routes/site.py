"""How a route reaches what the server has: shelf, bench, runs, results."""

from typing import Annotated

from fastapi import Depends, Request

from ..site import Site


def of(request: Request) -> Site:
    """The one site of this server."""
    return request.app.state.site


TheSite = Annotated[Site, Depends(of)]
