"""Connect to a controller: banner, settings, work offset; or report what is there instead."""

import asyncio
import re
from contextlib import suppress
from dataclasses import replace

from ..motion.bench import LETTERS
from ..motion.faults import MotionFault, Refused, Silent
from .controller import ASK, Controller
from .settings import Settings
from .stopping import stop

REPORT_S = 1.0
RESET_S = 2.0
OPTIONS_S = 2.0
VERSION = re.compile(r"\[VER:(?:.*(?P<fluid>FluidNC [^\s:\]]+)|(?P<grbl>[^:\]]+))")
PLACE = re.compile(r"/axes/\w/homing/mpos_mm=(-?\d+(?:\.\d+)?)")
OFFSET_LOOKS = 80  # the offset comes with every tenth to thirtieth report


async def reach(controller: Controller, boot_s: float) -> None:
    """Open the port and identify the controller; raises OSError with the reason."""
    await controller.port.open()
    controller.connected()
    try:
        await _greet(controller, boot_s)
        _check_age(controller)
        lines = await controller.ask("$$")
        options = await _options(controller)  # which may say the firmware's name, too
        settings = Settings.read(lines, options, controller.kind)
        if settings.firmware.own_scale:
            settings = replace(settings, homes_at=await homes_at(controller, settings.axes))
        if settings.unfit:
            raise OSError(f"{controller.port.name}: {settings.unfit}")
        controller.configure(settings)
        await learn_offset(controller)
    except BaseException as fault:  # a cancel as well
        controller.disconnected(str(fault))
        await controller.port.close()
        if isinstance(fault, MotionFault):
            name = controller.port.name
            raise OSError(f"{name}: {controller.firmware} was reached, but {fault}") from fault
        raise


async def _greet(controller: Controller, boot_s: float) -> None:
    """Most boards boot when their port is opened; the others are queried, and stopped."""
    before = controller.boots
    if await controller.until(lambda: controller.boots > before or bool(controller.lost), boot_s):
        if controller.lost:
            raise OSError(controller.lost)
        return
    controller.write(ASK)
    await controller.until(
        lambda: controller.reports_heard > 0 or controller.boots > before, REPORT_S
    )
    if controller.boots > before:
        return
    if controller.reports_heard > 0:
        locked = controller.report is not None and controller.report.state in ("Alarm", "Sleep")
        await stop(controller, moving=not locked)
        return
    controller.reset()
    if not await controller.until(lambda: controller.boots > before, RESET_S):
        raise OSError(not_grbl(controller, boot_s))


def _check_age(controller: Controller) -> None:
    if controller.firmware.startswith("Grbl 0."):
        raise OSError(
            f"{controller.port.name}: this is {controller.firmware}, whose reports have an older "
            f"format; flash GRBL 1.1 or grblHAL"
        )


async def _options(controller: Controller) -> str:
    """The firmware's build options, as letters; empty if it does not report them."""
    try:
        told = await controller.ask("$I", OPTIONS_S)
    except (Refused, Silent):
        return ""
    heard = " ".join(controller.overheard)
    if not controller.firmware and (found := VERSION.search(heard)):
        # By telnet or WebSocket, and on many boards' own USB, it does not boot, and says no banner.
        kind = "grblHAL" if "[FIRMWARE:grblHAL]" in heard else "Grbl"
        controller.firmware = found["fluid"] or f"{kind} {found['grbl']}"
    return next((text.split(",")[0] for text in told if "," in text), "")


async def homes_at(controller: Controller, axes: int) -> dict[int, float]:
    """Where FluidNC's axes are after homing; one that does not home is left out."""
    places: dict[int, float] = {}
    for axis in range(axes):
        with suppress(Refused, StopIteration):
            told = await controller.ask(f"$/axes/{LETTERS[axis].lower()}/homing/mpos_mm")
            places[axis] = next(float(found[1]) for one in told if (found := PLACE.fullmatch(one)))
    return places


async def learn_offset(controller: Controller, times: int = 1) -> None:
    """Look until so many reports have told the same work offset: noise may have changed a digit of one."""
    reports = controller.reports
    told, reports.offset = None, None
    for _ in range(OFFSET_LOOKS):
        await controller.look()
        if (offset := reports.offset) is not None:
            times = times - 1 if told in (None, offset) else times
            if times < 1:
                return
            told, reports.offset = offset, None
        await asyncio.sleep(0.01)
    reports.offset = reports.offset or told


def not_grbl(controller: Controller, boot_s: float) -> str:
    """What is on the port, if it is not GRBL."""
    name, baud = controller.port.name, controller.baud
    unreadable = controller.lines.unreadable + sum(
        not 0x20 <= byte < 0x7F for byte in controller.lines.rest
    )
    heard = list(controller.overheard) or [controller.lines.rest.decode("ascii", "replace")]
    if unreadable > 4:
        return (
            f"{name} responds, but with unreadable bytes: {baud} baud is probably wrong "
            f"(GRBL and grblHAL speak 115200); set `baud` in the lab"
        )
    if marlin := next((word for word in heard if "Marlin" in word), None):
        return f"{name}: this is {marlin.strip()[:60]}; write `driver: marlin` in the lab"
    if any(word.strip() for word in heard):
        return (
            f"{name} responds, but not as GRBL does: it sent `{heard[-1][:60]}`; "
            f"another instrument is on this port; see the other names under /dev/serial/by-id"
        )
    return (
        f"{name} is open, but nothing on it responds: no GRBL banner within {boot_s:g} s, no report "
        f"to `?` and no boot on a reset; is the controller switched on, is this its port, and is "
        f"{baud} baud its speed?"
    )
