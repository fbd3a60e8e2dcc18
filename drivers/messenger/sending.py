"""Send a message by Apprise: mail, Slack, Teams, ntfy, webhooks.

An address is as Apprise has it, or `$NAME` for one that is in the environment; `{FILE}` in it stands for the
first line of a file, such as a password.
"""

import asyncio
import os
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from urllib.parse import quote

from ...system.extras import not_installed

AGAIN_S = (0.0, 5.0, 30.0)
"""Before each try."""


async def deliver(
    addresses: Sequence[str], title: str, text: str, picture: Path | None = None, *,
    again_s: Iterable[float] = AGAIN_S,
) -> dict[str, str]:  # fmt: skip
    """Tell each address, patiently; those that did not take it, and why."""
    refused: dict[str, str] = dict.fromkeys(addresses, "")
    for wait_s in again_s:
        await asyncio.sleep(wait_s)
        try:
            refused = await asyncio.to_thread(_apprise, list(refused), title, text, picture)
        except ImportError as fault:
            return dict.fromkeys(refused, not_installed(fault) or str(fault))
        if not refused:
            break
    return refused


def reasons(refused: dict[str, str]) -> str:
    """Why it did not get through, each reason once; nothing if it did."""
    return "; ".join(dict.fromkeys(refused.values()))


def _apprise(
    addresses: Sequence[str], title: str, text: str, picture: Path | None
) -> dict[str, str]:
    """Send to each address; those that did not take it, and why."""
    import apprise  # pyright: ignore[reportMissingImports]

    attach = str(picture) if picture is not None and picture.is_file() else None
    refused: dict[str, str] = {}
    for said in addresses:
        sender, kind = apprise.Apprise(), said.partition(":")[0]
        with apprise.LogCapture(level=apprise.logging.WARNING, fmt="%(message)s") as log:
            try:
                if not sender.add(_address(said)):
                    refused[said] = (
                        f"{kind!r} is not an address that Apprise knows; a webhook's begins with jsons://"
                    )
                elif not sender.notify(body=text, title=title, attach=attach):
                    words = str(log.getvalue()).strip().splitlines()  # pyright: ignore
                    refused[said] = f"{kind}: {words[-1] if words else 'it took no message'}"
            except Exception as fault:  # of any of a hundred services
                refused[said] = f"{kind}: {type(fault).__name__}: {fault}"
    return refused


def _address(said: str) -> str:
    """An address with what it takes from the environment and from files."""
    if said.startswith("$"):
        return os.environ.get(said[1:], "")

    def first_line(found: "re.Match[str]") -> str:
        lines = Path(found[1]).expanduser().read_text(encoding="utf-8").splitlines()
        return quote(lines[0].strip() if lines else "", safe="")

    return re.sub(r"\{([^{}]+)\}", first_line, said)
