"""Modbus devices: registers with types and units, over TCP or a serial line, by pymodbus.

MODBUS Application Protocol Specification V1.1b3. See docs/how-to/instruments-in-yaml.md.
"""

import asyncio
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from ...schemas.contract import Action, Effect, Happened, Name
from ...schemas.model import Model
from ...system.extras import needed
from ..driver import ActionFailed, GoalContext, Place
from ..serial_io.open_port import open_exclusively
from .answers import NUMBER_ERRORS, BadAnswer, NoNumber, value
from .bridge import Bridge, Values, doubtful
from .config import LISTED, ActionConfig, BridgeConfig, ConfigFault, chosen
from .lines import NoAnswer
from .number_forms import size_of
from .resource import Wire, read_resource
from .schema_faults import own_faults
from .template import filled, texts, written

REFUSALS: dict[int, tuple[str, Happened, str]] = {
    1: ("IllegalFunction", "no", "the device does not have this function"),
    2: ("IllegalAddress", "no", "the device has no such register"),
    3: ("IllegalValue", "no", "the device does not take this value"),
    4: ("DeviceFailure", "unknown", "the device failed while it was doing it"),
    5: ("DeviceFailure", "unknown", "the device has accepted it and needs time"),
    6: ("DeviceBusy", "no", "the device is busy"),
}
"""Exception code -> error, whether it happened, meaning (section 7 of the specification)."""
LONGEST_S = 3600.0
"""The library's own patience; how long is waited is said by each action."""
KINDS = {
    "int16": ">i2", "uint16": ">u2", "int32": ">i4", "uint32": ">u4", "int64": ">i8", "uint64": ">u8",
    "float32": ">f4", "float64": ">f8", "bcd16": ">bcd2", "bcd32": ">bcd4", "string": "",
}  # fmt: skip
"""How the bytes of a register are written."""
READING = {
    "holding": "read_holding_registers", "input": "read_input_registers", "coil": "read_coils",
    "discrete": "read_discrete_inputs",
}  # fmt: skip
"""Table -> how the library reads it."""
TABLES = tuple(READING)
Address = Annotated[int, Field(ge=0, le=65535)]


class Register(Model):
    """One value of the device: which of the four tables, address from 0, type, scale."""

    holding: Address | None = None
    input: Address | None = None
    coil: Address | None = None
    discrete: Address | None = None
    type: Literal[tuple(KINDS)] = "uint16"  # type: ignore[valid-type]
    scale: float = 1.0
    offset: float = 0.0
    length: int = Field(default=8, gt=0, le=125)
    bit: int | None = Field(default=None, ge=0, le=15)
    bits: list[int] | None = None
    word_order: Literal["big", "little"] | None = None
    byte_order: Literal["big", "little"] | None = None
    unit: int | None = Field(default=None, ge=0, le=255)
    nothing: list[int] | None = None
    """Raw values that stand for no value, such as 32767 for a probe that is not plugged in."""

    @model_validator(mode="after")
    def _one_table(self) -> "Register":
        if len(chosen(self, TABLES)) != 1:
            raise ValueError("it is in one table: holding: 10, input: 10, coil: 10 or discrete: 10")
        for key, fault in own_faults(self.form, {}):
            raise ValueError(f"{key}: {fault}")
        unsigned = not self.is_bit and self.type in ("uint16", "uint32")
        if chosen(self, ("bit", "bits")) and not unsigned:
            raise ValueError("bits are of an `input` or `holding` register, unsigned")
        return self

    @property
    def form(self) -> Values:
        """How its value is written, as that of any other instrument."""
        said = {key: getattr(self, key) for key in chosen(self, ("bit", "bits", "nothing"))}
        if (self.scale, self.offset) != (1, 0):
            said |= {"scale": self.scale, "offset": self.offset}
        return said if self.is_bit or self.type == "string" else {"bytes": KINDS[self.type], **said}

    @property
    def count(self) -> int:
        """How many it is."""
        if self.is_bit:
            return 1
        return self.length if self.type == "string" else size_of(KINDS[self.type]) // 2

    @property
    def table(self) -> str:
        return chosen(self, TABLES)[0]

    @property
    def is_bit(self) -> bool:
        return (self.coil, self.discrete) != (None, None)

    @property
    def writable(self) -> bool:
        return self.table in ("holding", "coil") and (self.bit, self.bits) == (None, None)


class ModbusAction(ActionConfig):
    """`write`: register -> value, in order; then `read`: register names, which are the results."""

    write: dict[str, Any] = Field(default_factory=dict)
    read: Annotated[list[str], LISTED] = Field(default_factory=list)

    @model_validator(mode="after")
    def _does_something(self) -> "ModbusAction":
        if not self.write and not self.read:
            raise ValueError('it needs `read: [temperature]` or `write: {target: "{target}"}`')
        return self

    def guessed_effect(self) -> Effect:
        return "once" if self.write else "pure"

    def used(self) -> Iterator[tuple[str, str]]:
        yield from texts("write", self.write)


class ModbusConfig(Wire, BridgeConfig):
    """The config of `driver: modbus`."""

    own_keys = ("words",)
    elsewhere = ": it stands beside the address of its register"
    own_errors = {  # type: ignore[assignment] # noqa: RUF012
        **{name: (happened, words) for name, happened, words in REFUSALS.values()},
        **NUMBER_ERRORS,
    }
    kinds = ("tcp", "serial")

    unit: int = Field(default=1, ge=0, le=255)
    word_order: Literal["big", "little"] = "big"
    byte_order: Literal["big", "little"] = "big"
    framer: Literal["socket", "rtu", "ascii"] | None = None
    registers: dict[Name, Register] = Field(min_length=1)
    actions: dict[Name, ModbusAction] = Field(min_length=1)

    def faults(self, contract: Any, *, apart: bool) -> Iterator[ConfigFault]:
        yield from super().faults(contract, apart=apart)
        for name, said in self.actions.items():
            place = ("actions", name)
            for key, names in (("read", said.read), ("write", said.write)):
                for one in names:
                    register = self.registers.get(one)
                    if register is None:
                        fault = f"there is no register {one}; there is {', '.join(self.registers)}"
                    elif key == "read" or register.writable:
                        continue
                    elif register.table == "holding":
                        fault = f"{one} is a bit of a holding register: write the whole"
                    else:
                        fault = f"{one} is in the table of {register.table} registers, which can only be read"
                    yield ConfigFault((*place, key), fault)
            action = contract.actions.get(name, Action())
            for one in set(action.returns.get("properties", {})) - set(said.read):
                yield ConfigFault(place, f"{name} returns {one}, which is not read", True)


class Modbus(Bridge):
    """Implements whichever contract its lab says or names."""

    extra: ClassVar[str | None] = "modbus"
    config_model: ClassVar = ModbusConfig
    _client: Any = None

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self._waiting: set[asyncio.Timeout] = set()

    async def ready(self, timeout_s: float) -> None:
        if self._client is not None and self._client.connected:
            return
        await self.drop()
        said: ModbusConfig = self.config
        at = read_resource(said.resource)
        library = needed("pymodbus.client")
        framer = said.framer or ("socket" if at.kind == "tcp" else "rtu")
        options: Values = {  # a repeated request may write twice: whether to ask again is decided here
            "timeout": LONGEST_S, "retries": 0, "reconnect_delay": 0, "trace_connect": self._connected,
            "framer": needed("pymodbus").FramerType(framer),
        }  # fmt: skip
        if at.kind == "tcp":
            self._client = library.AsyncModbusTcpClient(at.host, port=at.port, **options)
        else:
            self._client = library.AsyncModbusSerialClient(
                at.name, baudrate=said.baud, bytesize=said.bits, parity=said.parity,
                stopbits=said.stop_bits, **options,
            )  # fmt: skip
        where = f"{self.place.device} at {at}"
        try:
            async with asyncio.timeout(timeout_s):
                if await self._client.connect():
                    return
        except TimeoutError:
            pass
        except Exception as fault:  # the system's own, of a port that does not take this framing
            raise OSError(f"{where} cannot be opened: {fault}") from fault
        if at.kind == "serial":  # the library tells its log alone why not
            (await asyncio.to_thread(open_exclusively, at.name)).close()
        raise OSError(f"{where} cannot be reached: is it on, and is this its address?")

    def _connected(self, there: bool) -> None:
        """The library goes on waiting for an answer over a connection that is gone."""
        for waiting in () if there else self._waiting:
            waiting.reschedule(asyncio.get_running_loop().time())

    async def drop(self) -> None:
        client, self._client = self._client, None
        if client is not None:
            client.close()

    async def perform(
        self, said: ModbusAction, action: Action, values: Values, goal: GoalContext
    ) -> Values:
        params, returns = self.params(said, action), self.returns(said, action)
        begun = False
        try:
            for name, what in said.write.items():
                await self._write(name, filled(what, values, params, goal.id), said)
                begun = True
            found = {
                name: await self._read(name, said, returns.get(name, {})) for name in said.read
            }
        except ActionFailed as failure:
            raise doubtful(failure) if begun else failure from failure
        return {name: one for name, one in found.items() if name in returns}

    async def _read(self, name: str, said: ModbusAction, returns: Values) -> Any:
        one: Register = self.config.registers[name]
        answer = await self._ask(name, READING[one.table], said, count=one.count)
        if one.is_bit:
            return value(str(int(answer.bits[0])), returns)
        data = b"".join(word.to_bytes(2, "big") for word in self._ordered(answer.registers, one))
        if one.type == "string":
            return value(data.decode("utf-8", "backslashreplace").rstrip("\0 "), returns)
        try:
            return value(data.decode("latin-1"), {**returns, **one.form})
        except NoNumber as fault:
            raise NoNumber(fault.name, f"{name}: {fault}") from fault
        except BadAnswer as fault:
            raise BadAnswer(f"{name}: {fault}") from fault

    async def _write(self, name: str, what: Any, said: ModbusAction) -> None:
        one: Register = self.config.registers[name]
        try:
            if one.is_bit:
                words: list[Any] = [bool(float(what))]
            elif one.type == "string":
                words = _words(str(what).encode())
            else:
                words = _words(written(what, one.form, "").encode("latin-1"))
        except (AttributeError, TypeError, ValueError) as fault:
            told = f"{name}: {what!r} does not fit into {one.type}: {fault}"
            raise ActionFailed("IllegalValue", told, "no") from fault
        words, call = self._ordered(words, one), "write_coil" if one.is_bit else "write_register"
        if len(words) == 1:
            try:
                await self._ask(name, call, said, words[0])
                return
            except ActionFailed as failure:  # some have only the function for several
                if failure.name != "IllegalFunction":
                    raise
        await self._ask(name, f"{call}s", said, words)

    def _ordered(self, words: list[int], one: Register) -> list[int]:
        """Registers as the specification has them, highest first, or as this device has them.

        A text has no highest word, but its two letters may lie the other way round.
        """
        said: ModbusConfig = self.config
        if (one.byte_order or said.byte_order) == "little" and "16" not in one.type:
            words = [word >> 8 | (word & 0xFF) << 8 for word in words]
        turned = (one.word_order or said.word_order) == "little"
        return words[::-1] if turned and one.type != "string" else words

    async def _ask(self, name: str, call: str, said: Any, *given: Any, **more: Any) -> Any:
        """One request about a register."""
        library, client = needed("pymodbus.exceptions"), self._client
        if client is None:
            raise OSError("the connection was closed")
        one: Register = self.config.registers[name]
        unit, address = self.config.unit if one.unit is None else one.unit, getattr(one, one.table)
        words = f"{self.place.device} was asked to {call.replace('_', ' ')} {address} ({name})"
        try:
            async with asyncio.timeout(self.timeout_s(said)) as waiting:
                self._waiting.add(waiting)
                try:
                    answer = await getattr(client, call)(address, *given, device_id=unit, **more)
                finally:
                    self._waiting.discard(waiting)
        except (TimeoutError, library.ModbusIOException, library.ConnectionException) as fault:
            if not client.connected:
                raise OSError(f"{words}, and the connection was closed") from fault
            raise NoAnswer(f"{words} and was silent") from fault
        if not answer.isError():
            return answer
        code = answer.exception_code
        error, happened, meaning = REFUSALS.get(
            code, ("DeviceFailure", "unknown", "see its manual")
        )
        if known := self.named(said, code, ""):
            error, happened, meaning = known[0], known[1].happened, known[1].summary
        told = f"{words} and refused with exception {code}: {meaning}"
        raise ActionFailed(error, told, happened)


def _words(data: bytes) -> list[int]:
    data += b"\0" * (len(data) % 2)
    return [int.from_bytes(data[at : at + 2], "big") for at in range(0, len(data), 2)]
