"""The greeting for the user: which devices are unreachable, and what clients can now start."""

from collections.abc import Iterator

from .offered_lab import OfferedLab


def greeting(offered: OfferedLab) -> Iterator[str]:
    """Lines for the terminal, after the one with the address."""
    for device in offered.devices.values():
        if not device.online:
            yield f"{device.name} cannot be reached yet: {device.reason}"
    dangers = _dangers(offered)
    if dangers:
        yield f"armed for every client, without further confirmation: {', '.join(dangers)}"
    yield f"{len(offered.offers.actions)} actions; Ctrl-C ends it and leaves the devices safe"


def _dangers(offered: OfferedLab) -> list[str]:
    found = []
    for device in offered.devices.values():
        actions = device.contract.actions.values()
        kinds = dict.fromkeys(action.danger for action in actions if action.danger is not None)
        if kinds:
            found.append(f"{device.name} ({', '.join(kinds)})")
    return found
