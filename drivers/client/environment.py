"""What is wrong with the environment of an interpreter that a lab names, as a sentence."""

import asyncio
import subprocess

from ... import __version__

ASK_S = 10.0
OLDEST = (3, 11)
ASK = """
import sys
sys.path.remove("")
from importlib import metadata
try:
    print("python", *sys.version_info[:2], metadata.version("labrun"))
except metadata.PackageNotFoundError:
    print("python", *sys.version_info[:2], "-")
"""


async def fault_of(python: str, *, spoke: bool = False) -> str | None:
    """Why no server starts with it, and what now; None if it is an environment as this one.

    `spoke`: a server of it has said itself what is wrong, so that labrun is there, of whatever version.
    """
    fault, other = await _asked(python)
    return fault if other or not spoke else None


async def _asked(python: str) -> tuple[str | None, bool]:
    """What is wrong with it, and whether that is only another labrun than this."""
    try:
        told = await asyncio.to_thread(
            subprocess.run, [python, "-c", ASK], stdin=subprocess.DEVNULL, capture_output=True,
            timeout=ASK_S, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return f"{_what(python)} does not answer within {ASK_S:g} s", False
    except OSError as fault:
        return f"{_what(python)} cannot be started ({fault.strerror or fault})", False
    words = told.stdout.decode(errors="replace").split()
    if len(words) != 4 or words[0] != "python":
        return f"{_what(python)} is no Python", False
    release, there = (int(words[1]), int(words[2])), words[3]
    if release < OLDEST:
        old = f"{_what(python)} is Python {words[1]}.{words[2]}"
        return f"{old}, and labrun needs 3.11 or newer", False
    if there == "-":
        return f"its environment needs labrun, too: `{python} -m pip install labrun`", False
    if there != __version__:
        return (
            f"its environment has labrun {there}, and this is {__version__}: "
            f"`{python} -m pip install labrun=={__version__}`"
        ), True
    return None, False


def _what(python: str) -> str:
    return f"`python: {python}`, which the lab names,"
