"""The built page and the built manual in this installation, or why one is not here."""

from pathlib import Path

FOLDER = Path(__file__).parents[1] / "web" / "app-dist"
HOW = (
    "install labrun again from its sources with a connection to the npm registry, or from a wheel; "
    "in a checkout, `npm ci && npm run build` in the folder web"
)
"""`setup.py` builds the page, `docs/site/build.py` the manual."""
DOCS = FOLDER.with_name("docs-dist")
HOW_DOCS = (
    "wheels of a release have it; in a checkout, `pip install '.[docs]'` and "
    "`python docs/site/build.py` bring it, or read the folder docs as it is"
)


def why_no_page(folder: Path = FOLDER) -> str | None:
    """Why the page could not be built, "" where nobody tried; None where it is built."""
    if (folder / "index.html").is_file():
        return None
    kept = folder / "not-built.txt"
    return kept.read_text("utf-8").strip() if kept.is_file() else ""
