"""Data as YAML that reads back as itself, in its order: what is written first to a device stays first.

Left to itself, ruamel.yaml writes `:MEAS?` and `? x` without quotes, which nothing reads between braces,
and sorts keys.
"""

from typing import Any, TextIO

SIGNS = (":", "?")
"""A text that begins so and is not quoted is read as a key without a value, or not at all."""


def write_yaml(data: Any, out: TextIO) -> None:
    """Write plain data: mappings, lists, texts, numbers."""
    from ruamel.yaml import YAML
    from ruamel.yaml.representer import SafeRepresenter

    class Quoting(SafeRepresenter):
        def represent_str(self, data: str) -> Any:
            style = '"' if data.startswith(SIGNS) else None
            return self.represent_scalar("tag:yaml.org,2002:str", data, style=style)

    Quoting.add_representer(str, Quoting.represent_str)
    yaml = YAML(typ="safe", pure=True)
    yaml.Representer = Quoting
    yaml.sort_base_mapping_type_on_output = False  # pyright: ignore[reportAttributeAccessIssue]
    yaml.dump(data, out)
