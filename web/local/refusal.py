"""A refusal: nothing was done, and the answer says why in a sentence."""

from typing import Any

from fastapi import Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, Response
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from ...system import extras
from ..models.base import Fault, FoundProblem


class Refusal(Exception):
    """Raised when a request cannot be carried out, before anything is done."""

    def __init__(
        self, status: int, code: str, message: str, hint: str = "",
        problems: list[FoundProblem] | None = None, details: dict[str, Any] | None = None,
    ) -> None:  # fmt: skip
        super().__init__(message)
        self.status = status
        self.fault = Fault(
            code=code, message=message, hint=hint, problems=problems or [], details=details or {}
        )


class Refused(Refusal):
    """A refusal whose fault was made elsewhere, or has more fields than usual."""

    def __init__(self, status: int, fault: Fault) -> None:
        super().__init__(status, fault.code, fault.message, fault.hint)
        self.fault = fault


def not_found(what: str, name: str, hint: str = "") -> Refusal:
    """`there is no run 'x' here`."""
    return Refusal(404, "NOT_FOUND", f"there is no {what} {name!r} here", hint)


def not_installed(fault: ImportError) -> Refusal | None:
    """A library of an extra that is missing, with the line that adds it; None for other faults."""
    why = extras.not_installed(fault)
    return None if why is None else Refusal(501, "NOT_INSTALLED", why, "then start it again")


def as_response(fault: Exception) -> Response:
    """Any refusal as the JSON that the page expects; other exceptions are raised again."""
    if isinstance(fault, ImportError):
        fault = not_installed(fault) or fault
    if isinstance(fault, Refusal):
        return JSONResponse(fault.fault.model_dump(), fault.status)
    if isinstance(fault, ClientDisconnect):
        gone = Fault(code="GONE", message="the request was interrupted, and nothing was done")
        return JSONResponse(gone.model_dump(), 400)
    if isinstance(fault, RequestValidationError):
        said = [f"{_place(e['loc'])}: {e['msg']}" for e in fault.errors()[:5]]
        told = Fault(code="INVALID", message="; ".join(said) or "the request is not valid")
        return JSONResponse(told.model_dump(), 422)
    if isinstance(fault, HTTPException):
        codes = {404: "NOT_FOUND", 405: "NO_SUCH_METHOD"}
        told = Fault(code=codes.get(fault.status_code, "REFUSED"), message=str(fault.detail))
        return JSONResponse(told.model_dump(), fault.status_code, fault.headers)
    raise fault


async def answer(request: Request, fault: Exception) -> Response:
    """The exception handler of the whole API."""
    return as_response(fault)


def _place(location: tuple[Any, ...]) -> str:
    return ".".join(str(part) for part in location if part != "body") or "body"
