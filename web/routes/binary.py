"""Bulk numbers: little-endian Float32, cached by browsers if they cannot change."""

from typing import Any

from fastapi import Request
from fastapi.responses import Response

MEDIA = "application/octet-stream"
BINARY: dict[int | str, dict[str, Any]] = {
    200: {"content": {MEDIA: {"schema": {"type": "string", "format": "binary"}}}}
}


class Float32Response(Response):
    """Little-endian Float32 values, one after the other."""

    media_type = MEDIA


def kept_for_ever(
    request: Request, tag: str, content: bytes, headers: dict[str, str] | None = None
) -> Response:
    """An answer with an ETag from its content's identity; 304 if the browser has it."""
    told = {"ETag": f'"{tag}"', "Cache-Control": "private, no-cache", **(headers or {})}
    if request.headers.get("if-none-match") == f'"{tag}"':
        return Response(status_code=304, headers=told)
    return Float32Response(content, headers=told)
