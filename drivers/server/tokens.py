"""The token of a server: given by a person, or made for this user's own programs.

A server that only this machine can reach is open to every user of it, and to every page in a
browser on it. So a server that nobody gave a token makes one, and leaves it in a file that only
the same user can read; a client of that user who has none looks there.
"""

import codecs
import glob
import os
import secrets
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...system.files import remove, write_whole
from .gate import is_loopback, split

LEAST = 16
"""The shortest token that a person may choose, in characters."""
STARTS_WITHIN_S = 600.0
"""A younger file may be of a server that does not listen yet."""
MOST_CLEANED = 50
LISTENS_S = 0.1


class WeakToken(ValueError):
    """A token that cannot be used, with the reason."""


def chosen(token: str | None, file: Path | None, variable: str, host: str) -> str | None:
    """The token that a person gave: as a file, in a variable of the environment, or directly.

    Raises WeakToken; also without one, where other machines can reach the host that is listened on.
    """
    if file is not None:
        try:
            data = file.read_bytes()
            # PowerShell and Notepad put a mark in front.
            wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
            token = data.decode("utf-16" if wide else "utf-8-sig").strip()
        except (OSError, UnicodeDecodeError) as fault:
            raise WeakToken(f"--token-file {file}: {fault}") from fault
    token = token if token is not None else os.environ.get(variable)
    if token is not None and len(token) < LEAST:
        raise WeakToken(
            f"a token of {len(token)} characters is easily guessed; use {LEAST} or more"
        )
    if token is None and not is_loopback(host):
        raise WeakToken(
            f"--host {host}: other machines can reach this address, so a token is required; "
            "give --token-file, or serve on 127.0.0.1"
        )
    return token


@contextmanager
def findable(url: str, token: str) -> Iterator[None]:
    """Leave the token where this user's programs find it, for as long as the block lasts; raises OSError."""
    path = _path(url)
    _clean(path.parent)
    write_whole(path, token.encode(), mode=0o600, sync=False)
    try:
        yield
    finally:
        if _read(path) == token:
            remove(path)


def for_port(
    token: str | None, file: Path | None, variable: str, host: str, *, open_to_all: bool
) -> tuple[str | None, bool]:
    """The token of a port, and whether it was made here because nobody had given one.

    `open_to_all` is the person's word that this machine's other users may come in, too. Raises
    WeakToken.
    """
    given = chosen(token, file, variable, host)
    if given is not None and open_to_all:
        raise WeakToken(
            f"--no-token, and a token (from --token, --token-file or {variable}): give one of the two"
        )
    needs = given is None and not open_to_all
    return (made(), True) if needs else (given, False)


def made() -> str:
    """A new token."""
    return secrets.token_urlsafe(24)


def with_token(url: str, token: str) -> str:
    """The address of a page or of a ROS endpoint that lets its reader in."""
    return f"{url}/?token={token}"


def found(url: str) -> str | None:
    """The token that a server of this user, on this machine, has made for this address."""
    return _read(_path(url)) if is_loopback(split(url).hostname or "") else None


def _path(url: str) -> Path:
    from platformdirs import user_state_path

    # Homes are shared between machines: a port alone would not tell them apart.
    place = f"{socket.gethostname()}-{split(url).port}"
    return user_state_path("labrun", appauthor=False) / "tokens" / place


def _clean(folder: Path) -> None:
    """Remove what servers of this machine have left that were killed: nobody listens at their ports."""
    before = time.time() - STARTS_WITHIN_S
    left = [
        path
        for path in folder.glob(f"{glob.escape(socket.gethostname())}-*")
        if _older(path, before)
    ]
    for path in left[:MOST_CLEANED]:
        token, port = _read(path), path.name.rpartition("-")[2]
        if port.isdecimal() and not _listens(int(port)) and _read(path) == token:
            remove(path)


def _older(path: Path, moment: float) -> bool:
    try:
        return path.stat().st_mtime < moment
    except OSError:
        return False


def _listens(port: int) -> bool:
    for family, address in ((socket.AF_INET, "127.0.0.1"), (socket.AF_INET6, "::1")):
        with suppress(OSError), socket.socket(family) as asking:
            asking.settimeout(LISTENS_S)
            if asking.connect_ex((address, port)) == 0:
                return True
    return False


def _read(path: Path) -> str | None:
    try:
        return path.read_text(encoding="utf-8") or None
    except OSError:
        return None
