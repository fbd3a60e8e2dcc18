"""The manual as a folder: every page has its place, and every link leads somewhere."""

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [path for path in (ROOT / "docs").rglob("*.md") if "node_modules" not in path.parts]
SOURCES = sorted(
    [
        *ROOT.glob("*.md"),
        *(path for path in PAGES if path.name != "problems.md"),
    ]
)
CONFIG = (ROOT / "mkdocs.yml").read_text("utf-8")
FENCED = re.compile(r"^( *)(```|~~~).*?^\1\2\s*$", re.S | re.M)


@pytest.fixture
def site():
    """`docs/site/build.py`, a script, as a module."""
    spec = importlib.util.spec_from_file_location("build", ROOT / "docs" / "site" / "build.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def anchors(path):
    """Where a page can be entered, as code hosts and the manual name it."""
    heads = re.findall(r"^#+ +(.*)$", FENCED.sub("", path.read_text("utf-8")), re.M)
    plain = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", head).lower() for head in heads)
    return {re.sub(r"[^\w\- ]", "", head).strip().replace(" ", "-") for head in plain}


@pytest.mark.parametrize("page", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_link_of_a_page_leads_to_a_file_and_a_heading(page):
    dead = []
    for place, anchor in re.findall(
        r"\]\((?!\w+:)([^)#\s]*)(?:#([^)\s]+))?\)", FENCED.sub("", page.read_text("utf-8"))
    ):
        target = page.parent / place if place else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            dead.append(f"{place}#{anchor}")

    assert dead == []


def test_every_page_stands_in_the_navigation_and_decisions_in_their_list():
    named = set(re.findall(r"[\w/.-]+\.md", CONFIG.partition("\nnav:")[2]))
    pages = {path.relative_to(ROOT) for path in PAGES}
    wanted = {path.as_posix() for path in pages if not path.name[:4].isdigit()}
    wanted |= {
        f"docs/notebooks/{path.stem}.md" for path in (ROOT / "docs" / "notebooks").glob("*.ipynb")
    }
    listed = (ROOT / "docs" / "decisions" / "README.md").read_text("utf-8")

    assert wanted <= named
    assert [
        path.name for path in pages if path.name[:4].isdigit() and path.name not in listed
    ] == []


def test_links_to_code_become_its_name_and_files_that_are_linked_come_along(site, tmp_path):
    root, folder = tmp_path / "root", tmp_path / "staged"
    (root / "docs").mkdir(parents=True)
    (root / "scan.yaml").write_text("labrun: 1\n")
    (root / "run.py").write_text("")
    (root / "docs" / "first.ipynb").write_text(
        '{"cells": [{"cell_type": "markdown", "source": ["# First"]},'
        ' {"cell_type": "code", "source": ["1 + 1"]}]}'
    )
    (root / "docs" / "page.md").write_text(
        "[run](../run.py) [scan](../scan.yaml) [first](first.ipynb) [gone](gone.md)"
    )
    site.stage(root, folder)

    assert (folder / "docs" / "page.md").read_text() == (
        "run [scan](../scan.yaml) [first](first.md) [gone](gone.md)"
    )
    assert (folder / "docs" / "first.md").read_text() == "# First\n\n```python\n1 + 1\n```"
    assert (folder / "scan.yaml").exists()


def test_what_does_not_hold_is_told_in_sentences(site, tmp_path):
    (tmp_path / "a.html").write_text(
        '<h1 id="top"></h1><a href="b.html#top"></a><a href="#top"></a><a href="https://x.org"></a>'
        '<a href="gone.html"></a><a href="b.html#nowhere"></a><script src="https://x.org/a.js"></script>'
    )
    (tmp_path / "b.html").write_text('<h1 id="top"></h1><img src="a.html">')

    assert list(site.faults(tmp_path)) == [
        "a.html: b.html#nowhere has no such place",
        "a.html: gone.html leads nowhere",
        "a.html: fetches https://x.org/a.js",
    ]


def test_where_mkdocs_is_missing_the_line_that_adds_it_is_told(site, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(site, "find_spec", lambda name: None)

    assert site.main([str(tmp_path / "site")]) == 1
    assert '[docs]"' in capsys.readouterr().err
