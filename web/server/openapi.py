"""Write `web/openapi.json`, the source of the page's types: `python -m labrun.web.server.openapi`."""

import json
from pathlib import Path

from .app import make_app

FILE = Path(__file__).parents[1] / "openapi.json"


def openapi_text() -> str:
    """The description as in the file, without the server's version."""
    told = make_app(None).openapi()
    told["info"]["version"] = "1"
    return json.dumps(told, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


def main() -> None:
    """Write it."""
    FILE.write_text(openapi_text(), encoding="utf-8")


if __name__ == "__main__":
    main()
