"""Frames of the protocol: parsed from a client's data, written as JSON text or CBOR bytes."""

import json
import math
import sys
from array import array
from typing import Any

from ..interfaces.kinds import Field, Message

MOST_BYTES = 16 * 2**20
DEEPEST = 60
CBOR_TAGS = {"int64": (79, "q"), "float32": (85, "f"), "float64": (86, "d")}
"""RFC 8746: little-endian typed arrays."""


class Misformed(ValueError):
    """A frame that is not a valid message of the protocol, with the reason."""


def read(data: str | bytes) -> dict[str, Any]:
    """A message; raises Misformed."""
    try:
        message = json.loads(data if isinstance(data, str) else data.decode())
    except UnicodeDecodeError:
        raise Misformed("a binary frame must be JSON in UTF-8") from None
    except ValueError as fault:
        raise Misformed(f"not JSON: {fault}") from fault
    except RecursionError:
        raise Misformed(f"nested deeper than {DEEPEST} levels") from None
    if not isinstance(message, dict):
        raise Misformed("a message must be a JSON object with an `op`")
    if _deeper_than(message, DEEPEST):
        raise Misformed(f"nested deeper than {DEEPEST} levels")
    return message


def as_json(message: dict[str, Any]) -> str:
    """A message as text; NaN, which JSON lacks, becomes null, as in rosbridge."""
    try:
        return json.dumps(message, allow_nan=False, ensure_ascii=False)
    except ValueError:
        return json.dumps(_finite(message), allow_nan=False, ensure_ascii=False)


def as_cbor(message: dict[str, Any], kind: Message) -> bytes:
    """A `publish` of a topic as CBOR, with packed arrays of numbers."""
    import cbor2

    return cbor2.dumps({**message, "msg": _packed(message["msg"], kind)})


def _packed(values: dict[str, Any], kind: Message) -> dict[str, Any]:
    fields = {field.name: field for field in kind.fields}
    return {n: _pack(v, fields[n]) if n in fields else v for n, v in values.items()}


def _pack(value: Any, field: Field) -> Any:
    import cbor2

    if field.message is not None:
        if isinstance(value, list):
            return [_packed(one, field.message) for one in value]
        return _packed(value, field.message)
    if not isinstance(value, list) or field.type not in CBOR_TAGS:
        return value
    tag, code = CBOR_TAGS[field.type]
    packed = array(code, value)
    if sys.byteorder == "big":
        packed.byteswap()
    return cbor2.CBORTag(tag, packed.tobytes())


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {name: _finite(one) for name, one in value.items()}
    if isinstance(value, list):
        return [_finite(one) for one in value]
    return value


def _deeper_than(value: Any, levels: int) -> bool:
    layer = [value]
    for _ in range(levels):
        layer = [
            inner
            for one in layer
            if isinstance(one, (dict, list))
            for inner in (one.values() if isinstance(one, dict) else one)
            if isinstance(inner, (dict, list))
        ]
        if not layer:
            return False
    return True


def want(message: dict[str, Any], name: str, kind: type | tuple[type, ...], words: str) -> Any:
    """A required field of an operation; raises Misformed."""
    if message.get(name) is None:
        raise Misformed(f"`{message['op']}` needs `{name}`, {words}")
    return may(message, name, kind, words)


def may(
    message: dict[str, Any],
    name: str,
    kind: type | tuple[type, ...],
    words: str,
    absent: Any = None,
) -> Any:
    """An optional field; raises Misformed if it has another type."""
    value = message.get(name)
    if value is None:
        return absent
    if not isinstance(value, kind) or (isinstance(value, bool) and kind in (int, (int, float))):
        raise Misformed(f"`{name}` of `{message['op']}` must be {words}")
    return value
