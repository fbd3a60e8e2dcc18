"""A fault of our own: one line on the terminal, the whole of it in a log, and an answer in words."""

import logging
import os
import platform
import traceback
from datetime import UTC, datetime
from pathlib import Path

from fastapi import Request
from fastapi.responses import JSONResponse, Response

from ... import __version__
from ..models.told import Fault

MOST_BYTES = 1_000_000
LOG = logging.getLogger(__name__)


class FaultLog:
    """A file that only its owner reads; it begins anew where it has become too long."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def note(self, doing: str, fault: BaseException) -> None:
        """Write a fault down with versions; nothing of what was sent to us but method and path."""
        about = f"labrun {__version__}, Python {platform.python_version()}, {platform.platform()}"
        trace = "".join(traceback.format_exception(fault))
        told = f"{datetime.now(UTC).isoformat()}  {about}\n{doing}\n{trace}\n"
        kind = type(fault).__name__
        try:
            too_long = self.path.exists() and self.path.stat().st_size > MOST_BYTES
            flags = os.O_WRONLY | os.O_CREAT | (os.O_TRUNC if too_long else os.O_APPEND)
            with os.fdopen(os.open(self.path, flags, 0o600), "w", encoding="utf-8") as file:
                file.write(told)
            LOG.error("a fault in labrun itself (%s); please report it with %s", kind, self.path)
        except OSError:  # no room for a log, either: the fault's own words have to do
            LOG.error("a fault in labrun itself (%s: %s) at %s", kind, fault, doing)


async def answer_fault(request: Request, fault: Exception) -> Response:
    """What the page is told of it; whoever serves notes it, since Starlette raises it again."""
    told = Fault(
        code="FAULT", message=f"a fault in labrun itself ({type(fault).__name__}); look at what is "
        "so now before you ask again", hint="the server has written it into its log",
    )  # fmt: skip
    return JSONResponse(told.model_dump(), 500)
