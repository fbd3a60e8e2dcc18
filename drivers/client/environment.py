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


async def fault_of(python: str) -> str | None:
    """Why no server starts with it, and what now; None if it is an environment as this one."""
    try:
        told = await asyncio.to_thread(
            subprocess.run, [python, "-c", ASK], stdin=subprocess.DEVNULL, capture_output=True,
            timeout=ASK_S, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return f"{_what(python)} does not answer within {ASK_S:g} s"
    except OSError as fault:
        return f"{_what(python)} cannot be started ({fault.strerror or fault})"
    words = told.stdout.decode(errors="replace").split()
    if len(words) != 4 or words[0] != "python":
        return f"{_what(python)} is no Python"
    release, there = (int(words[1]), int(words[2])), words[3]
    if release < OLDEST:
        return f"{_what(python)} is Python {words[1]}.{words[2]}, and labrun needs 3.11 or newer"
    if there == "-":
        return f"its environment needs labrun, too: `{python} -m pip install labrun`"
    if there != __version__:
        return (
            f"its environment has labrun {there}, and this is {__version__}: "
            f"`{python} -m pip install labrun=={__version__}`"
        )
    return None


def _what(python: str) -> str:
    return f"`python: {python}`, which the lab names,"
