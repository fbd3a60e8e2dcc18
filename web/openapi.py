"""Write `web/openapi.json`, from which the page's types are made: `python -m labrun.web.openapi`."""

import json
from pathlib import Path

from .app import make_app

FILE = Path(__file__).parent / "openapi.json"


def openapi_text() -> str:
    """The description as it stands in the file; the server's version is left open."""
    told = make_app(None).openapi()
    told["info"]["version"] = "1"
    return json.dumps(told, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


def main() -> None:
    """Write it."""
    FILE.write_text(openapi_text(), encoding="utf-8")


if __name__ == "__main__":
    main()
