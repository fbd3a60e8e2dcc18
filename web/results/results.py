"""Results of runs for the page, each read in a thread, from the run's own folder."""

import asyncio
import base64
import re
from collections import OrderedDict
from pathlib import Path
from typing import Any

from fastapi.responses import FileResponse, Response, StreamingResponse

from ...engine.run.came_to import SAMPLE
from ...engine.run.folder import LAB
from ...engine.run.names import FileFault, inside
from ..local.refusal import Refusal, not_found
from ..local.workers import Worker, WorkFailed
from ..models import results as models
from ..report.files import FORMATS, is_working, walk
from ..runs.open_run import OpenRun
from ..runs.runs import Runs
from .mapping import Plane, plane_of
from .reduced import NAMES, csv_text, places, read_reduced, reduced_names
from .spectra import SUFFIXES, SpectrumCache
from .tables import Table, read_table, table_names
from .zipped import without_tokens, zipped

PEAKS_S = 60.0
KEPT = 32
CLOSED = (
    "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:; font-src data:"
)
"""The policy for a page from a run's folder: it may only be viewed."""
SAFE_NAME = re.compile(r"[^A-Za-z0-9._-]+")


class Results:
    """Reads the results of runs; `worker` fits peaks."""

    def __init__(self, runs: Runs, worker: Worker) -> None:
        self._runs = runs
        self._worker = worker
        self._spectra = SpectrumCache()
        self._tables: OrderedDict[tuple[str, str, int, int], tuple[Table, Plane | None]] = (
            OrderedDict()
        )
        self._fits: OrderedDict[tuple[str, tuple[str, ...]], dict[str, Any]] = OrderedDict()

    # --- files

    async def files(self, id: str) -> list[models.RunFile]:
        """All files except working state."""
        folder = self._runs.place(id)
        return await asyncio.to_thread(_files, folder)

    def file(self, id: str, name: str) -> Response:
        """One file with its media type; never as something executable."""
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

    async def tables(self, id: str) -> list[models.TableHead]:
        """All tables."""
        return [(await self._table(id, name))[0].head() for name in await self._names(id)]

    async def table(self, id: str, name: str, offset: int, limit: int) -> models.TableWindow:
        """Some rows of one table."""
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

    async def maps(self, id: str) -> models.Maps:
        """All maps, with the keys of their cells."""
        heads: list[models.MapHead] = []
        keys: dict[str, list[str | None]] = {}
        for name in await self._names(id):
            _, plane = await self._table(id, name)
            if plane is not None:
                heads += await asyncio.to_thread(lambda p=plane: [p.head(c) for c in p.columns])
                keys[name] = plane.keys
        return models.Maps(maps=heads, cell_keys=keys)

    async def map(self, id: str, name: str, column: str) -> tuple[models.MapHead, bytes]:
        """One map, as bytes of Float32."""
        _, plane = await self._table(id, name)
        if plane is None or column not in plane.columns:
            raise not_found("map", f"{name} {column}")
        return plane.head(column), plane.values(column).tobytes()

    async def _names(self, id: str) -> list[str]:
        """The tables that the run collected, then those of the reduction of its spectra."""
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
            raise not_found("table", name, "a run has one for each loop that collects rows")
        stat = (folder / name).stat()
        key = (str(folder), name, stat.st_size, stat.st_mtime_ns)
        found = self._tables.get(key)
        if found is None:
            if name in NAMES:
                collected = [read_table(folder, one) for one in table_names(folder)]
                table = read_reduced(folder, name, places(spectra, collected))
            else:
                table = read_table(folder, name)
            found = self._tables[key] = (table, plane_of(table))
            while len(self._tables) > KEPT:
                self._tables.popitem(last=False)
        return found  # another thread may have dropped it from the table meanwhile

    # --- spectra

    async def spectra(self, id: str, sample: str = "") -> models.Spectra:
        """Every spectrum in the journal, in order of arrival; of one sample if its table names any."""
        run = await self._runs.opened(id)
        heads = spectra_of(run)
        if sample:
            heads = await asyncio.to_thread(_of_sample, self._runs.place(id), heads, sample)
        axis = None
        for head in heads[:1]:
            read = await asyncio.to_thread(self._spectra.read, self._inside(id, head.file))
            axis = models.Axis(id=read.axis)
        return models.Spectra(spectra=heads, axis=axis)

    async def spectrum(self, id: str, file: str) -> tuple[str, str, bytes]:
        """Tag, axis and counts."""
        read = await asyncio.to_thread(self._spectra.read, self._inside(id, file))
        return read.tag, read.axis, read.counts

    async def axis(self, id: str, axis: str) -> bytes:
        """Wavelengths; read first if nobody has opened the run yet."""
        if self._spectra.axis(axis) is None:
            await self.spectra(id)
        found = self._spectra.axis(axis)
        if found is None:
            raise not_found("axis", axis, "get a spectrum first: the answer names its axis")
        return found

    async def mean(self, id: str, asked: models.Selection) -> tuple[str, bytes, int]:
        """The mean over the selected points."""
        run = await self._runs.opened(id)
        files = chosen(run, asked)
        paths = [self._inside(id, file) for file in files]
        return await asyncio.to_thread(self._spectra.mean, paths)

    async def peaks(self, id: str, file: str, elements: list[str] | None) -> models.Peaks:
        """Peaks of one spectrum."""
        fitted = await self._fitted(id, file, elements)
        return models.Peaks(
            file=file, axis=models.Axis(id=fitted["axis"]), peaks=fitted["peaks"], areas=fitted["areas"],
            temperature_k=fitted["temperature_k"], noise=fitted["noise"],
        )  # fmt: skip

    async def fit(self, id: str, file: str) -> tuple[str, bytes]:
        """Axis; then background, fit and residual."""
        fitted = await self._fitted(id, file, None)
        return fitted["axis"], base64.b64decode(fitted["curves"])

    async def curve(self, id: str, element: str) -> Response:
        """The calibration curve of an element, as SVG."""
        asked = {"folder": str(self._runs.place(id)), "element": element}
        told = await self._worker.ask("curve", asked, PEAKS_S)
        headers = {"Content-Security-Policy": CLOSED, "Cache-Control": "private, no-cache"}
        return Response(told["svg"], media_type="image/svg+xml", headers=headers)

    async def _fitted(self, id: str, file: str, elements: list[str] | None) -> dict[str, Any]:
        path = self._inside(id, file)
        read = await asyncio.to_thread(self._spectra.read, path)
        key = (read.tag, tuple(elements or ()))
        if key not in self._fits:
            try:
                asked = {"path": str(path), "elements": elements or None}
                fitted = await self._worker.ask("peaks", asked, PEAKS_S)
            except WorkFailed as fault:
                raise Refusal(422, "NO_FIT", f"{file} cannot be fitted: {fault}") from fault
            self._fits[key] = {**fitted, "axis": read.axis}
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
            raise Refusal(422, "WRONG_NAME", f"{name!r} is a link to outside the run")
        return path


def spectra_of(run: OpenRun) -> list[models.SpectrumHead]:
    """The spectrum files of a run with their iterations."""
    heads = []
    for file, (loop, within, key) in list(run.picture.files.items()):
        if not file.lower().endswith(SUFFIXES):
            continue
        table = run.picture.tables.get((loop, within))
        slot = table.slots.get(key) if table is not None else None
        index = table.index[slot] if table is not None and slot is not None else None
        full = f"{within}/{key}" if within else key
        heads.append(
            models.SpectrumHead(file=file, loop=loop or None, key=full or None, index=index)
        )
    return heads


def _of_sample(
    folder: Path, heads: list[models.SpectrumHead], sample: str
) -> list[models.SpectrumHead]:
    """Those of rows in which the column `sample` says so; all where no table has one."""
    tables = [read_table(folder, name) for name in table_names(folder)]
    told = [table.columns for table in tables if SAMPLE in table.columns and "key" in table.columns]
    rows = [row for one in told for row in zip(one["key"], one[SAMPLE], strict=True)]
    keys = {key for key, name in rows if name == sample}
    return [one for one in heads if _is_in(one.key or "", keys)] if told else heads


def _is_in(key: str, keys: set[str]) -> bool:
    """True for one of the keys, or an iteration within one."""
    while key and key not in keys:
        key = key.rpartition("/")[0]
    return bool(key)


def chosen(run: OpenRun, asked: models.Selection) -> list[str]:
    """The spectrum files of the selected points."""
    wanted = set(asked.keys)
    return [
        head.file
        for head in spectra_of(run)
        if head.key in wanted and (asked.loop is None or head.loop == asked.loop)
    ]


def _files(folder: Path) -> list[models.RunFile]:
    return [
        models.RunFile(name=name, size=(folder / name).stat().st_size, kind=_kind(name))
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
    if name.lower().endswith((".png", ".jpg", ".jpeg", ".svg", ".pdf")):
        return "figure"
    if name in ("report.html", "ro-crate-metadata.json"):
        return "report"
    return "spectrum" if "/" in name and name.lower().endswith(SUFFIXES) else "other"


def _attached(name: str) -> dict[str, str]:
    return {"Content-Disposition": f'attachment; filename="{SAFE_NAME.sub("_", name)}"'}
