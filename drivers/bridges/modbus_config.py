"""What a lab says of a Modbus device: its registers with types and units, and its actions.

MODBUS Application Protocol Specification V1.1b3. See docs/how-to/instruments-in-yaml.md.
"""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from ...schemas.contract import Action, Effect, Happened, Name
from ...schemas.model import Model
from .answers import NUMBER_ERRORS
from .bridge import Values
from .config import LISTED, ActionConfig, BridgeConfig, ConfigFault, chosen
from .number_forms import size_of
from .resource import Wire
from .schema_faults import own_faults
from .template import texts

REFUSALS: dict[int, tuple[str, Happened, str]] = {
    1: ("IllegalFunction", "no", "the device does not have this function"),
    2: ("IllegalAddress", "no", "the device has no such register"),
    3: ("IllegalValue", "no", "the device does not take this value"),
    4: ("DeviceFailure", "unknown", "the device failed while it was doing it"),
    5: ("DeviceFailure", "unknown", "the device has accepted it and needs time"),
    6: ("DeviceBusy", "no", "the device is busy"),
}
"""Exception code -> error, whether it happened, meaning (section 7 of the specification)."""
KINDS = {
    "int16": ">i2", "uint16": ">u2", "int32": ">i4", "uint32": ">u4", "int64": ">i8", "uint64": ">u8",
    "float32": ">f4", "float64": ">f8", "bcd16": ">bcd2", "bcd32": ">bcd4", "string": "",
}  # fmt: skip
"""How the bytes of a register are written."""
TABLES = ("holding", "input", "coil", "discrete")
OF_MANUALS = {"0": "coil", "1": "discrete", "3": "input", "4": "holding"}
"""The first digit by which manuals number the registers of a table, from 1."""
Address = Annotated[int, Field(ge=0, le=65535)]


def of_manual(number: object) -> str:
    """`holding: 0` for the 40001 or 400001 of a manual; empty for another number."""
    digits = str(number)
    table = OF_MANUALS.get(digits[:1])
    if table is None or len(digits) not in (5, 6) or not digits.isdecimal() or not int(digits[1:]):
        return ""
    return f"{table}: {int(digits[1:]) - 1}"


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

    @model_validator(mode="before")
    @classmethod
    def _as_manuals_number(cls, data: Any) -> Any:
        given = {None: data} if not isinstance(data, dict) else {t: data.get(t) for t in TABLES}
        for table, number in given.items():
            said = of_manual(number)
            if said and (table is None or not (isinstance(number, int) and number <= 65535)):
                raise ValueError(f"{number} of a manual is {{{said}}} here: addresses count from 0")
        return data

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
