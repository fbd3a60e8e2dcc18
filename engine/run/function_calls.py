"""Call a function of a protocol's own, in a process of its own, with a limit of time."""

import asyncio
import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

from ...system.process import apart
from ..language.operators import OperatorFault
from ..language.own_functions import OwnFunction

COMMAND = (sys.executable, "-I", str(Path(__file__).with_name("function_process.py")))
LIMIT_S = 60.0
"""How long a call may take where its step has no `timeout`."""
LONGEST_S = 24 * 3600.0
BEHIND_S = 5.0
"""How long after its limit a process ends by itself, where its engine was killed."""
LARGEST = 10_000_000


class FunctionFailed(Exception):
    """A function that raised, ended its process or took too long; the text says which and why."""


async def call(function: OwnFunction, given: dict[str, Any], limit_s: float = LIMIT_S) -> Any:
    """What the function gives for plain arguments; raises FunctionFailed."""
    process = await asyncio.create_subprocess_exec(
        *COMMAND, stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE, **apart(),
    )  # fmt: skip
    try:
        async with asyncio.timeout(limit_s if limit_s < math.inf else None):
            out, err = await process.communicate(_asked(function, given, limit_s))
    except TimeoutError:
        why = f"{function.name} took longer than {limit_s:g} s; a `timeout` of its `set` allows another time"
        raise FunctionFailed(why) from None
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
    return _answer(function, out, err, process.returncode)


async def call_at_once(
    function: OwnFunction, given: dict[str, Any], limit_s: float = LIMIT_S
) -> Any:
    """The same where time is virtual: nothing else goes on meanwhile, and no virtual time passes."""
    limit_s = min(limit_s, LIMIT_S)
    try:
        done = subprocess.run(  # noqa: ASYNC221
            COMMAND,
            input=_asked(function, given, limit_s),
            capture_output=True,
            timeout=limit_s,
            check=False,
            **apart(),
        )
    except subprocess.TimeoutExpired:
        raise FunctionFailed(f"{function.name} took longer than {limit_s:g} s") from None
    return _answer(function, done.stdout, done.stderr, done.returncode)


def _asked(function: OwnFunction, given: dict[str, Any], limit_s: float) -> bytes:
    asked = {"file": str(function.path), "text": function.text, "function": function.function}
    alone_s = min(limit_s, LONGEST_S) + BEHIND_S
    return json.dumps({**asked, "given": given, "limit_s": alone_s}).encode()


def _answer(function: OwnFunction, out: bytes, err: bytes, code: int | None) -> Any:
    name = function.name
    if len(out) > LARGEST:
        raise FunctionFailed(
            f"{name} gave {len(out) / 1e6:.0f} MB; the limit is {LARGEST / 1e6:.0f} MB"
        )
    try:
        told = json.loads(out)
    except ValueError:
        last = err.decode(errors="replace").strip().rpartition("\n")[2]
        said = f": {last}" if last else ""
        raise FunctionFailed(f"{name} ended its process (exit status {code}){said}") from None
    if "error" in told:
        where = f" ({function.written}, line {told['line']})" if told["line"] else ""
        raise FunctionFailed(f"{name}: {told['error']}: {told['message']}{where}")
    try:
        return function.result(told["result"])
    except OperatorFault as fault:
        raise FunctionFailed(str(fault)) from fault
