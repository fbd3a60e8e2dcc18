"""Read text as nodes: as JSON, as YAML with libyaml, or as YAML with ruamel.yaml, which decides."""

from typing import Any

from ...system.start import collector_at_rest
from .yaml_libyaml import Unlike, read_by_libyaml
from .yaml_lines import Lines
from .yaml_node import Node, YamlFault
from .yaml_tree import Composer

Reading = tuple[Node | None, list[YamlFault], bool]
"""The root, the faults, and whether the whole text was read."""


def read_nodes(text: str, lines: Lines, *, json: bool) -> Reading:
    """The nodes of a text; `json`: it must be JSON, so that faults are those of JSON."""
    with collector_at_rest():
        return _read(text, lines, json)


def _read(text: str, lines: Lines, json: bool) -> Reading:
    if json or text.lstrip()[:1] in ("{", "["):
        from .json_tree import JsonReader  # not at the top: most files are YAML, and without faults

        reader = JsonReader(text)
        try:
            return reader.read(), reader.faults, True
        except YamlFault as fault:
            if json or fault.code == "E108":
                return None, [*reader.faults, fault], False
    try:
        return read_by_libyaml(text)
    except Unlike:
        return read_by_ruamel(text, lines)


def read_by_ruamel(text: str, lines: Lines) -> Reading:
    """Read any YAML, with a place for each fault."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    composer = Composer(text)
    try:
        for event in YAML(typ="safe", pure=True).parse(text):
            composer.take(event)
        composer.ended()
    except YamlFault as fault:
        return None, [*composer.faults, fault], False
    except (YAMLError, ValueError, IndexError, AttributeError, TypeError, AssertionError) as fault:
        # ruamel's scanner raises bare ValueErrors and worse for odd escapes and directives.
        return None, [*composer.faults, *_unless_told(fault, composer.faults, lines)], False
    return composer.root, composer.faults, True


def _unless_told(fault: Any, told: list[YamlFault], lines: Lines) -> list[YamlFault]:
    """The parser's fault, unless it follows from a `{{ x }} mm` that is already reported."""
    from .yaml_words import in_words

    found = in_words(fault, lines)
    line = lines.place(found.start)[0]
    braces = (other for other in told if other.code == "E109")
    return [] if any(lines.place(other.start)[0] == line for other in braces) else [found]
