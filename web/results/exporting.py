"""A run as a file of another program's format, as `labrun export` writes it, in a process of its own."""

import asyncio
import os
import subprocess
import tempfile
from pathlib import Path

from fastapi.responses import FileResponse
from starlette.background import BackgroundTask

from ...engine.export.formats import SUFFIXES, formats
from ...system.files import remove
from ...system.process import start_python, stop
from ..local.refusal import Refusal, not_found

LONGEST_S = 300.0
END_S = 2.0


async def exported(folder: Path, format: str) -> FileResponse:
    """The file, which is deleted once it has been sent; raises Refusal with what the command said."""
    if format not in formats():
        raise not_found("format", format, f"there is {', '.join(sorted(formats()))}")
    name = f"{folder.name}.{SUFFIXES.get(format, format)}"
    handle, place = tempfile.mkstemp(suffix=f".{format}")
    os.close(handle)
    out = Path(place)
    status, said = await _run(str(folder), format, out)
    if status != 0:
        remove(out)
        words = said.replace("labrun: ", "").strip().splitlines()
        raise Refusal(
            422, "NOT_EXPORTED", words[-1] if words else f"labrun export ended with {status}"
        )
    return FileResponse(out, filename=name, background=BackgroundTask(remove, out))


async def _run(folder: str, format: str, out: Path) -> tuple[int | None, str]:
    process = await start_python(
        "labrun.engine", "export", folder, "--to", format, "--out", str(out),
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env={**os.environ, "NO_COLOR": "1"},
    )  # fmt: skip
    try:
        async with asyncio.timeout(LONGEST_S):
            _, said = await process.communicate()
    except TimeoutError:
        return None, f"it took longer than {LONGEST_S:.0f} s: use labrun export in a shell"
    finally:
        if process.returncode is None:
            await stop(process, END_S)
    return process.returncode, said.decode(errors="replace")
