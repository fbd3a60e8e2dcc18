"""Merge keys: `<<: *name` gives a mapping the keys of another one that it lacks.

They are not part of YAML 1.2, but people expect them; merged values keep the place where they are
written, so that a problem in one points there.
"""

from .yaml_node import Node, YamlFault

MERGE = "<<"


def merge(node: Node, merges: list[tuple[Node, int]]) -> list[YamlFault]:
    """Add the keys that merge keys name to a mapping; its own keys win, then those merged first."""
    assert node.members is not None and node.keys is not None
    faults = []
    for value, start in merges:
        for source in value.items if value.items is not None else [value]:
            if source.members is None or source.keys is None:
                faults.append(_no_mapping(start))
                continue
            for key in [key for key in source.members if key not in node.members]:
                node.members[key] = source.members[key]
                node.keys[key] = source.keys[key]
                node.value[key] = source.members[key].value
    return faults


def _no_mapping(start: int) -> YamlFault:
    return YamlFault(
        "E104", "`<<` merges the keys of another mapping, but this is not a mapping", start,
        "write `<<: *name`, where `&name` marks a mapping; "
        'quote the key if the text "<<" is meant', 2,
    )  # fmt: skip
