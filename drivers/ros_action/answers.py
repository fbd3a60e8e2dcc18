"""What a robot says while it does a goal and when it has ended, in the contract's words.

feedback: {progress: done, message: "{distance_remaining:.2f} m to go"}
error:
  code: error_code.val            # the field of the result that says what went wrong
  ok: [1]                         # what it is when nothing did; by default 0, true and ""
  message: error_string
  names: {-4: PathTolerance}      # code -> an error of the contract; others are `aborted`
"""

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..driver import check_keys
from .bridge import Values
from .field_path import FieldPath, get, read_path

FEEDBACK_KEYS, ERROR_KEYS = ("progress", "message"), ("code", "ok", "message", "names")
PLACE = re.compile(r"\{([^{}:]+)(?::(\.?\d*[dfg]))?\}")


@dataclass(frozen=True, slots=True)
class Feedback:
    """Where progress (0..1) is, and the text, with places of the message in braces."""

    progress: FieldPath = ("progress",)
    text: str | None = None

    def read(self, message: Values) -> tuple[float | None, str]:
        """Progress and text of one message."""
        progress = get(message, self.progress)
        known = isinstance(progress, (int, float)) and math.isfinite(progress)
        if self.text is not None:
            words = PLACE.sub(lambda found: _written(message, found), self.text)
        else:
            words = message.get("message", message.get("msg", message.get("feedback", "")))
        return (float(progress) if known else None), words if isinstance(words, str) else ""


@dataclass(frozen=True, slots=True)
class Failure:
    """Where a result says that it failed; by default as labrun's own action servers do."""

    code: FieldPath = ("error_name",)
    ok: tuple[Any, ...] = ()
    message: FieldPath = ("error_message",)
    names: Mapping[str, str] = field(default_factory=dict)

    def of(self, result: Values) -> tuple[str, str] | None:
        """The code and the message of a result that failed; None if it says nothing of the kind."""
        code = get(result, self.code)
        words = get(result, self.message)
        if code is None or self._is_ok(code):
            return None
        return str(code), words if isinstance(words, str) else ""

    def _is_ok(self, code: Any) -> bool:
        if self.ok:
            return any(type(one) is type(code) and one == code for one in self.ok)
        return code if isinstance(code, bool) else code in (0, "")


SERVICE = Failure(("success",), (), ("message",))
"""As std_srvs/srv/Trigger and SetBool do; a response without `success` has not failed."""


def read_feedback(written: Any, where: str) -> Feedback:
    """Raises ValueError."""
    if written is None:
        return Feedback()
    given = _known(written, FEEDBACK_KEYS, where)
    text = given.get("message")
    if text is not None:
        text = str(text) if "{" in str(text) else f"{{{text}}}"
        for found in PLACE.finditer(text):
            _path(found[1], f"{where}.message")
    return Feedback(_path(given.get("progress", "progress"), f"{where}.progress"), text)


def read_failure(written: Any, errors: Collection[str], default: Failure, where: str) -> Failure:
    """Raises ValueError."""
    if written is None:
        return default
    given = _known(written, ERROR_KEYS, where)
    ok, names = given.get("ok", []), given.get("names", {})
    if not isinstance(names, dict):
        raise ValueError(f"{where}.names must be written as `{{code: Error}}`")
    for name in names.values():
        if name not in errors:
            known = ", ".join(errors) or "none"
            raise ValueError(
                f"{where}.names: {name} is not an error of the contract; it has {known}"
            )
    return Failure(
        _path(given.get("code", ".".join(map(str, default.code))), f"{where}.code"),
        tuple(ok) if isinstance(ok, list) else (ok,),
        _path(given.get("message", ".".join(map(str, default.message))), f"{where}.message"),
        {str(code): name for code, name in names.items()},
    )


def _known(written: Any, keys: tuple[str, ...], where: str) -> dict[str, Any]:
    if not isinstance(written, dict):
        raise ValueError(f"{where} must be a mapping of {', '.join(keys)}")
    check_keys(keys, written, where)
    return written


def _path(written: Any, where: str) -> FieldPath:
    try:
        return read_path(str(written))
    except ValueError as fault:
        raise ValueError(f"{where}: {fault}") from fault


def _written(message: Values, found: "re.Match[str]") -> str:
    value = get(message, read_path(found[1]))
    if value is None:
        return "?"
    try:
        return format(value, found[2] or "")
    except (ValueError, TypeError):
        return str(value)
