"""Make a new protocol from a template that ships, with a new name and the lab's devices."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.resources import files

from ...schemas.protocol import Protocol
from ...system import NO_FILE
from ..lab.lab import LoadedLab
from ..language.suggest import did_you_mean, listed

TEMPLATES = {
    "grid_scan": "a measurement at every point of a grid",
    "line_scan": "a measurement at every point of a line",
    "single": "one measurement at one place",
    "fill_plate": "a plate of 96 wells filled, every portion weighed",
    "dispense": "volumes dispensed onto a balance and weighed",
    "titrate": "an acid titrated with a base, and its end point",
    "calibrate_camera": "the camera's place beside the tool, from a chessboard",
    "minimal": "the smallest protocol, for any lab",
}
"""Name -> what it does; each is `protocols/templates/NAME.yaml`, or an example that ships."""
EXAMPLES = ("fill_plate", "calibrate_camera")
MODELINE = "# yaml-language-server: $schema=./labrun.schema.json\n"
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.-]*")
LONGEST = 80


class CannotMake(ValueError):
    """An unsuitable name or template; the message says why and suggests another."""


@dataclass(frozen=True, slots=True)
class New:
    """The text of a new protocol, and the roles that must be bound to a device."""

    text: str
    binds: dict[str, str] = field(default_factory=dict)


def protocol_name(name: str) -> str:
    """The name without `.yaml`; raises CannotMake if it is invalid for a protocol or a file."""
    plain = name.removesuffix(".yaml").removesuffix(".yml")
    if "/" in plain or "\\" in plain:
        raise CannotMake(f"{name} is a path; give only a name, and run labrun in that folder")
    if NAME.fullmatch(plain) is None or plain.endswith((".", " ")):
        raise CannotMake(
            f"{name!r} is not a valid protocol name: it must begin with a letter or digit and contain "
            "only letters, digits, spaces, _ . and -"
        )
    if len(plain) > LONGEST:
        raise CannotMake(f"a name of {len(plain)} characters is too long; the limit is {LONGEST}")
    if NO_FILE.search(plain):
        raise CannotMake(f"{name!r} cannot be a file on Windows; choose another name")
    return plain


def template_text(template: str) -> str:
    """The text of a template that ships; raises CannotMake for an unknown one."""
    if template not in TEMPLATES:
        known = "; ".join(f"{name}: {what}" for name, what in TEMPLATES.items())
        raise CannotMake(
            f"there is no template {template!r}{did_you_mean(template, TEMPLATES)} ({known})"
        )
    if template in EXAMPLES:
        example = files("labrun.protocols").joinpath(f"{template}.yaml")
        return MODELINE + example.read_text(encoding="utf-8")
    folder = files("labrun.protocols.templates")
    return folder.joinpath(f"{template}.yaml").read_text(encoding="utf-8")


def new_protocol(name: str, template: str, protocol: Protocol, lab: LoadedLab) -> New:
    """The template under a new name, with the lab's devices in a comment above `devices`.

    `protocol` is the template as read. Raises CannotMake if the lab lacks a device for a role.
    """
    binds = dict(_binds(template, protocol, lab))
    text = re.sub(r"(?m)^name: .*$", f"name: {_scalar(name)}", template_text(template), count=1)
    known = ", ".join(f"{n}:\u00a0{device.contract}" for n, device in lab.lab.devices.items())
    note = "\n".join(_comment(f"The lab {lab.lab.name!r} has {known}."))
    return New(re.sub(r"(?m)^devices:", f"{note}\ndevices:", text, count=1), binds)


def _binds(template: str, protocol: Protocol, lab: LoadedLab) -> Iterator[tuple[str, str]]:
    """The roles that several devices could play, each with the first such device."""
    for role, contract in protocol.devices.items():
        fitting = lab.keeping(contract)
        if not fitting:
            raise CannotMake(
                f"the template {template} needs a {contract} device, but the lab "
                f"{lab.lab.name!r} has {listed(sorted({d.contract for d in lab.lab.devices.values()}))}; "
                "--template minimal fits any lab"
            )
        if role not in fitting and len(fitting) > 1:
            yield role, fitting[0]


def devices_of(protocol: Protocol, lab: LoadedLab, binds: dict[str, str]) -> Iterator[str]:
    """The devices that the roles will have."""
    for role, contract in protocol.devices.items():
        fitting = lab.keeping(contract)
        yield binds.get(role) or (role if role in fitting else fitting[0])


def _scalar(name: str) -> str:
    """A name as YAML: in quotes where it could be read as something else."""
    plain = re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", name) and name.lower() not in (
        "true", "false", "null", "yes", "no", "on", "off", "y", "n",
    )  # fmt: skip
    return name if plain else f'"{name}"'


def _comment(text: str) -> Iterator[str]:
    from textwrap import wrap

    # A device stays beside its contract: textwrap does not break lines at such a space.
    for line in wrap(text, 96, break_long_words=False, break_on_hyphens=False):
        yield "# " + line.replace("\u00a0", " ")
