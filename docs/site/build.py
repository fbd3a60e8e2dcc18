"""Build the manual: README, docs/ and the files that they link to, as one folder that opens without a server.

    python docs/site/build.py [FOLDER]

needs `pip install ".[docs]"` and takes some seconds; without FOLDER it writes `web/docs-dist`, which
a wheel built afterwards contains and `labrun docs` opens. The pages keep their places, so that the
same links hold here and on a code host. A dead link or anchor, a page that is not in `mkdocs.yml`,
or anything that a browser would fetch from elsewhere ends it with status 1.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from html.parser import HTMLParser
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).resolve().parents[2]
TARGET = ROOT / "web" / "docs-dist"
AT_THE_ROOT = (
    "README.md",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "LICENSE",
    "SECURITY.md",
    "STYLE.md",
)
LEFT_OUT = {"node_modules", "site"}
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\((?!\w+:|#)([^)#\s]+)(#[^)\s]*)?\)")
LOADED_LATER = re.compile(r"\.(css|js)\.map$|/lunr/|search_index\.json$|sitemap\.xml")
"""What the builder adds and no page needs: maps of its sources, other languages, a second index."""
SHIM = "assets/javascripts/file-worker.js"
FROM_ELSEWHERE = "https://unpkg.com/iframe-worker/shim"
FETCHES = {"script": "src", "img": "src", "link": "href", "iframe": "src", "source": "src"}


def stage(root: Path, folder: Path) -> None:
    """Copy the manual's sources and what they link to; links to code become its name."""
    pages = [root / name for name in AT_THE_ROOT]
    docs = root / "docs"
    pages += [p for p in docs.rglob("*") if not LEFT_OUT & {*p.relative_to(docs).parts[:-1]}]
    for path in pages:
        if path.is_file() and path.suffix not in (".py", ".pyc"):
            _copy(path, root, folder)
    for path in sorted(folder.rglob("*.ipynb")):
        path.with_suffix(".md").write_text(_notebook(path), encoding="utf-8")
        path.unlink()
    for path in sorted(folder.rglob("*.md")):
        text = LINK.sub(
            lambda link, at=path: _link(link, at, root, folder), path.read_text("utf-8")
        )
        path.write_text(text, encoding="utf-8")


def _copy(path: Path, root: Path, folder: Path) -> None:
    target = folder / path.relative_to(root)
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(path, target)


def _link(link: re.Match[str], page: Path, root: Path, folder: Path) -> str:
    picture, text, place, anchor = link.groups()
    target = Path(os.path.normpath(page.parent / unquote(place)))
    if target.suffix == ".ipynb":
        return f"{picture}[{text}]({place.removesuffix('.ipynb')}.md{anchor or ''})"
    source = root / target.relative_to(folder) if target.is_relative_to(folder) else target
    if source.suffix == ".py" or source.is_dir():
        return text
    if source.is_file() and not target.exists():
        _copy(source, root, folder)
    return link.group()


def _notebook(path: Path) -> str:
    """A notebook as Markdown: its texts, and its cells as code."""
    cells = json.loads(path.read_text("utf-8"))["cells"]
    parts = [(cell["cell_type"], "".join(cell["source"])) for cell in cells]
    return "\n\n".join(
        text if kind == "markdown" else f"```python\n{text}\n```" for kind, text in parts
    )


def build(root: Path, folder: Path) -> None:
    """The site in `folder`, which is replaced; raises CalledProcessError where it does not hold."""
    with tempfile.TemporaryDirectory(prefix="labrun-docs-") as work:
        sources, made = Path(work, "sources"), Path(work, "site")
        stage(root, sources)
        text = (root / "mkdocs.yml").read_text("utf-8")
        config = Path(work, "mkdocs.yml")
        config.write_text(f"{text}\ndocs_dir: {sources}\nsite_dir: {made}\n", encoding="utf-8")
        subprocess.run(
            [sys.executable, "-m", "mkdocs", "build", "--strict", "--config-file", str(config)],
            check=True, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}, timeout=300,
        )  # fmt: skip
        shutil.copyfile(Path(__file__).with_name("file-worker.js"), made / SHIM)
        for page in made.rglob("*.html"):
            up = "../" * (len(page.relative_to(made).parts) - 1)
            html = page.read_text("utf-8").replace(FROM_ELSEWHERE, f"{up}{SHIM}")
            page.write_text(html, encoding="utf-8")
        for path in [one for one in made.rglob("*") if one.is_file()]:
            if LOADED_LATER.search(path.as_posix()):
                path.unlink()
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(made, folder)


class Page(HTMLParser):
    """What a page can be entered at, what it leads to, and what a browser fetches for it."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.anchors, self.links, self.fetched = {""}, set[str](), set[str]()
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note its id, and where it points."""
        found = {name: value or "" for name, value in attrs}
        self.anchors |= {found.get("id", ""), found.get("name", "")}
        if tag == "a" and "href" in found:
            self.links.add(found["href"])
        if wanted := found.get(FETCHES.get(tag, "")):
            self.fetched.add(wanted)


def faults(folder: Path) -> Iterator[str]:
    """Dead links and anchors, and what would be fetched from elsewhere, as sentences."""
    pages = {path.resolve(): Page(path) for path in sorted(folder.rglob("*.html"))}
    for path, page in pages.items():
        name = path.relative_to(folder.resolve())
        if name.name == "404.html":  # written for a server's root
            continue
        for link in sorted(page.links | page.fetched):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                if link in page.fetched and parts.scheme != "data":
                    yield f"{name}: fetches {link}"
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            if not target.is_file():
                yield f"{name}: {link} leads nowhere"
            elif target in pages and unquote(parts.fragment) not in pages[target].anchors:
                yield f"{name}: {link} has no such place"


def main(argv: list[str]) -> int:
    """Build, and say what does not hold."""
    folder = Path(argv[0]).resolve() if argv else TARGET
    if any(find_spec(name) is None for name in ("mkdocs", "material")):
        install = f'{sys.executable} -m pip install "{ROOT}[docs]"'
        print(
            f"MkDocs and Material for MkDocs are not installed; add them with: {install}",
            file=sys.stderr,
        )
        return 1
    try:
        build(ROOT, folder)
    except subprocess.CalledProcessError as fault:  # MkDocs has said what does not hold
        print(
            f"MkDocs ended with status {fault.returncode}; {folder} is as it was", file=sys.stderr
        )
        return 1
    found = list(faults(folder))
    for one in found:
        print(one, file=sys.stderr)
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6
    print(
        f"{folder}: {len(list(folder.rglob('*.html')))} pages, {size:.1f} MB, {len(found)} faults"
    )
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
