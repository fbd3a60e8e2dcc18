"""The built page as files: compressed if the browser accepts it, and one page for every address."""

from collections.abc import MutableMapping
from html import escape
from pathlib import Path
from typing import Any

from fastapi.responses import FileResponse, HTMLResponse, Response

from ...system.page import HOW, why_no_page
from ..report.files import FORMATS

PACKED = (("br", ".br"), ("gzip", ".gz"))
KINDS = FORMATS | {
    ".js": "text/javascript", ".mjs": "text/javascript", ".css": "text/css",
    ".woff2": "font/woff2", ".ico": "image/x-icon", ".webmanifest": "application/manifest+json",
    ".map": "application/json", ".webp": "image/webp", ".wasm": "application/wasm",
}  # fmt: skip
NOT_BUILT = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>labrun</title></head>
<body><main><h1>The page is not built</h1>
<p>The server is running, and its API answers under <code>/api/v1</code>. {why}</p>
<p>To bring the page, {how}. Then reload this page.</p></main></body></html>
"""


class Pages:
    """Serves a folder; an address that is not a file is left to the page."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    async def __call__(self, scope: MutableMapping[str, Any], receive: Any, send: Any) -> None:
        """One request."""
        response = self._answer(scope)
        await response(scope, receive, send)

    def _answer(self, scope: MutableMapping[str, Any]) -> Response:
        if scope["method"] not in ("GET", "HEAD"):
            return Response(status_code=405, headers={"Allow": "GET, HEAD"})
        path = self._file(str(scope["path"]).lstrip("/"))
        if path is None:
            index = self._folder / "index.html"
            if not index.is_file():
                return HTMLResponse(
                    NOT_BUILT.format(why=escape(why_no_page(self._folder) or ""), how=escape(HOW)),
                    503, headers={"Cache-Control": "no-store"},
                )  # fmt: skip
            if _is_a_file(str(scope["path"])):
                return Response("no such file", 404, media_type="text/plain")
            path = index
        return self._packed(path, _accepted(scope))

    def _file(self, name: str) -> Path | None:
        try:
            path = (self._folder / name).resolve()
            inside = path.is_relative_to(self._folder.resolve())
            return path if name and inside and path.is_file() else None
        except (OSError, ValueError):  # too long for a name, or not a name
            return None

    def _packed(self, path: Path, accepted: set[str]) -> Response:
        kind = KINDS.get(path.suffix.lower(), "application/octet-stream")
        if kind == "text/html" or kind.startswith("text/javascript"):
            kind += "; charset=utf-8"
        headers = {"Cache-Control": _cache(path, self._folder), "Vary": "Accept-Encoding"}
        for name, suffix in PACKED:
            packed = path.with_name(path.name + suffix)
            if name in accepted and packed.is_file():
                headers["Content-Encoding"] = name
                return FileResponse(packed, media_type=kind, headers=headers)
        return FileResponse(path, media_type=kind, headers=headers)


def _is_a_file(address: str) -> bool:
    """True for a file that a page would load; `/protocols/scan.yaml` is an address in the page."""
    first, _, rest = address.strip("/").partition("/")
    return first == "assets" if rest else "." in first


def _cache(path: Path, folder: Path) -> str:
    """Files under `assets/` have their hash in their names, and so never change."""
    if path.is_relative_to((folder / "assets").resolve()):
        return "public, max-age=31536000, immutable"
    return "no-cache"


def _accepted(scope: MutableMapping[str, Any]) -> set[str]:
    told = dict(scope["headers"]).get(b"accept-encoding", b"").decode("latin-1")
    parts = (part.strip().partition(";") for part in told.split(","))
    refused = ("q=0", "q=0.0", "q=0.00", "q=0.000")
    return {name for name, _, weight in parts if weight.replace(" ", "") not in refused}
