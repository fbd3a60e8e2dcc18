"""Modbus devices: registers with types and units, over TCP or a serial line, by pymodbus.

MODBUS Application Protocol Specification V1.1b3. See docs/how-to/instruments-in-yaml.md.
"""

import asyncio
import contextlib
from collections.abc import Iterator
from importlib import import_module
from typing import Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from ...schemas.contract import Action, Effect, Happened, Name
from ...schemas.model import Model
from ...system.extras import not_installed
from ..driver import ActionFailed, GoalContext, Place
from .answers import BadAnswer, NoNumber, none_for, some_bits, whole_of
from .answers import value as value_of
from .bridge import Bridge, Values
from .by_action import ByAction, filled, texts
from .config import ActionConfig, ConfigFault
from .line_bridge import NUMBER_ERRORS
from .lines import NoAnswer
from .number_forms import fewest_digits
from .resource import read_resource
from .schema_faults import bits_fault

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
Kind = Literal[
    "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64", "bcd16", "bcd32",
    "bit", "string",
]  # fmt: skip


TABLES = ("holding", "input", "coil", "discrete")


class Register(Model):
    """One value of the device: which of the four tables, address from 0, type, scale."""

    holding: int | None = Field(default=None, ge=0, le=65535)
    input: int | None = Field(default=None, ge=0, le=65535)
    coil: int | None = Field(default=None, ge=0, le=65535)
    discrete: int | None = Field(default=None, ge=0, le=65535)
    type: Kind = "uint16"
    scale: float = 1.0
    offset: float = 0.0
    length: int = Field(default=8, gt=0, le=125)
    bit: int | None = Field(default=None, ge=0, le=15)
    bits: list[int] | None = None
    word_order: Literal["big", "little"] | None = None
    unit: int | None = Field(default=None, ge=0, le=255)
    nothing: list[int] = Field(default_factory=list)
    """Raw values that stand for no value, such as 32767 for a probe that is not plugged in."""

    @model_validator(mode="after")
    def _one_table(self) -> "Register":
        if len(self._tables()) != 1:
            raise ValueError("it is in one table: holding: 10, input: 10, coil: 10 or discrete: 10")
        if not self.scale:
            raise ValueError("its scale is 0, so it has no value")
        if self.bit is not None and (self.is_bit or self.type != "uint16"):
            raise ValueError("a `bit` is one of the 16 of an `input` or `holding` register")
        if self.bits is not None and (self.is_bit or self.type not in ("uint16", "uint32")):
            raise ValueError(
                "`bits` are some of those of an `input` or `holding` register, unsigned"
            )
        if self.bits is not None and (fault := bits_fault(self.bits)):
            raise ValueError(f"bits: {fault}")
        return self

    def _tables(self) -> list[str]:
        return [table for table in TABLES if getattr(self, table) is not None]

    @property
    def table(self) -> str:
        return self._tables()[0]

    @property
    def is_bit(self) -> bool:
        return self.table in ("coil", "discrete")

    @property
    def writable(self) -> bool:
        return self.table in ("holding", "coil") and (self.bit, self.bits) == (None, None)


class ModbusAction(ActionConfig):
    """`write`: register -> value, in order; then `read`: register names, which are the results."""

    write: dict[str, Any] | None = None
    read: list[str] | str | None = None

    @model_validator(mode="after")
    def _does_something(self) -> "ModbusAction":
        if not self.write and not self.read:
            raise ValueError('it needs `read: [temperature]` or `write: {target: "{target}"}`')
        return self

    @property
    def reads(self) -> list[str]:
        """The registers that are read."""
        return [self.read] if isinstance(self.read, str) else list(self.read or [])

    def guessed_effect(self) -> Effect:
        return "once" if self.write else "pure"

    def used(self) -> Iterator[tuple[str, str]]:
        yield from texts("write", self.write)


class ModbusConfig(ByAction):
    """The config of `driver: modbus`."""

    own_keys = ("words",)
    elsewhere = ": it stands beside the address of its register"
    own_errors = {  # type: ignore[assignment] # noqa: RUF012
        **{name: (happened, words) for name, happened, words in REFUSALS.values()},
        **{name: NUMBER_ERRORS[name] for name in ("BadAnswer", "NotANumber")},
    }

    resource: str
    unit: int = Field(default=1, ge=0, le=255)
    word_order: Literal["big", "little"] = "big"
    byte_order: Literal["big", "little"] = "big"
    framer: Literal["socket", "rtu", "ascii"] | None = None
    baud: int = Field(default=9600, gt=0)
    bits: Literal[7, 8] = 8
    parity: Literal["N", "E", "O"] = "N"
    stop_bits: Literal[1, 2] = 1
    shared: bool = False
    registers: dict[Name, Register] = Field(min_length=1)
    actions: dict[Name, ModbusAction] = Field(min_length=1)
    status: list[str] = Field(default_factory=list)

    @field_validator("resource")
    @classmethod
    def _is_an_address(cls, value: str) -> str:
        if read_resource(value).kind not in ("tcp", "serial"):
            raise ValueError(f"{value!r} is neither host:port nor a serial port")
        return value

    def faults(self, contract: Any, *, apart: bool) -> Iterator[ConfigFault]:
        yield from super().faults(contract, apart=apart)
        for name, said in self.actions.items():
            known = ", ".join(self.registers)
            for key, names in (("read", said.reads), ("write", list(said.write or {}))):
                for one in names:
                    path = ("actions", name, key)
                    if one not in self.registers:
                        yield ConfigFault(path, f"there is no register {one}; there is {known}")
                    elif key == "write" and not self.registers[one].writable:
                        table = self.registers[one].table
                        what = (
                            f"is a bit of a {table} register: write the whole"
                            if table == "holding"
                            else f"is in the table of {table} registers, which can only be read"
                        )
                        yield ConfigFault(path, f"{one} {what}")
            if name in contract.actions:
                returns = contract.actions[name].returns.get("properties", {})
                for one in set(returns) - set(said.reads):
                    yield ConfigFault(
                        ("actions", name), f"{name} returns {one}, which is not read", True
                    )


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
        at = read_resource(self.config.resource)
        try:
            library = import_module("pymodbus.client")
        except ImportError as fault:
            raise OSError(not_installed(fault) or str(fault)) from fault
        # A repeated request may write twice: whether to ask again is decided here.
        options: Values = {"timeout": LONGEST_S, "retries": 0, "reconnect_delay": 0}
        framer = self.config.framer or ("socket" if at.kind == "tcp" else "rtu")
        options["trace_connect"] = self._connected
        options["framer"] = import_module("pymodbus").FramerType(framer)
        if at.kind == "tcp":
            self._client = library.AsyncModbusTcpClient(at.host, port=at.port, **options)
        else:
            self._client = library.AsyncModbusSerialClient(
                at.name, baudrate=self.config.baud, bytesize=self.config.bits,
                parity=self.config.parity, stopbits=self.config.stop_bits, **options,
            )  # fmt: skip
        connected = False
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout_s):
                connected = await self._client.connect()
        if not connected:
            await self.drop()
            where = f"{self.place.device} at {at}"
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
        params = self.params(said, action)
        for number, (name, value) in enumerate((said.write or {}).items()):
            await self._write(name, filled(value, values, params, goal.id), said, first=not number)
        returns = self.config.written(action.returns.get("properties", {}), said.returns)
        found: Values = {}
        for name in said.reads:
            try:
                found[name] = _as(await self._read(name, said), returns.get(name, {}))
            except NoNumber as fault:
                found[name] = none_for(fault.name, str(fault), returns.get(name, {}))
        return {name: value for name, value in found.items() if name in returns}

    async def _read(self, name: str, said: ModbusAction) -> Any:
        one: Register = self.config.registers[name]
        first = not said.write
        address = getattr(one, one.table)
        if one.is_bit:
            calls = {"coil": "read_coils", "discrete": "read_discrete_inputs"}
            return (await self._ask(name, calls[one.table], said, first, address, count=1)).bits[0]
        kind = _kind(self._client, one)
        count = one.length if one.type == "string" else kind.value[1]
        call = f"read_{one.table}_registers"
        words = (await self._ask(name, call, said, first, address, count=count)).registers
        if one.bit is not None:
            return bool(words[0] >> one.bit & 1)
        words = self._ordered(words, one)
        value = self._client.convert_from_registers(words, kind)
        if isinstance(value, str):
            return value.rstrip("\0 ")
        if value in one.nothing:
            raise NoNumber("NotANumber", f"{name} is {value}: the device has no value")
        if one.type.startswith("float") and value != value:
            raise NoNumber("NotANumber", f"{name} is NaN: the device has no value")
        if one.type == "float32":
            value = float(fewest_digits(value, ">f"))
        if one.type.startswith("bcd"):
            value = _of_digits(name, int(value))
        if one.bits is not None:
            value = some_bits(int(value), one.bits)
        return value * one.scale + one.offset if (one.scale, one.offset) != (1, 0) else value

    async def _write(self, name: str, value: Any, said: ModbusAction, *, first: bool) -> None:
        one: Register = self.config.registers[name]
        if one.is_bit:
            await self._put(name, "write_coil", said, first, one.coil, bool(value))
            return
        kind = _kind(self._client, one)
        if one.type != "string":
            number = (float(value) - one.offset) / one.scale
            value = number if one.type.startswith("float") else round(number)
        try:
            raw = int(str(value), 16) if one.type.startswith("bcd") else value
            words = self._ordered(self._client.convert_to_registers(raw, kind), one)
        except Exception as fault:  # struct.error and the library's own, for what does not fit
            words = f"{name}: {value!r} does not fit into {one.type}: {fault}"
            raise ActionFailed("IllegalValue", words, "no" if first else "unknown") from fault
        if len(words) == 1:
            await self._put(name, "write_register", said, first, one.holding, words[0])
        else:
            await self._ask(name, "write_registers", said, first, one.holding, words)

    async def _put(self, name: str, call: str, said: Any, first: bool, at: Any, value: Any) -> None:
        """Write one by the function for one; by that for several, if the device has no other."""
        try:
            await self._ask(name, call, said, first, at, value)
        except ActionFailed as failure:
            if failure.name != "IllegalFunction":
                raise
            await self._ask(name, f"{call}s", said, first, at, [value])

    def _ordered(self, words: list[int], one: Register) -> list[int]:
        """Registers as the specification has them, highest first, or as this device has them.

        A text has no highest word, but its two letters may lie the other way round.
        """
        if self.config.byte_order == "little" and one.type not in ("int16", "uint16"):
            words = [word >> 8 | (word & 0xFF) << 8 for word in words]
        order = one.word_order or self.config.word_order
        return words[::-1] if order == "little" and one.type != "string" else words

    async def _ask(
        self, name: str, call: str, said: Any, first: bool, *given: Any, **more: Any
    ) -> Any:
        """One request; a refusal of the first one means that nothing happened."""
        library = import_module("pymodbus.exceptions")
        client = self._client
        if client is None:
            raise OSError("the connection was closed")
        own = self.config.registers[name].unit
        unit = self.config.unit if own is None else own
        words = f"{self.place.device} was asked to {call.replace('_', ' ')} {given[0]} ({name})"
        try:
            async with asyncio.timeout(self.timeout_s(said)) as waiting:
                self._waiting.add(waiting)
                try:
                    answer = await getattr(client, call)(*given, device_id=unit, **more)
                finally:
                    self._waiting.discard(waiting)
        except (TimeoutError, library.ModbusIOException) as fault:
            if not client.connected:
                raise OSError(f"{words}, and the connection was closed") from fault
            raise NoAnswer(f"{words} and was silent") from fault
        except library.ConnectionException as fault:
            raise OSError(f"{words}: {fault}") from fault
        if not answer.isError():
            return answer
        code = answer.exception_code
        error, happened, meaning = REFUSALS.get(
            code, ("DeviceFailure", "unknown", "see its manual")
        )
        for named, one in {**self.config.errors, **said.errors}.items():
            if one.code == code:
                error, happened, meaning = named, one.happened, one.summary
        raise ActionFailed(
            error, f"{words} and refused with exception {code}: {meaning}",
            happened if first or happened != "no" else "unknown",
        )  # fmt: skip


def _kind(client: Any, one: Register) -> Any:
    return client.DATATYPE[one.type.upper().replace("BCD", "UINT")]


def _of_digits(name: str, value: int) -> int:
    """What four bits for each decimal digit are; raises BadAnswer."""
    if not f"{value:x}".isdigit():
        raise BadAnswer(f"{name} is {value:#x}, and of BCD each digit is 0 to 9")
    return int(f"{value:x}")


def _as(value: Any, schema: dict[str, Any]) -> Any:
    if "words" in schema:
        return value_of(str(int(value) if isinstance(value, bool) else value), schema)
    kind = schema.get("type", "number")
    if kind == "boolean" or (isinstance(kind, list) and "boolean" in kind):
        return bool(value)
    value = float(f"{value:.12g}") if isinstance(value, float) else value
    return whole_of(value) if kind == "integer" else value
