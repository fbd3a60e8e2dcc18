"""The checker and the views on a text in the editor."""

from asyncio import to_thread
from typing import Any

from fastapi import APIRouter, Request

from ..models import protocols as models
from .disconnects import while_there
from .state import TheSite

router = APIRouter(tags=["check"])


@router.post("/check")
async def check_protocol(asked: models.CheckText, app_state: TheSite) -> models.CheckedText:
    """Every problem of a text, with its position, and the form with which it would be started."""
    told = await app_state.text_check.check(asked)
    return told.model_copy(update={"no_room": await to_thread(app_state.launching.no_room)})


@router.get("/schema")
async def lab_schema(app_state: TheSite) -> dict[str, Any]:
    """The JSON Schema of protocols for this lab, for completion in editors."""
    return app_state.text_check.schema()


@router.post("/words")
async def protocol_words(asked: models.CheckText, app_state: TheSite) -> models.Words:
    """The protocol in plain sentences; 422 with the problems if it has errors."""
    return await app_state.text_check.view("words", asked, models.Words)


@router.post("/explain")
async def explain_protocol(asked: models.CheckText, app_state: TheSite) -> models.Explained:
    """The protocol as P = [A1, ..., AT]."""
    return await app_state.text_check.view("explain", asked, models.Explained)


@router.post("/preview")
async def preview_protocol(asked: models.CheckText, app_state: TheSite) -> models.Preview:
    """Its points over the work area, its actions, its time; points outside are accepted."""
    return await app_state.text_check.view("preview", asked, models.Preview)


@router.post("/rehearse")
async def rehearse_protocol(
    asked: models.RehearseText, request: Request, app_state: TheSite
) -> models.Rehearsed:
    """Rehearse the whole protocol with simulated devices on a virtual clock, in a separate process.

    Thousands of spectra take minutes; closing the connection ends it.
    """
    return await while_there(request, app_state.rehearsals.play(asked))
