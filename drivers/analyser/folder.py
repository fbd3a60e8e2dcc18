"""An analyser's export folder: on a disk that both machines can see, or read over HTTP.

Over HTTP, any server that lists a folder as a page of links will do, such as
`python -m http.server 8000 --directory C:/exports` on the analyser's own computer.
"""

import asyncio
import shutil
from html.parser import HTMLParser
from pathlib import Path
from typing import Protocol
from urllib.parse import quote, unquote

ANSWER_S = 10.0
DEPTH = 3


class FolderFault(OSError):
    """A folder that cannot be read; the text says which and why."""


class Folder(Protocol):
    """What an export folder has to offer; paths are relative to it, with `/`."""

    place: str

    async def names(self) -> set[str]:
        """What is in it, files and folders."""
        ...

    async def files(self, name: str) -> dict[str, int]:
        """Path -> bytes of the file of that name, or of all files in the folder of that name."""
        ...

    async def read(self, path: str) -> bytes:
        """The whole content of a file."""
        ...

    async def free_bytes(self) -> int | None:
        """Free space in bytes; None if that is unknown."""
        ...


def folder_at(place: str) -> Folder:
    """A folder by its path or its address (http or https)."""
    return WebFolder(place) if place.startswith(("http://", "https://")) else SharedFolder(place)


async def see_that_it_is_there(word: str, folder: Folder) -> None:
    """Read a folder at the start; raises FolderFault naming its configuration key."""
    try:
        await folder.names()
    except FolderFault as fault:
        raise FolderFault(
            f"config.{word} is {folder.place!r}, which cannot be listed: {fault}; is the analyser's "
            f"disk mounted, and is this its path on this machine?"
        ) from fault


class SharedFolder:
    """A folder on a disk or share of this machine; a read that hangs times out."""

    def __init__(self, place: str) -> None:
        self.place = place
        self._path = Path(place)

    async def names(self) -> set[str]:
        return await self._asked(lambda: {entry.name for entry in self._path.iterdir()})

    async def files(self, name: str) -> dict[str, int]:
        return await self._asked(lambda: dict(self._sizes(self._path / name)))

    def _sizes(self, top: Path) -> list[tuple[str, int]]:
        paths = sorted(top.rglob("*")) if top.is_dir() else [top]
        return [
            (path.relative_to(self._path).as_posix(), path.stat().st_size)
            for path in paths
            if path.is_file()
        ]

    async def read(self, path: str) -> bytes:
        return await self._asked((self._path / path).read_bytes)

    async def free_bytes(self) -> int | None:
        return (await self._asked(lambda: shutil.disk_usage(self._path))).free

    async def _asked(self, question):
        try:
            async with asyncio.timeout(ANSWER_S):
                return await asyncio.to_thread(question)
        except TimeoutError:
            raise FolderFault(f"{self.place} did not respond within {ANSWER_S:g} s") from None
        except FileNotFoundError as fault:
            missing = Path(fault.filename or self.place).absolute()
            raise FolderFault(f"there is no folder or file {missing}") from fault
        except OSError as fault:
            raise FolderFault(f"{self.place} cannot be read: {fault.strerror or fault}") from fault


class WebFolder:
    """A folder that a web server lists as a page of links."""

    def __init__(self, place: str) -> None:
        self.place = place.rstrip("/") + "/"

    async def names(self) -> set[str]:
        return {link.rstrip("/") for link in await self._links("")}

    async def files(self, name: str) -> dict[str, int]:
        links = await self._links("")
        if f"{name}/" in links:
            paths = await self._below(f"{name}/", DEPTH)
        else:
            paths = [name] if name in links else []
        return {path: await self._size(path) for path in paths}

    async def _below(self, folder: str, depth: int) -> list[str]:
        paths = []
        for link in sorted(await self._links(folder)):
            if not link.endswith("/"):
                paths.append(folder + link)
            elif depth:
                paths += await self._below(folder + link, depth - 1)
        return paths

    async def read(self, path: str) -> bytes:
        return (await self._got("GET", path))[0]

    async def free_bytes(self) -> int | None:
        return None

    async def _size(self, path: str) -> int:
        return (await self._got("HEAD", path))[1]

    async def _links(self, folder: str) -> set[str]:
        page = _Links()
        page.feed((await self._got("GET", folder))[0].decode("utf-8", "replace"))
        return page.links

    async def _got(self, method: str, path: str) -> tuple[bytes, int]:
        import aiohttp

        url = self.place + quote(path)
        try:
            async with (
                asyncio.timeout(ANSWER_S),
                aiohttp.ClientSession() as session,
                session.request(method, url) as answer,
            ):
                if answer.status != 200:
                    raise FolderFault(f"{url} answers {answer.status} {answer.reason}")
                length = int(answer.headers.get("Content-Length", -1))
                return await answer.read(), length
        except (aiohttp.ClientError, ValueError) as fault:
            raise FolderFault(f"{url} cannot be read: {fault}") from fault
        except TimeoutError:
            raise FolderFault(f"{url} did not respond within {ANSWER_S:g} s") from None


class _Links(HTMLParser):
    """The links of a listing that lead one level down."""

    def __init__(self) -> None:
        super().__init__()
        self.links: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        link = unquote(dict(attrs).get("href") or "") if tag == "a" else ""
        link = link.removeprefix("./")
        if (
            link.rstrip("/")
            and "/" not in link.rstrip("/")
            and link[0] not in "?#."
            and ":" not in link
        ):
            self.links.add(link)
