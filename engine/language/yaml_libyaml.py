"""Read YAML with libyaml's parser in C, a hundred times as fast as ruamel.yaml's in Python.

It is tried first, and used wherever it reads text as ruamel.yaml does. Anything it rejects, or is
known to read differently, raises Unlike: then ruamel.yaml reads the text and also supplies the
error messages. A test compares the two.
"""

import re
from typing import Any

from .yaml_node import Node, YamlFault
from .yaml_tree import Composer

FOREIGN = re.compile("[\ufeff\x85\u2028\u2029]")
"""Line ends in YAML 1.1 only, and a mark that libyaml does not count."""
TAB = re.compile(r"(?:\A|(?<=[\r\n]))(?![^\"'\t\r\n]*(?<![^ \r\n])#)[^\t\r\n]*\t")
"""A tab outside a comment."""
NAME = re.compile(r"[&*][A-Za-z0-9_-]+(?=[ \t\r\n,\[\]{}]|\Z)")
"""An anchor or alias that ends at the same place in both parsers."""
HASH = re.compile(r"[|>][-+0-9]*#")
SPACES = re.compile(r"[|>][^\r\n]*(?:\r\n?|\n)[ \r\n]*? [\r\n]")
"""A block scalar whose first lines are of spaces only."""


class Unlike(Exception):
    """Not a fault: ruamel.yaml may read the text differently."""


def read_by_libyaml(text: str) -> tuple[Node | None, list[YamlFault], bool]:
    """The root, the non-fatal faults, and whether the end was reached."""
    # Not at the top: a JSON file, or a start without a file, does not need it.
    import yaml

    if not yaml.__with_libyaml__ or _odd(text):
        raise Unlike
    composer = Wary(text)
    try:
        composer.read(yaml.CSafeLoader(text))
    except YamlFault as fault:
        # Too large or too deep is the same in both parsers; reading it again would waste time.
        if fault.code != "E108":
            raise Unlike from fault
        return None, [*composer.faults, fault], False
    except (yaml.YAMLError, UnicodeError) as fault:
        raise Unlike from fault
    return composer.root, composer.faults, True


def _odd(text: str) -> bool:
    """True where the whole text contains something that the two parsers read differently."""
    if not text.isascii() and FOREIGN.search(text):
        return True
    if "\t" in text and TAB.search(text):
        return True
    ends = text.count("\n...") + text.count("\r...")
    return ends > 1 or text.startswith("...")


class Wary(Composer):
    """A composer that stops at everything that libyaml and ruamel.yaml read differently."""

    def read(self, loader: Any) -> None:
        """All events of a text."""
        try:
            for event in iter(loader.get_event, None):
                self.take(event)
        finally:
            loader.dispose()
        if any(fault.code == "E103" for fault in self.faults):
            raise Unlike  # `[{a: b}:c]` is a key that is a mapping only for libyaml
        self.ended()
        root = self.root
        if root is not None and not root.plain and self.text[root.start] in "|>":
            raise Unlike  # without indentation, libyaml reads `#` as a comment

    def _document(self, event: Any, start: int) -> None:
        if event.tags or event.version is not None:
            raise Unlike
        super()._document(event, start)

    def _open(self, event: Any, kind: str, start: int, end: int) -> None:
        if event.tag is not None or (event.anchor and not NAME.match(self.text, start)):
            raise Unlike
        if event.flow_style and not event.anchor and self.text[start] not in "{[":
            raise Unlike  # a pair in a list, `['a':b]`, `[? a]`
        super()._open(event, kind, start, end)

    def _scalar(self, event: Any, start: int, end: int) -> Node:
        if event.tag is not None or (event.anchor and not NAME.match(self.text, start)):
            raise Unlike
        style = event.style
        if (style == "|" or style == ">") and self._odd_block(event, start, end):
            raise Unlike
        if start == end and self.stack and self.stack[-1].awaits_key:
            raise Unlike  # the place of an empty key
        return super()._scalar(event, start, end)

    def _odd_block(self, event: Any, start: int, end: int) -> bool:
        begin = max(self.text.find(event.style, start, end), start)
        return bool(HASH.match(self.text, begin) or SPACES.match(self.text, begin))

    def _alias(self, anchor: str, start: int, end: int) -> None:
        if not NAME.match(self.text, start):
            raise Unlike
        super()._alias(anchor, start, end)
