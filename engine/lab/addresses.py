"""Devices of a lab that are at one serial port, or at one address of an instrument."""

import os
from collections.abc import Iterator

from ...schemas.lab import Lab, LabDevice
from ...schemas.problem import Problem
from ..language.source import Source

SERIAL = ("grbl", "marlin", "zaber", "balance")
"""Drivers whose `port` is one of this machine, which they open for themselves alone."""
BY_REGISTERS = "modbus"
"""Units behind one gateway, and parts of one controller, have one address by TCP."""


def one_address(lab: Lab, source: Source) -> Iterator[Problem]:
    """What two devices cannot open both, unless both say that they share it."""
    known: dict[str, tuple[str, bool]] = {}
    for name, device in lab.devices.items():
        key, place = _place(device)
        if not place:
            continue
        shared = device.config.get("shared") is True
        first, may = known.setdefault(place, (name, shared))
        if first == name or (shared and may):
            continue
        written = device.config[key]
        message = f"{name} is at {written}, as {first} is"
        if key == "resource" and "resource" in lab.devices[first].config:
            hint = (
                "if both are there, give each `shared: true`; else one address is that of another"
            )
        else:
            hint = "only one of them can have it open: one of the two is another"
        yield source.problem(("devices", name, "config", key), "W131", message, hint)


def _place(device: LabDevice) -> tuple[str, str]:
    """The key in a device's config that says where it is, and that place in one way of writing."""
    key = "port" if device.driver in SERIAL else "resource"
    written = device.config.get(key)
    if device.driver is None or device.driver.startswith("sim_") or not isinstance(written, str):
        return key, ""
    from ...drivers.bridges.resource import read_resource  # not for simulated ones

    try:
        found = read_resource(written)
    except ValueError:  # told where it is read
        return key, ""
    if found.kind in ("tcp", "udp"):
        by_tcp = device.driver != BY_REGISTERS
        return key, f"{found.kind}://{found.host.lower()}:{found.port}" if by_tcp else ""
    return key, os.path.realpath(found.name) if found.name.startswith("/") else found.name.upper()
