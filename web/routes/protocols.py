"""Protocols: list, read, save, versions, new, trash."""

from typing import Annotated

from fastapi import APIRouter, Path

from ..models.protocols import (
    NewProtocol,
    ProtocolSummary,
    ProtocolText,
    SaveConflict,
    SavedProtocol,
    SaveProtocol,
    Template,
    Thrown,
    Version,
)
from .site import TheSite

router = APIRouter(tags=["protocols"])
Name = Annotated[
    str, Path(max_length=300, description="File name, also in a folder: `sub/scan.yaml`.")
]


@router.get("/protocols")
async def list_protocols(site: TheSite) -> list[ProtocolSummary]:
    """All protocols of the folder, with what is known of their runs."""
    return await site.overview.every()


@router.post("/protocols", status_code=201)
async def new_protocol(asked: NewProtocol, site: TheSite) -> ProtocolText:
    """A new file; 409 where one of that name is there."""
    return await site.making.make(asked)


@router.get("/templates")
async def list_templates(site: TheSite) -> list[Template]:
    """What a new protocol can begin with."""
    return site.making.templates()


@router.get("/trash")
async def list_trash(site: TheSite) -> list[Thrown]:
    """Protocols that were thrown away."""
    return site.shelf.trash()


@router.post("/trash/{id}/restore")
async def restore_protocol(id: str, site: TheSite) -> ProtocolText:
    """Take one back; 409 where its name is taken by now."""
    return site.shelf.restore(id)


@router.get("/protocols/{name:path}/versions")
async def list_versions(name: Name, site: TheSite) -> list[Version]:
    """The present text and the earlier ones, newest first."""
    return site.shelf.versions(name)


@router.get("/protocols/{name:path}/versions/{revision}")
async def read_version(name: Name, revision: str, site: TheSite) -> ProtocolText:
    """An earlier text."""
    return site.shelf.version(name, revision)


@router.get("/protocols/{name:path}")
async def read_protocol(name: Name, site: TheSite) -> ProtocolText:
    """A protocol's text with its revision."""
    return site.shelf.read(name)


@router.put("/protocols/{name:path}", responses={409: {"model": SaveConflict}})
async def save_protocol(name: Name, asked: SaveProtocol, site: TheSite) -> SavedProtocol:
    """Save over the revision that was read; 409 with both texts where another is there."""
    saved = site.shelf.save(name, asked.text, asked.base)
    site.overview.forget(name)
    return saved


@router.delete("/protocols/{name:path}")
async def throw_away_protocol(name: Name, site: TheSite) -> Thrown:
    """Into the trash."""
    return site.shelf.throw_away(name)
