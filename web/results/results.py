"""Results of runs for the page, each asked for in a thread, from the run's own folder."""

import asyncio
import base64
import re
from collections import OrderedDict
from pathlib import Path
from typing import Any

from fastapi.responses import FileResponse, Response, StreamingResponse

from ...engine.run_files import FileFault, inside
from ...engine.run_folder import LAB
from ..files import FORMATS, is_working, walk
from ..guard.refusal import Refusal, not_found
from ..live.runs import Runs
from ..live.watched import Watched
from ..models.results import (
    MapHead,
    Maps,
    Peaks,
    RunFile,
    Selection,
    Spectra,
    SpectrumHead,
    TableHead,
    TableWindow,
)
from ..workers import Worker, WorkFailed
from .mapping import Plane, plane_of
from .reduced import NAMES, csv_text, places, read_reduced, reduced_names
from .spectra import SUFFIXES, SpectrumShelf
from .tables import Table, read_table, table_names
from .zipped import without_tokens, zipped

PEAKS_S = 60.0
KEPT = 32
CLOSED = (
    "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:; font-src data:"
)
"""What a page out of a run's folder may do: be looked at."""
SAFE_NAME = re.compile(r"[^A-Za-z0-9._-]+")


class Results:
    """Reads what runs have left; `worker` fits peaks."""

    def __init__(self, runs: Runs, worker: Worker) -> None:
        self._runs = runs
        self._worker = worker
        self._spectra = SpectrumShelf()
        self._tables: OrderedDict[tuple[str, str, int, int], tuple[Table, Plane | None]] = (
            OrderedDict()
        )
        self._fits: OrderedDict[tuple[str, tuple[str, ...]], dict[str, Any]] = OrderedDict()

    # --- files

    async def files(self, id: str) -> list[RunFile]:
        """Everything but working state."""
        folder = self._runs.place(id)
        return await asyncio.to_thread(_files, folder)

    def file(self, id: str, name: str) -> Response:
        """One file, as what it is; never as something that runs."""
        path = self._inside(id, name)
        if not path.is_file() or is_working(name):
            raise not_found("file", name)
        headers = {"Content-Security-Policy": CLOSED, "Cache-Control": "private, no-cache"}
        if path.name == LAB:
            text = without_tokens(path.read_text(encoding="utf-8"))
            return Response(text, media_type="application/yaml", headers=headers)
        kind = FORMATS.get(path.suffix.lower(), "application/octet-stream")
        return FileResponse(path, media_type=kind, headers=headers)

    def zip(self, id: str) -> StreamingResponse:
        """The folder."""
        folder = self._runs.place(id)
        headers = _attached(f"{id}.zip")
        return StreamingResponse(zipped(folder), media_type="application/zip", headers=headers)

    # --- tables and maps

    async def tables(self, id: str) -> list[TableHead]:
        """All tables."""
        return [(await self._table(id, name))[0].head() for name in await self._names(id)]

    async def table(self, id: str, name: str, offset: int, limit: int) -> TableWindow:
        """Some rows of one."""
        return (await self._table(id, name))[0].window(offset, limit)

    async def download(self, id: str, name: str, format: str) -> Response:
        """A table as a file."""
        table, _ = await self._table(id, name)
        stem = name.removesuffix(".csv")
        if format == "parquet":
            data = await asyncio.to_thread(table.parquet)
            headers = _attached(f"{id}_{stem}.parquet")
            return Response(data, media_type="application/vnd.apache.parquet", headers=headers)
        headers = _attached(f"{id}_{stem}.csv")
        if name in NAMES:
            return Response(csv_text(table), media_type="text/csv", headers=headers)
        return FileResponse(self._runs.place(id) / name, media_type="text/csv", headers=headers)

    async def maps(self, id: str) -> Maps:
        """All maps, with the keys of their cells."""
        heads: list[MapHead] = []
        keys: dict[str, list[str | None]] = {}
        for name in await self._names(id):
            _, plane = await self._table(id, name)
            if plane is not None:
                heads += await asyncio.to_thread(lambda p=plane: [p.head(c) for c in p.columns])
                keys[name] = plane.keys
        return Maps(maps=heads, cell_keys=keys)

    async def map(self, id: str, name: str, column: str) -> tuple[MapHead, bytes]:
        """One map, as bytes of Float32."""
        _, plane = await self._table(id, name)
        if plane is None or column not in plane.columns:
            raise not_found("map", f"{name} {column}")
        return plane.head(column), plane.values(column).tobytes()

    async def _names(self, id: str) -> list[str]:
        """The tables that the run collected, then those that its spectra were reduced to."""
        folder = self._runs.place(id)
        return await asyncio.to_thread(lambda: table_names(folder) + reduced_names(folder))

    async def _table(self, id: str, name: str) -> tuple[Table, Plane | None]:
        folder = self._runs.place(id)
        spectra: list[tuple[str, str | None]] = []
        if name in NAMES:
            spectra = [(one.file, one.key) for one in spectra_of(await self._runs.opened(id))]
        return await asyncio.to_thread(self._read_table, folder, name, spectra)

    def _read_table(
        self, folder: Path, name: str, spectra: list[tuple[str, str | None]]
    ) -> tuple[Table, Plane | None]:
        if name not in table_names(folder) + reduced_names(folder):
            raise not_found("table", name, "a run has one for each loop that collects")
        stat = (folder / name).stat()
        key = (str(folder), name, stat.st_size, stat.st_mtime_ns)
        if key not in self._tables:
            if name in NAMES:
                collected = [read_table(folder, one) for one in table_names(folder)]
                table = read_reduced(folder, name, places(spectra, collected))
            else:
                table = read_table(folder, name)
            self._tables[key] = (table, plane_of(table))
            while len(self._tables) > KEPT:
                self._tables.popitem(last=False)
        return self._tables[key]

    # --- spectra

    async def spectra(self, id: str) -> Spectra:
        """Every spectrum that the journal knows of, in the order in which they came."""
        run = await self._runs.opened(id)
        heads = spectra_of(run)
        axis = None
        for head in heads[:1]:
            read = await asyncio.to_thread(self._spectra.read, self._inside(id, head.file))
            axis = self._spectra.told(read.axis)
        return Spectra(spectra=heads, axis=axis)

    async def spectrum(self, id: str, file: str) -> tuple[str, str, bytes]:
        """Tag, axis and counts."""
        read = await asyncio.to_thread(self._spectra.read, self._inside(id, file))
        return read.tag, read.axis, read.counts

    async def axis(self, id: str, axis: str) -> bytes:
        """Wavelengths; those of a run that nobody has looked at are read first."""
        if self._spectra.axis(axis) is None:
            await self.spectra(id)
        found = self._spectra.axis(axis)
        if found is None:
            raise not_found("axis", axis, "get a spectrum first: its answer names its axis")
        return found

    async def mean(self, id: str, asked: Selection) -> tuple[str, bytes, int]:
        """The mean over the selected points."""
        run = await self._runs.opened(id)
        files = chosen(run, asked)
        paths = [self._inside(id, file) for file in files]
        return await asyncio.to_thread(self._spectra.mean, paths)

    async def peaks(self, id: str, file: str, elements: list[str] | None) -> Peaks:
        """Peaks of one spectrum."""
        told = await self._fitted(id, file, elements)
        axis = self._spectra.told(told["axis"])
        return Peaks(
            file=file, axis=axis, peaks=told["peaks"], areas=told["areas"],
            temperature_k=told["temperature_k"], noise=told["noise"],
        )  # fmt: skip

    async def fit(self, id: str, file: str) -> tuple[str, bytes]:
        """Axis; then background, fit and residual."""
        told = await self._fitted(id, file, None)
        return told["axis"], base64.b64decode(told["curves"])

    async def _fitted(self, id: str, file: str, elements: list[str] | None) -> dict[str, Any]:
        path = self._inside(id, file)
        read = await asyncio.to_thread(self._spectra.read, path)
        key = (read.tag, tuple(elements or ()))
        if key not in self._fits:
            try:
                asked = {"path": str(path), "elements": elements or None}
                told = await self._worker.ask("peaks", asked, PEAKS_S)
            except WorkFailed as fault:
                raise Refusal(422, "NO_FIT", f"{file} cannot be fitted: {fault}") from fault
            self._fits[key] = {**told, "axis": read.axis}
            while len(self._fits) > KEPT:
                self._fits.popitem(last=False)
        return self._fits[key]

    def _inside(self, id: str, name: str) -> Path:
        folder = self._runs.place(id)
        try:
            path = inside(folder, name)
        except FileFault as fault:
            raise Refusal(422, "WRONG_NAME", str(fault)) from fault
        if not path.resolve().is_relative_to(folder.resolve()):
            raise Refusal(422, "WRONG_NAME", f"{name!r} is a link that leads out of the run")
        return path


def spectra_of(run: Watched) -> list[SpectrumHead]:
    """The spectrum files of a run with their iterations."""
    heads = []
    for file, (loop, within, key) in list(run.picture.files.items()):
        if not file.lower().endswith(SUFFIXES):
            continue
        table = run.picture.tables.get((loop, within))
        slot = table.slots.get(key) if table is not None else None
        index = table.index[slot] if table is not None and slot is not None else None
        full = f"{within}/{key}" if within else key
        heads.append(SpectrumHead(file=file, loop=loop or None, key=full or None, index=index))
    return heads


def chosen(run: Watched, asked: Selection) -> list[str]:
    """The spectrum files of the selected points."""
    wanted = set(asked.keys)
    return [
        head.file
        for head in spectra_of(run)
        if head.key in wanted and (asked.loop is None or head.loop == asked.loop)
    ]


def _files(folder: Path) -> list[RunFile]:
    return [
        RunFile(name=name, size=(folder / name).stat().st_size, kind=_kind(name))
        for name in walk(folder)
        if not is_working(name)
    ]


def _kind(name: str) -> Any:
    if name.startswith("protocol."):
        return "protocol"
    if name == "journal.jsonl":
        return "journal"
    if re.fullmatch(r"data.*\.csv", name):
        return "table"
    if name.lower().endswith((".png", ".svg", ".pdf")):
        return "figure"
    if name in ("report.html", "ro-crate-metadata.json"):
        return "report"
    return "spectrum" if "/" in name and name.lower().endswith(SUFFIXES) else "other"


def _attached(name: str) -> dict[str, str]:
    return {"Content-Disposition": f'attachment; filename="{SAFE_NAME.sub("_", name)}"'}
