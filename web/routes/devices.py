"""Devices by hand: status, actions, arming, jogging; and STOP ALL."""

from fastapi import APIRouter
from fastapi.responses import FileResponse

from ..guard.headers import CommandKey, InTime, Key, Operator, PerhapsInTime
from ..guard.once import CommandRoute
from ..models.devices import (
    ArmAction,
    Armed,
    CallAction,
    DeviceDetail,
    DeviceState,
    GoalState,
    JogStart,
    JogState,
    JogStep,
    Stopped,
)
from .site import TheSite

router = APIRouter(tags=["devices"])
commands = APIRouter(tags=["devices"], route_class=CommandRoute)


@router.get("/devices")
async def list_devices(site: TheSite) -> list[DeviceState]:
    """Every device of the lab, as it is now."""
    return site.bench.states()


@router.post("/devices/scan")
async def scan_devices(site: TheSite) -> list[DeviceState]:
    """Look for all devices anew: those that are lost or failed are tried at once."""
    return await site.bench.scan()


@router.get("/devices/{device}")
async def get_device(device: str, site: TheSite) -> DeviceDetail:
    """A device with its contract."""
    return site.bench.detail(device)


@commands.post("/devices/{device}/actions/{action}", status_code=202)
async def call_action(
    device: str, action: str, asked: CallAction, site: TheSite,
    by: Operator, in_time: InTime, key: CommandKey,
) -> GoalState:  # fmt: skip
    """Do one action; answers within 2 s, with `ended_at` set if it is over by then.

    422 with a problem for each parameter that does not fit; 409 `HELD` while a run has the device,
    `BUSY` while another action is under way, `NOT_ARMED` for a hazard that was not armed.
    """
    return await site.acting.call(device, action, asked, by, key, in_time)


@commands.post("/devices/{device}/arm")
async def arm_action(
    device: str, asked: ArmAction, site: TheSite, by: Operator, in_time: InTime, key: CommandKey
) -> Armed:
    """Arm a dangerous action for 60 s; it may be called once, after `hold_s`."""
    return site.arming.arm(device, asked.action, by)


@commands.post("/devices/{device}/disarm")
async def disarm_device(device: str, site: TheSite) -> DeviceState:
    """Disarm; needs no control."""
    site.arming.disarm(device)
    return site.bench.state(device)


@router.get("/goals/{id}/files/{file:path}")
async def get_goal_file(id: str, file: str, site: TheSite) -> FileResponse:
    """A file that an action by hand gave."""
    return FileResponse(site.acting.file(id, file))


@commands.post("/goals/{id}/cancel")
async def cancel_goal(id: str, site: TheSite) -> GoalState:
    """Ask an action by hand to end; needs no control."""
    return await site.acting.cancel(id)


@router.get("/goals/{id}")
async def get_goal(id: str, site: TheSite) -> GoalState:
    """An action by hand, under way or over."""
    return site.acting.goal(id)


@commands.post("/devices/{device}/jog/step", status_code=202)
async def jog_step(
    device: str, asked: JogStep, site: TheSite, by: Operator, in_time: InTime, key: CommandKey
) -> GoalState:
    """One bounded move from where the device says it stands, checked against the limits."""
    return await site.jogging.step(device, asked, by, key, in_time)


@commands.post("/devices/{device}/jog/start")
async def jog_start(
    device: str, asked: JogStart, site: TheSite, by: Operator, in_time: InTime, key: CommandKey
) -> JogState:
    """Move for as long as keep-alives come: event `jog` {id} on `/ui`, or POST `beat`."""
    return await site.jogging.start(device, asked, by, in_time)


@router.post("/jogs/{id}/beat")
async def jog_beat(id: str, site: TheSite) -> JogState:
    """Keep a hold alive."""
    return site.jogging.beat(id)


@router.post("/jogs/{id}/stop")
async def jog_stop(id: str, site: TheSite) -> JogState:
    """End a hold; answers when the axis stands still. Needs no control."""
    return await site.jogging.stop(id)


@commands.post("/stop")
async def stop_all(site: TheSite, in_time: PerhapsInTime, press: Key = None) -> Stopped:
    """STOP ALL: every device into its safe state, live runs aborted. No control, key or sign-in.

    Answers within a second which devices confirmed. With the key of a stop that was asked for over
    the socket (`press`), it is that stop, and not a second one.
    """
    return await site.stopping.stop_all(press)
