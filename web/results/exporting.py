"""A run as a file of another program's format, as `labrun export` writes it, in a process of its own."""

import os
import tempfile
from pathlib import Path

from fastapi.responses import FileResponse
from starlette.background import BackgroundTask

from ...engine.export.formats import SUFFIXES, formats
from ...system.files import remove
from ..local.command import labrun
from ..local.refusal import Refusal, not_found

LONGEST_S = 300.0


async def exported(folder: Path, format: str) -> FileResponse:
    """The file, which is deleted once it has been sent; raises Refusal with what the command said."""
    if format not in formats():
        raise not_found("format", format, f"there is {', '.join(sorted(formats()))}")
    name = f"{folder.name}.{SUFFIXES.get(format, format)}"
    handle, place = tempfile.mkstemp(suffix=f".{format}")
    os.close(handle)
    out = Path(place)
    status, said = await labrun(
        "export", str(folder), "--to", format, "--out", place, longest_s=LONGEST_S
    )
    if status != 0:
        remove(out)
        words = f"labrun export ended with {status}"
        if status is None:
            words = f"it took longer than {LONGEST_S:.0f} s: use labrun export in a shell"
        raise Refusal(422, "NOT_EXPORTED", said[-1] if said else words)
    return FileResponse(out, filename=name, background=BackgroundTask(remove, out))
