"""Protocols: list, read, save, versions, new, trash."""

from typing import Annotated

from fastapi import APIRouter, Path, Query

from ..library.tables import bring_table, tables_beside
from ..models import protocols as models
from .state import TheSite

router = APIRouter(tags=["protocols"])
Name = Annotated[
    str, Path(max_length=300, description="File name, also in a folder: `sub/scan.yaml`.")
]


@router.get("/protocols")
async def list_protocols(app_state: TheSite) -> list[models.ProtocolSummary]:
    """All protocols of the folder, with the results of their runs."""
    return await app_state.overview.every()


@router.post("/protocols", status_code=201)
async def new_protocol(asked: models.NewProtocol, app_state: TheSite) -> models.ProtocolText:
    """A new file; 409 if the name exists."""
    return await app_state.new_protocols.make(asked)


@router.get("/templates")
async def list_templates(app_state: TheSite) -> list[models.Template]:
    """The templates for a new protocol."""
    return app_state.new_protocols.templates()


@router.get("/tables")
def tables_beside_protocol(
    protocol: Annotated[str, Query(max_length=300)], app_state: TheSite
) -> list[models.CsvTable]:
    """The CSV files in the folder of a protocol."""
    return tables_beside(app_state.library.folder, protocol)


@router.post("/tables", status_code=201)
def new_table(asked: models.NewCsvTable, app_state: TheSite) -> models.CsvTable:
    """Put a CSV file beside a protocol; under another name if that one holds something else."""
    return bring_table(app_state.library.folder, asked)


@router.get("/trash")
async def list_trash(app_state: TheSite) -> list[models.Thrown]:
    """Deleted protocols."""
    return app_state.library.trash()


@router.post("/trash/{id}/restore")
async def restore_protocol(id: str, app_state: TheSite) -> models.ProtocolText:
    """Restore one; 409 if its name is in use by now."""
    return app_state.library.restore(id)


@router.get("/protocols/{name:path}/versions")
async def list_versions(name: Name, app_state: TheSite) -> list[models.Version]:
    """The present text and the earlier ones, newest first."""
    return app_state.library.versions(name)


@router.get("/protocols/{name:path}/versions/{revision}")
async def read_version(name: Name, revision: str, app_state: TheSite) -> models.ProtocolText:
    """An earlier text."""
    return app_state.library.version(name, revision)


@router.get("/protocols/{name:path}")
async def read_protocol(name: Name, app_state: TheSite) -> models.ProtocolText:
    """A protocol's text with its revision."""
    return app_state.library.read(name)


@router.put("/protocols/{name:path}", responses={409: {"model": models.SaveConflict}})
async def save_protocol(
    name: Name, asked: models.SaveProtocol, app_state: TheSite
) -> models.SavedProtocol:
    """Save over the revision that was read; 409 with both texts if the file has another one."""
    saved = app_state.library.save(name, asked.text, asked.base)
    app_state.overview.forget(name)
    return saved


@router.delete("/protocols/{name:path}")
async def throw_away_protocol(name: Name, app_state: TheSite) -> models.Thrown:
    """Move it to the trash."""
    return app_state.library.throw_away(name)
