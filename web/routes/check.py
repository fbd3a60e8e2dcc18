"""What the checker and the views say of a text, as it stands in the editor."""

from typing import Any

from fastapi import APIRouter, Request

from ..models.protocols import (
    CheckedText,
    CheckText,
    Explained,
    Graph,
    Preview,
    Rehearsed,
    RehearseText,
    Words,
)
from .gone import while_there
from .site import TheSite

router = APIRouter(tags=["check"])


@router.post("/check")
async def check_protocol(asked: CheckText, site: TheSite) -> CheckedText:
    """Every problem of a text, with its place; and the form with which it would be started."""
    return await site.looking.check(asked)


@router.get("/schema")
async def lab_schema(site: TheSite) -> dict[str, Any]:
    """The JSON Schema of protocols for this lab, from which editors complete."""
    return site.looking.schema()


@router.post("/words")
async def protocol_words(asked: CheckText, site: TheSite) -> Words:
    """The protocol in plain sentences; 422 with the problems where it has errors."""
    return await site.looking.words(asked)


@router.post("/explain")
async def explain_protocol(asked: CheckText, site: TheSite) -> Explained:
    """The protocol as P = [A1, ..., AT]."""
    return await site.looking.explain(asked)


@router.post("/graph")
async def protocol_graph(asked: CheckText, site: TheSite) -> Graph:
    """The tree that it becomes."""
    return await site.looking.graph(asked)


@router.post("/preview")
async def preview_protocol(asked: CheckText, site: TheSite) -> Preview:
    """Its points over the work area, its actions, its time; points outside are no obstacle."""
    return await site.looking.preview(asked)


@router.post("/rehearse")
async def rehearse_protocol(asked: RehearseText, request: Request, site: TheSite) -> Rehearsed:
    """The whole protocol with simulated devices on a virtual clock, in a process of its own.

    Thousands of spectra take minutes; hanging up ends it.
    """
    return await while_there(request, site.rehearsals.play(asked))
