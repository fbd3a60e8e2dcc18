"""Modbus devices over TCP or a serial line, by pymodbus; what a lab says of them is in `modbus_config`."""

import asyncio
from typing import Any, ClassVar

from ...schemas.contract import Action
from ...system.extras import needed
from ..driver import ActionFailed, GoalContext, Place
from ..serial_io.open_port import open_exclusively
from .answers import BadAnswer, NoNumber, value
from .bridge import Bridge, Values, doubtful
from .lines import NoAnswer
from .modbus_config import REFUSALS, ModbusAction, ModbusConfig, Register, of_manual
from .resource import read_resource
from .template import filled, written

LONGEST_S = 3600.0
"""The library's own patience; how long is waited is said by each action."""
READING = {
    "holding": "read_holding_registers", "input": "read_input_registers", "coil": "read_coils",
    "discrete": "read_discrete_inputs",
}  # fmt: skip
"""Table -> how the library reads it."""


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
        if error == "IllegalAddress" and (other := of_manual(address)):
            told += f"; the {address} of a manual is {{{other}}} here"
        raise ActionFailed(error, told, happened)


def _words(data: bytes) -> list[int]:
    data += b"\0" * (len(data) % 2)
    return [int.from_bytes(data[at : at + 2], "big") for at in range(0, len(data), 2)]
