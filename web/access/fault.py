"""An internal error: one line on the terminal, the traceback in a log, and a sentence as answer."""

import logging
import os
import platform
import traceback
from datetime import UTC, datetime
from pathlib import Path

from fastapi import Request
from fastapi.responses import JSONResponse, Response

from ... import __version__
from ...system.files import BINARY
from ..models.base import Fault

MOST_BYTES = 1_000_000
LOG = logging.getLogger(__name__)


class FaultLog:
    """A file that only its owner can read; it restarts when it gets too long."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def note(self, doing: str, fault: BaseException) -> None:
        """Log an error with versions; of the request only method and path."""
        about = f"labrun {__version__}, Python {platform.python_version()}, {platform.platform()}"
        trace = "".join(traceback.format_exception(fault))
        told = f"{datetime.now(UTC).isoformat()}  {about}\n{doing}\n{trace}\n"
        kind = type(fault).__name__
        try:
            too_long = self.path.exists() and self.path.stat().st_size > MOST_BYTES
            flags = BINARY | os.O_WRONLY | os.O_CREAT | (os.O_TRUNC if too_long else os.O_APPEND)
            with os.fdopen(os.open(self.path, flags, 0o600), "w", encoding="utf-8") as file:
                file.write(told)
            LOG.error("an internal error in labrun (%s); please report it with %s", kind, self.path)
        except OSError:  # no log can be written: the error's own text has to do
            LOG.error("an internal error in labrun (%s: %s) at %s", kind, fault, doing)


async def answer_fault(request: Request, fault: Exception) -> Response:
    """The answer to the page; the server logs the error, since Starlette raises it again."""
    told = Fault(
        code="FAULT", message=f"an internal error in labrun ({type(fault).__name__}); check the "
        "present state before you try again", hint="the details are in the server's log",
    )  # fmt: skip
    return JSONResponse(told.model_dump(), 500)
