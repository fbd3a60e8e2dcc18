"""The table of semantics, made from the tests beside this file: one row a test.

A file's docstring is its section: a title, a few sentences, an example. A test's docstring is its row:
`what is the case -> what happens`; the rows of a `table` have it as their second word.
`python tests/engine/semantics/page.py` rewrites the page.
"""

import ast
import re
import textwrap
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
PAGE = HERE.parents[2] / "docs" / "reference" / "semantics.md"
FAMILIES = (
    "sequence", "sets", "any", "foreach", "repeat_while", "if", "use", "rules", "retry", "fallback",
    "once", "timeout", "watch", "background", "overlap",
    "questions", "values", "functions", "clock", "ending", "redo", "change",
)  # fmt: skip
INTRODUCTION = """# What each construct does

For every construct of the language: what succeeds, what fails, what is cancelled, how often and in
which order actions are sent, what later steps see, and what happens after an abort or a crash. Each row
is a test, named beside it, that runs a protocol on the real engine, with real device servers and
scripted devices.

Some terms used throughout:

- A step **fails for good** when its `retry` and its `fallback` have not helped. Then `on_error` decides,
  then the `keep_going` of the loop around it, and finally the run fails. `finally` runs in any case.
- **Null** is the result of a step that did not run, failed, or was cancelled.
- **Abort** is `labrun abort`, Ctrl-C, or a signal from the system. **Killed** means that the engine
  vanished: a power cut, a crash. `labrun resume` continues after both.
- A **`once`** action is one that must not happen twice; its contract says so. All others may be sent again.

<!-- Made by `python tests/engine/semantics/page.py` from the tests in that folder. -->
"""


@dataclass(frozen=True)
class Row:
    """One fact: the case, what happens, and the test that checks it."""

    case: str
    fact: str
    test: str


@dataclass(frozen=True)
class Family:
    """The section of one file of tests."""

    file: str
    title: str
    words: str
    example: str
    rows: list[Row]


def read(path):
    """The section that a file of tests is."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    title, _, rest = ast.get_docstring(tree).partition("\n\n")
    words, example = [], []
    for part in rest.split("\n\n"):
        (example if part.startswith("    ") else words).append(part)
    return Family(
        path.name, title, "\n\n".join(words), textwrap.dedent("\n\n".join(example)),
        [row(*told) for node in tree.body for told in tests(node)],
    )  # fmt: skip


def tests(node):
    """The names and docstrings of the tests that a test function is, or a table."""
    match node:
        case ast.FunctionDef(name=name) if name.startswith("test_"):
            yield name, ast.get_docstring(node) or ""
        case ast.Assign(value=ast.Call(func=ast.Name("table"), args=rows)):
            for one in rows:
                name, docstring, *_ = one.elts
                yield ast.literal_eval(name), ast.literal_eval(docstring)


def row(test, docstring):
    """The row that a test is."""
    case, arrow, fact = re.sub(r"\s+", " ", docstring).partition(" -> ")
    if not (case and arrow and fact):
        raise ValueError(f"{test}: its docstring is not a row, `what is the case -> what happens`")
    return Row(case, fact, test)


def families():
    """All sections, in the order of the page."""
    return [read(HERE / f"test_{name}.py") for name in FAMILIES]


def page():
    """The page as it should be."""
    sections = families()
    links = "\n".join(f"- [{one.title}](#{anchor(one.title)})" for one in sections)
    return "\n".join([INTRODUCTION, links, "", *(section(one) for one in sections)])


def anchor(title):
    """What a heading is linked by."""
    return re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")


def section(family):
    """One construct: words, an example, its table."""
    link = f"../../tests/engine/semantics/{family.file}"
    lines = [
        f"## {family.title}", "", family.words, "", "```yaml", family.example, "```", "",
        "| when | then | test |", "| --- | --- | --- |",
    ]  # fmt: skip
    for one in family.rows:
        cells = (one.case, one.fact, f"[{one.test.removeprefix('test_')}]({link})")
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join([*lines, ""])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
