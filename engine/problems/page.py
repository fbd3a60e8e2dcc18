"""One page of the manual: a code, why it matters, YAML that passes and YAML that fails.

Pages are written in docstrings. A page begins with its code and a full stop, followed by the
reason; `Passes:` and `Fails:` each precede an indented block. `Passes with -p depth=2:` gives
command line options, `Fails as a lab:` means that the block is a lab, and `Beside it, sub.yaml:`
shows another file of the same folder.
"""

import re
from dataclasses import dataclass, field
from inspect import cleandoc

START = re.compile(r"^([EW]\d{3})\. ", re.MULTILINE)
HEADING = re.compile(r"^(Passes|Fails|Beside it)(?:,? (.+?))?:$", re.MULTILINE)
HEADER = "labrun: 1\nname: page\n"


@dataclass(frozen=True, slots=True)
class Example:
    """A protocol, or a lab, as a page shows it; `options` are command line options."""

    yaml: str
    options: tuple[str, ...] = ()
    is_lab: bool = False

    @property
    def how(self) -> str:
        """` with -p depth=2`, ` as a lab`, or nothing."""
        return (
            " as a lab" if self.is_lab else f" with {' '.join(self.options)}" * bool(self.options)
        )


@dataclass(frozen=True, slots=True)
class Page:
    """The page of one code; `beside` holds other files of the examples' folder."""

    code: str
    title: str
    why: str
    passes: Example
    fails: Example
    beside: dict[str, str] = field(default_factory=dict)

    def text(self) -> str:
        """The page for a terminal."""
        parts = [f"{self.code}: {self.title}", self.why]
        for word, example in (("Passes", self.passes), ("Fails", self.fails)):
            parts += [f"{word}{example.how}:", _indented(example.yaml)]
        for name, text in self.beside.items():
            parts += [f"Beside it, {name}:", _indented(text)]
        return "\n\n".join(parts)


def pages_in(document: str | None, titles: dict[str, str]) -> dict[str, Page]:
    """Code -> page, for every page of a docstring; raises ValueError for an incomplete page."""
    text = cleandoc(document or "")
    starts = list(START.finditer(text))
    ends = [*(start.start() for start in starts[1:]), len(text)]
    found = {}
    for start, end in zip(starts, ends, strict=True):
        code = start[1]
        found[code] = _page(code, titles.get(code, ""), text[start.end() : end].strip())
    return found


def introduction(document: str | None) -> str:
    """The text of a docstring before its first page."""
    return START.split(cleandoc(document or ""), maxsplit=1)[0].strip()


def _page(code: str, title: str, text: str) -> Page:
    why, blocks = text, []
    headings = list(HEADING.finditer(text))
    if headings:
        why = text[: headings[0].start()].strip()
    ends = [*(heading.start() for heading in headings[1:]), len(text)]
    for heading, end in zip(headings, ends, strict=True):
        blocks.append((heading[1], heading[2] or "", cleandoc(text[heading.end() : end]) + "\n"))
    examples = {word: _example(how, yaml) for word, how, yaml in blocks if word != "Beside it"}
    if set(examples) != {"Passes", "Fails"} or not why:
        raise ValueError(f"the page of {code} needs a reason, `Passes:` and `Fails:`")
    beside = {how: _complete(yaml) for word, how, yaml in blocks if word == "Beside it"}
    return Page(code, title, why, examples["Passes"], examples["Fails"], beside)


def _example(how: str, yaml: str) -> Example:
    is_lab = how == "as a lab"
    options = () if is_lab else tuple(how.removeprefix("with ").split())
    return Example(yaml if is_lab else _complete(yaml), options, is_lab)


def _complete(yaml: str) -> str:
    """The YAML with the two lines that every protocol begins with, where a page omits them."""
    begun = re.search(r"^(labrun|name):", yaml, re.MULTILINE)
    is_protocol = re.search(r"^steps:", yaml, re.MULTILINE)
    return yaml if begun or not is_protocol else HEADER + yaml


def _indented(text: str) -> str:
    return "\n".join(f"    {line}".rstrip() for line in text.rstrip("\n").split("\n"))
