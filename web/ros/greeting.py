"""What the person who starts it is told: who cannot be reached, and what clients may now set going."""

from collections.abc import Iterator

from .site import Site


def greeting(site: Site) -> Iterator[str]:
    """Lines for the terminal, behind the one that says where it is."""
    for device in site.devices.values():
        if not device.online:
            yield f"{device.name} cannot be reached yet: {device.reason}"
    dangers = _dangers(site)
    if dangers:
        yield f"armed for every client, nobody is asked again: {', '.join(dangers)}"
    yield f"{len(site.offers.actions)} actions; Ctrl-C ends it and leaves the devices safe"


def _dangers(site: Site) -> list[str]:
    found = []
    for device in site.devices.values():
        actions = device.contract.actions.values()
        kinds = dict.fromkeys(action.danger for action in actions if action.danger is not None)
        if kinds:
            found.append(f"{device.name} ({', '.join(kinds)})")
    return found
