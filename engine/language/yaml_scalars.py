"""The value of a plain YAML scalar in the core schema of YAML 1.2: `no`, `on`, `1:30` are text."""

import math
import re
from typing import Any

NULLS = {"", "~", "null", "Null", "NULL"}
TRUE = {"true", "True", "TRUE"}
FALSE = {"false", "False", "FALSE"}
INTEGER = re.compile(r"[-+]?[0-9]+")
OCTAL = re.compile(r"0o[0-7]+")
HEX = re.compile(r"0x[0-9a-fA-F]+")
FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
LONGEST_NUMBER = 200
"""Digits, of which a whole number is still within what a float can be, also one in hex."""


class ScalarFault(ValueError):
    """A scalar without a usable value; the message says why."""


def plain_value(text: str) -> Any:
    """The value of a scalar without quotes and without a tag."""
    first = text[:1]
    if first in "tTfFnN~" or not first:
        return _word(text)
    if first not in "+-.0123456789":
        return text
    return _number(text)


def _word(text: str) -> Any:
    if text in NULLS:
        return None
    if text in TRUE:
        return True
    return False if text in FALSE else text


def _number(text: str) -> Any:
    if NOT_FINITE.fullmatch(text):
        raise ScalarFault(f"{text} is not a number that a device can use")
    if len(text) > LONGEST_NUMBER:
        if FLOAT.fullmatch(text):
            raise ScalarFault(f"a number of {len(text)} digits is too large")
        return text
    if INTEGER.fullmatch(text):
        return int(text)
    if OCTAL.fullmatch(text):
        return int(text[2:], 8)
    if HEX.fullmatch(text):
        return int(text[2:], 16)
    if FLOAT.fullmatch(text):
        value = float(text)
        if math.isinf(value):
            raise ScalarFault(f"{text} is too large for a number")
        return value
    return text


def tagged_value(tag: str, text: str) -> Any:
    """The value of a scalar with one of YAML's own tags, such as `!!str`."""
    if tag == "str":
        return text
    value = plain_value(text)
    if tag == "float" and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    wanted = {"int": int, "float": float, "bool": bool, "null": type(None)}.get(tag)
    if wanted is None or type(value) is not wanted:
        raise ScalarFault(f"{text!r} is not of the type !!{tag}")
    return value


def whole_text(text: str) -> str:
    r"""The text with each surrogate pair (`\ud83d\ude00`, as in JSON) as one character."""
    try:
        text.encode()
    except UnicodeEncodeError:
        try:
            return text.encode("utf-16", "surrogatepass").decode("utf-16")
        except UnicodeDecodeError:
            raise ScalarFault(
                r"half of a character: one part of a pair such as \ud83d\ude00 is missing"
            ) from None
    return text
