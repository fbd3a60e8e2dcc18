"""A chain of Zaber stages, by the maker's library: what is asked of a stage, and what it says of itself."""

import contextlib
from collections.abc import Awaitable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from zaber_motion import (  # pyright: ignore[reportMissingImports]
    DeviceDbSourceType,
    Library,
    Units,
)
from zaber_motion.ascii import (  # pyright: ignore[reportMissingImports]
    Axis,
    Connection,
    Response,
    WarningFlags,
)
from zaber_motion.exceptions import (  # pyright: ignore[reportMissingImports]
    CommandFailedException,
    DeviceDbFailedException,
    MotionLibException,
    RequestTimeoutException,
)

from ..motion.faults import Lost, MotionFault, NotConnected, Refused, Silent
from ..motion.gantry import AXES
from .config import StageConfig

VELOCITY = 1.6384
ACCELERATION = VELOCITY / 10_000
"""The firmware's numbers for a speed and an acceleration of one microstep/s and microstep/s2."""
OLDEST = (7, 25)
"""The first firmware whose moves may have a speed of their own."""
NO_PLACE = {WarningFlags.NO_REFERENCE_POSITION, WarningFlags.DEVICE_NOT_HOMED}
MEANING = {
    code: name.replace("_", " ").lower()
    for name, code in vars(WarningFlags).items()
    if name.isupper()
}
WHY = {"PARKED": "it is parked; unlock it", "DRIVERDISABLED": "its driver is off; unlock it"}
Answer = TypeVar("Answer")


@dataclass(frozen=True, slots=True)
class Stage:
    """One axis; `scale` is mm (or degrees) for a microstep, the rest mm/s, mm/s2, and mm."""

    axis: Axis
    scale: float
    speed: float
    acceleration: float
    low: float
    high: float

    def command(self, place: float, speed: float, acceleration: float) -> str:
        """A move to a place; whole microsteps, as the firmware takes them."""
        words = (
            f"move abs {round(place / self.scale)} {max(1, round(speed / self.scale * VELOCITY))}"
        )
        number = acceleration / self.scale * ACCELERATION
        return f"{words} {max(1, round(number))}" if number < 2**31 else words


class Chain:
    """Connected by a port (`/dev/ttyUSB0`, `COM5`) or a network address (`tcp://10.0.0.9`)."""

    def __init__(self, port: str, silence_s: float) -> None:
        self.port = port
        self.silence_s = silence_s
        self.stages: dict[int, Stage] = {}
        self.homed = False
        self.alarm = ""
        self.lost = "it has not been opened yet"
        self.forgiven: set[str] = set()
        """Faults that a person has unlocked; homing clears them."""
        self._connection: Connection | None = None

    async def open(self, wanted: dict[int, StageConfig], database: Path | None) -> None:
        """Connect, and read what each stage can do; raises OSError with the reason."""
        await self.close("it was closed")
        try:
            self._connection = connection = await self._opened()
            connection.default_request_timeout = round(1000 * self.silence_s)
            self.lost = ""
            connection.disconnected.subscribe(lambda fault: self._gone(connection, fault))
            if database is not None:
                Library.set_device_db_source(DeviceDbSourceType.FILE, str(database))
            for number, one in wanted.items():
                self.stages[number] = await self._stage(AXES[number], one)
            await self.look()
        except (MotionLibException, MotionFault, ValueError) as fault:
            await self.close("it could not be opened")
            raise OSError(f"{self.port}: {fault}") from fault
        self.homed = not self.alarm and not await self._unplaced()

    async def _opened(self) -> Connection:
        if not self.port.startswith("tcp://"):
            return await Connection.open_serial_port_async(self.port)
        host, _, number = self.port.removeprefix("tcp://").partition(":")
        return await Connection.open_tcp_async(host, int(number or Connection.TCP_PORT_CHAIN))

    async def close(self, why: str) -> None:
        """Release the port."""
        connection, self._connection, self.lost = self._connection, None, why
        self.stages = {}
        if connection is not None:
            with contextlib.suppress(MotionLibException):
                await connection.close_async()

    def _gone(self, connection: Connection, fault: object) -> None:
        """Told by the library, in a thread of its own."""
        if connection is self._connection:
            self.lost, self.homed = f"the connection was lost ({fault})", False

    async def _stage(self, name: str, said: StageConfig) -> Stage:
        assert self._connection is not None
        axis = self._connection.get_device(said.device).get_axis(said.axis)
        where = f"{name}, device {said.device} axis {said.axis}"
        try:
            version = await axis.device.settings.get_string_async("version")
        except RequestTimeoutException:
            raise ValueError(
                f"{where} did not respond within {self.silence_s:g} s; is it on, and is that its address? "
                f"Stages with firmware 6 speak another protocol until they are told to"
            ) from None
        if tuple(int(part) for part in version.split(".")[:2]) < OLDEST:
            raise ValueError(
                f"{where} has firmware {version}; moves need {'.'.join(map(str, OLDEST))} or newer, "
                f"which Zaber Launcher installs"
            )
        scale = said.microstep() or await self._scale(axis, where, turns=name not in "xyz")
        settings = axis.settings
        speed, acceleration, low, high = [
            await settings.get_async(key) for key in ("maxspeed", "accel", "limit.min", "limit.max")
        ]
        return Stage(
            axis, scale, speed / VELOCITY * scale,
            acceleration / ACCELERATION * scale or float("inf"), low * scale, high * scale,
        )  # fmt: skip

    async def _scale(self, axis: Axis, where: str, *, turns: bool) -> float:
        """The length of a microstep, by the maker's database."""
        try:
            await axis.device.identify_async()
        except DeviceDbFailedException as fault:
            raise ValueError(
                f"{where}: its microstep is not known ({fault}). Write it in `stages` as "
                f"microstep_{'deg' if turns else 'um'}, from its data sheet, or give the maker's database as "
                f"`device_db`"
            ) from fault
        unit = Units.ANGLE_DEGREES if turns else Units.LENGTH_MILLIMETRES
        return 1 / axis.settings.convert_to_native_units("pos", 1.0, unit)

    async def ask(self, axis: int, command: str) -> Response:
        """Send a stage a command, and wait for its answer; raises MotionFault."""
        stage = self._there(axis)
        answer = await self._answered(stage.axis.generic_command_async(command), command)
        self._note(axis, {answer.warning_flag})
        return answer

    async def ask_device(self, device: int, axis: int, command: str) -> None:
        """The same for any device of the chain, by its address."""
        if self.lost or self._connection is None:
            raise NotConnected(self.lost)
        asked = self._connection.generic_command_async(command, device=device, axis=axis)
        await self._answered(asked, command)

    async def place(self, axis: int) -> float:
        """Where a stage stands, in mm."""
        stage = self._there(axis)
        return stage.scale * await self._answered(stage.axis.get_position_async(), "get pos")

    async def look(self) -> None:
        """Read what all stages say of faults and of their reference."""
        self.alarm = ""
        for axis in self.stages:
            self._note(axis, await self._flags(axis))
        if not self.alarm and await self._unplaced():
            self.homed = False

    async def _flags(self, axis: int) -> set[str]:
        return await self._answered(self._there(axis).axis.warnings.get_flags_async(), "warnings")

    async def _unplaced(self) -> bool:
        return any([NO_PLACE & await self._flags(axis) for axis in self.stages])

    def _note(self, axis: int, flags: set[str]) -> None:
        faults = sorted(f for f in flags if f.startswith("F") and f not in self.forgiven)
        if faults:
            self.homed = False
            words = ", ".join(f"{MEANING.get(flag, 'fault')} ({flag})" for flag in faults)
            self.alarm = f"axis {AXES[axis]}: {words}. Unlock and home it"

    async def release(self) -> None:
        """Take a person's word that every fault was seen to: drivers on, nothing parked."""
        for axis, stage in self.stages.items():
            flags = {flag for flag in await self._flags(axis) if flag.startswith("F")}
            self.forgiven |= flags
            self.homed = self.homed and not flags
            if await self._answered(stage.axis.is_parked_async(), "parking"):
                await self._answered(stage.axis.unpark_async(), "unpark")
            if flags:
                await self.ask(axis, "driver enable")
        await self.look()

    async def forget_faults(self) -> None:
        """After homing: what was unlocked is over."""
        for stage in self.stages.values():
            await self._answered(stage.axis.warnings.clear_flags_async(), "warnings clear")
        self.forgiven.clear()

    async def stop(self) -> None:
        """Let all stages brake."""
        for axis in self.stages:
            await self.ask(axis, "stop")

    async def busy(self) -> bool:
        """Whether any stage moves."""
        return any([(await self.ask(axis, "")).status == "BUSY" for axis in self.stages])

    def _there(self, axis: int) -> Stage:
        if self.lost:
            raise NotConnected(self.lost)
        return self.stages[axis]

    async def _answered(self, asked: Awaitable[Answer], what: str) -> Answer:
        try:
            return await asked
        except CommandFailedException as fault:
            why = fault.details.response_data
            raise Refused(f"`{what}` was refused: {WHY.get(why, why)}") from fault
        except RequestTimeoutException as fault:
            raise Silent(f"`{what}` was not answered within {self.silence_s:g} s") from fault
        except MotionLibException as fault:
            self.lost = f"the connection was lost ({fault})"
            self.homed = False
            raise Lost(self.lost) from fault
