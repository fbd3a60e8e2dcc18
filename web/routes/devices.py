"""Manual operation of devices: status, actions, arming, jogging; and STOP ALL."""

from typing import Annotated, Any
from urllib.parse import unquote

from fastapi import APIRouter, Query
from fastapi.responses import FileResponse, Response

from ..access.headers import CommandKey, InTime, Key, Name, Operator, PerhapsInTime
from ..access.once import CommandRoute
from ..models import devices as models
from ..report.files import FORMATS
from .state import TheSite

router = APIRouter(tags=["devices"])
commands = APIRouter(tags=["devices"], route_class=CommandRoute)
PICTURE: dict[int | str, dict[str, Any]] = {
    200: {"content": {"image/*": {"schema": {"type": "string", "format": "binary"}}}}
}


@router.get("/devices")
async def list_devices(app_state: TheSite) -> list[models.DeviceState]:
    """The state of every device of the lab."""
    return app_state.device_links.states()


@router.post("/devices/scan")
async def scan_devices(app_state: TheSite) -> list[models.DeviceState]:
    """Look for all devices again: lost and failed ones are tried at once."""
    return await app_state.device_links.scan()


@router.get("/devices/{device}")
async def get_device(device: str, app_state: TheSite) -> models.DeviceDetail:
    """A device with its contract."""
    return app_state.device_links.detail(device)


@router.get("/devices/{device}/history")
async def get_device_history(
    device: str, app_state: TheSite, since_s: Annotated[float, Query(ge=0, le=1e11)] = 0.0,
    name: Annotated[str | None, Query(max_length=200)] = None,
) -> models.DeviceHistory:  # fmt: skip
    """What a device has reported since a time (seconds since 1970); with the course of one number."""
    return app_state.histories.read(app_state.device_links.device_link(device).name, since_s, name)


@router.get("/devices/{device}/picture", response_class=Response, responses=PICTURE)
async def get_picture(device: str, app_state: TheSite, above: bool = False) -> Response:
    """What a camera sees now; kept nowhere. 409 `HELD` while a run has it.

    With `above`, the bench as from straight above: `X-Bench` has its left, right, front and back edge in mm.
    """
    look, suffix = await app_state.looking.look(device, above=above)
    headers = {"Cache-Control": "no-store"}
    if look.place is not None:
        headers["X-Bench"] = " ".join(str(mm) for mm in look.place.model_dump().values())
    return Response(look.file.data, media_type=FORMATS[suffix], headers=headers)


@commands.post("/devices/{device}/actions/{action}", status_code=202)
async def call_action(
    device: str, action: str, asked: models.CallAction, app_state: TheSite,
    by: Operator, in_time: InTime, key: CommandKey,
) -> models.GoalState:  # fmt: skip
    """Do one action; answers within 2 s, with `ended_at` set if it has ended by then.

    422 with a problem for each invalid parameter; 409 `HELD` while a run has the device,
    `BUSY` while another action is under way, `NOT_ARMED` for a hazard that was not armed.
    """
    return await app_state.acting.call(device, action, asked, by, key, in_time)


@commands.post("/devices/{device}/arm")
async def arm_action(
    device: str,
    asked: models.ArmAction,
    app_state: TheSite,
    by: Operator,
    in_time: InTime,
    key: CommandKey,
) -> models.Armed:
    """Arm a dangerous action for 60 s; it may be called once, after `hold_s`."""
    return app_state.arming.arm(device, asked.action, by)


@commands.post("/devices/{device}/disarm")
async def disarm_device(device: str, app_state: TheSite) -> models.DeviceState:
    """Disarm; needs no control."""
    app_state.arming.disarm(device)
    return app_state.device_links.state(device)


@router.get("/goals/{id}/files/{file:path}")
async def get_goal_file(id: str, file: str, app_state: TheSite) -> FileResponse:
    """A file delivered by a manual action."""
    return FileResponse(app_state.acting.file(id, file))


@commands.post("/goals/{id}/cancel")
async def cancel_goal(id: str, app_state: TheSite) -> models.GoalState:
    """Cancel a manual action; needs no control."""
    return await app_state.acting.cancel(id)


@router.get("/goals/{id}")
async def get_goal(id: str, app_state: TheSite) -> models.GoalState:
    """A manual action, under way or ended."""
    return app_state.acting.goal(id)


@commands.post("/devices/{device}/jog/step", status_code=202)
async def jog_step(
    device: str,
    asked: models.JogStep,
    app_state: TheSite,
    by: Operator,
    in_time: InTime,
    key: CommandKey,
) -> models.GoalState:
    """One bounded move from the position that the device reports, checked against the limits."""
    return await app_state.jogging.step(device, asked, by, key, in_time)


@commands.post("/devices/{device}/jog/start")
async def jog_start(
    device: str,
    asked: models.JogStart,
    app_state: TheSite,
    by: Operator,
    in_time: InTime,
    key: CommandKey,
) -> models.JogState:
    """Move for as long as keep-alives come: event `jog` {id} on `/ui`, or POST `beat`."""
    return await app_state.jogging.start(device, asked, by, in_time)


@router.post("/jogs/{id}/beat")
async def jog_beat(id: str, app_state: TheSite) -> models.JogState:
    """Keep a hold alive."""
    return app_state.jogging.beat(id)


@router.post("/jogs/{id}/stop")
async def jog_stop(id: str, app_state: TheSite) -> models.JogState:
    """End a hold; answers when the axis is at rest. Needs no control."""
    return await app_state.jogging.stop(id)


@commands.post("/stop")
async def stop_all(
    app_state: TheSite, in_time: PerhapsInTime, press: Key = None, name: Name = ""
) -> models.Stopped:
    """STOP ALL: every device into its safe state, live runs aborted. No control, key or sign-in.

    Answers within a second which devices confirmed. With the key of a stop sent over the socket
    (`press`), it is the same stop, not a second one.
    """
    return await app_state.stopping.stop_all(press, unquote(name))
