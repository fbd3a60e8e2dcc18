"""The manual of problems: the page of every code, and `docs/reference/problems.md` made from them.

`python -m labrun.engine.problems.manual` writes that file; a test compares it.
"""

import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType

from ...schemas.problem import Problem
from ..check import CHECKS, check_file
from ..lab import bind, lab
from ..language import shape, source
from ..params import params
from ..survey import used
from .page import Example, Page, introduction, pages_in
from .pages import declared, labs, reading, shapes
from .pages import used as uses

WITHOUT_CHECK: tuple[tuple[ModuleType, ModuleType], ...] = (
    (source, reading),
    (shape, shapes),
    (lab, labs),
    (bind, labs),
    (params, declared),
    (used, uses),
)
"""Modules that report problems while a file is read -> where the pages of their codes are."""

REFERENCE = Path(__file__).parents[2] / "docs" / "reference" / "problems.md"
SAMPLE, LAB = "page.yaml", "lab.yaml"
HELLO = "labrun: 1\nname: page\nsteps:\n  - log: hello\n"


@cache
def all_codes() -> dict[str, str]:
    """Code -> title, for every problem."""
    codes = [module.CODES for module, _ in WITHOUT_CHECK] + [family.CODES for family in CHECKS]
    return {code: title for family in codes for code, title in sorted(family.items())}


@cache
def pages() -> dict[str, Page]:
    """Code -> page, in the order of the manual."""
    titles = all_codes()
    return {code: page for module in chapters() for code, page in _pages(module, titles).items()}


def page(code: str) -> Page | None:
    """The page of a code; None for an unknown code."""
    return pages().get(code)


def chapters() -> Iterator[ModuleType]:
    """Modules with pages in their docstrings, each once."""
    yield from dict.fromkeys(place for _, place in WITHOUT_CHECK)
    yield from CHECKS


def _pages(module: ModuleType, titles: dict[str, str]) -> dict[str, Page]:
    return pages_in(module.__doc__, titles)


def said_of(page: Page, example: Example) -> list[Problem]:
    """What the checker reports for an example, checked in a temporary folder."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in page.beside.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        path = Path(folder, SAMPLE)
        path.write_text(HELLO if example.is_lab else example.yaml, encoding="utf-8")
        if example.is_lab:
            Path(folder, LAB).write_text(example.yaml, encoding="utf-8")
        bench = Path(folder, LAB) if example.is_lab or LAB in page.beside else None
        given = {"-p": dict[str, str](), "--bind": dict[str, str]()}
        for option, pair in zip(example.options[::2], example.options[1::2], strict=True):
            name, _, value = pair.partition("=")
            given[option][name] = value
        found = check_file(
            path, lab=bench, bind=given["--bind"], params=given["-p"],
            needed="-p" in example.options,
        ).problems  # fmt: skip
        return [_without(problem, folder) for problem in found]


def _without(problem: Problem, folder: str) -> Problem:
    plain = {
        key: getattr(problem, key).replace(f"{folder}/", "").replace(folder, "its folder")
        for key in ("file", "message", "hint")
    }
    return problem.model_copy(update=plain)


# --- the reference page

TOP = """\
# Problems

Every problem that `labrun check` can find, why it is a problem, and how to fix it.
`labrun problem E204` prints one of these pages. Codes with E are errors: nothing is sent to any
device. Codes with W are warnings: the protocol runs.

<!-- Made by `python -m labrun.engine.problems.manual` from docstrings in engine/checks and in pages/. -->

| code | what it is |
| --- | --- |
"""


def reference_text() -> str:
    """The correct text of `docs/reference/problems.md`."""
    rows = [f"| [{p.code}](#{p.code.lower()}) | {p.title} |" for p in pages().values()]
    parts = [TOP + "\n".join(rows)]
    for chapter in chapters():
        own = _pages(chapter, all_codes())
        first, _, more = introduction(chapter.__doc__).partition("\n\n")
        parts.append("## " + " ".join(first.split()).removesuffix("."))
        parts += [more] if more else []
        parts += [_section(one) for one in own.values()]
    return "\n\n".join(parts) + "\n"


def _section(page: Page) -> str:
    parts = [f"### {page.code}", f"**{page.title[0].upper()}{page.title[1:]}.** {page.why}"]
    for word, example in (("Passes", page.passes), ("Fails", page.fails)):
        parts += [f"{word}{example.how}:", f"```yaml\n{example.yaml}```"]
    for name, text in page.beside.items():
        parts += [f"Beside it, `{name}`:", f"```yaml\n{text}```"]
    lines = [words(problem) for problem in said_of(page, page.fails) if problem.code == page.code]
    return "\n\n".join([*parts, "```text\n" + "\n".join(lines) + "\n```"])


def words(problem: Problem) -> str:
    """A problem as the terminal shows it, without the line that it points at."""
    place = f"{problem.file}:{problem.line}:{problem.column}: "
    place = f"{problem.file}: " if problem.file.startswith("-") else place
    hint = f"\n   = {problem.hint}" if problem.hint else ""
    return f"{place}{problem.severity}[{problem.code}] {problem.message}{hint}"


def main() -> None:
    """Write the reference page."""
    REFERENCE.write_text(reference_text(), encoding="utf-8")


if __name__ == "__main__":
    main()
