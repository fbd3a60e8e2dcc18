"""Protocols built in Python: plain dataclasses that become the YAML a person would write.

Whether they make sense is asked of `labrun.check`, as of any protocol: nothing is checked here.
"""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, make_dataclass
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.scalarstring import SingleQuotedScalarString

from ...schemas import protocol as schema
from ...schemas.quantity import is_quantity, quantity_text
from ..language.load import read_protocol
from ..language.source import read_source
from ..language.yaml_write import SIGNS
from .faults import ProtocolFault

WIDEST = 96
"""What fits in a line of so many characters is written in one."""
FIRST = ("id", "name", "when")
BLOCKS = {*schema.STEP_LISTS, "collect"}
"""What is written below the rest of its step, and never in one line with it."""
TRUTHS = ("yes", "no", "on", "off", "y", "n")
"""Texts that older readers of YAML take for true and false."""


@dataclass
class Protocol:
    """A protocol; a step is one of `labrun.steps`, or a mapping with the keys of the YAML.

    Values may be texts (`"1 mm"`, `"${{ n }}"`), numbers, quantities and arrays. `labrun.check`, `run`
    and `rehearse` take it like a file; the files that it names are looked for in the current folder.
    """

    name: str
    steps: Sequence[Any]
    summary: str = ""
    params: Mapping[str, Any] = field(default_factory=dict)
    devices: Mapping[str, str] = field(default_factory=dict)
    functions: Mapping[str, str] = field(default_factory=dict)
    defaults: Mapping[str, Any] = field(default_factory=dict)
    on_resume: Sequence[Any] = ()
    finally_: Sequence[Any] = ()
    outputs: Mapping[str, Any] = field(default_factory=dict)

    def dump(self) -> str:
        """The protocol as YAML. Raises TypeError for a value that YAML has no word for."""
        keys = sorted(
            fields(self), key=lambda one: list(schema.Protocol.model_fields).index(one.name)
        )
        whole = {_key(one.name): plain(getattr(self, one.name)) for one in keys}
        laid = CommentedMap(labrun=1)
        for key, value in whole.items():
            if value not in ("", {}, []):
                laid[key] = _laid_out(value, 2 + len(key))
        out = io.StringIO()
        yaml = YAML()
        yaml.width = 4096
        yaml.indent(mapping=2, sequence=4, offset=2)
        yaml.dump(laid, out)
        return out.getvalue()

    def save(self, file: str | Path) -> None:
        """Write the YAML to a file."""
        Path(file).write_text(self.dump(), encoding="utf-8")

    @classmethod
    def read(cls, file: str | Path) -> "Protocol":
        """The protocol in a file, its steps as mappings; raises ProtocolFault where it is none."""
        source, problems = read_source(Path(file))
        loaded, more = read_protocol(source) if source is not None else (None, [])
        problems = [*problems, *more]
        if source is None or loaded is None or any(one.severity == "error" for one in problems):
            raise ProtocolFault(problems, source)
        names = {f.name for f in fields(cls)}
        return cls(
            **{k if k in names else f"{k}_": v for k, v in source.data.items() if k != "labrun"}
        )


def plain(value: Any) -> Any:
    """A value as YAML has it."""
    if is_dataclass(value) and not isinstance(value, type):
        given = {f.name: getattr(value, f.name) for f in fields(value)}
        return {_key(name): plain(one) for name, one in given.items() if one is not None}
    if is_quantity(value):
        return quantity_text(value)
    if (numpys := getattr(value, "tolist", None)) is not None:  # arrays and numbers
        return plain(numpys())
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, Path):
        return value.as_posix()
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return [plain(one) for one in value]
    if value is None or isinstance(value, str | bool | int | float):
        return value
    raise TypeError(f"{value!r} is no value of a protocol; give text, a number or a quantity")


def _step(kind: type[schema.StepBase]) -> Any:
    """A dataclass with the keys of a step, its keyword first; `with_`, `if_` where Python has the word."""
    keyword = next(name for name in kind.model_fields if _key(name) == kind.KIND)
    rest = [name for name in kind.model_fields if name != keyword]
    of = [(keyword, Any), *((name, Any, field(default=None, kw_only=True)) for name in rest)]
    namespace = {"__doc__": kind.__doc__, "__module__": __name__}
    return make_dataclass(kind.__name__, of, namespace=namespace)


def _key(name: str) -> str:
    return name.removesuffix("_")


def _laid_out(value: Any, used: int) -> Any:
    """The value for ruamel: in one line where it fits, steps in the order that people write."""
    if isinstance(value, dict):
        if schema.step_kind(value):
            value = {key: value[key] for key in sorted(value, key=lambda key: _rank(value, key))}
        made: Any = CommentedMap((k, _laid_out(v, used + len(k) + 2)) for k, v in value.items())
    elif isinstance(value, list):
        made = CommentedSeq(_laid_out(one, used + 2) for one in value)
    else:
        text = value if isinstance(value, str) else ""
        quoted = text.lower() in TRUTHS or text.startswith(SIGNS)
        return SingleQuotedScalarString(value) if quoted else value
    if isinstance(value, list):
        block = any(schema.step_kind(one) for one in value)
    elif schema.step_kind(value):
        block = len(value) == 1 or not BLOCKS.isdisjoint(value)
    else:
        block = any(isinstance(one, dict) for one in value.values())
    if not block and len(repr(value)) + used <= WIDEST:
        made.fa.set_flow_style()
    return made


def _rank(step: dict[str, Any], key: str) -> tuple[int, int]:
    """Where a key stands in its step: name, keyword, its own keys, those of any step, what is below."""
    if key in FIRST:
        return 0, FIRST.index(key)
    if key == schema.step_kind(step) and key not in BLOCKS:
        return 1, 0
    return 4 if key in BLOCKS else 3 if key in schema.StepBase.model_fields else 2, list(
        step
    ).index(key)


Do, Parallel, AnyOf = _step(schema.Do), _step(schema.Parallel), _step(schema.AnyOf)
Foreach, Repeat, While = _step(schema.Foreach), _step(schema.Repeat), _step(schema.While)
If, Use, Group = _step(schema.If), _step(schema.Use), _step(schema.Group)
Confirm, Ask, Wait = _step(schema.Confirm), _step(schema.Ask), _step(schema.Wait)
Set, Require, Log, Fail = (
    _step(schema.Set), _step(schema.Require), _step(schema.Log), _step(schema.Fail),
)  # fmt: skip
