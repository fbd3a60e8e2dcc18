"""A person releases a protocol on the page: read as it was copied, then given for one start by a program."""

import shutil
from asyncio import to_thread
from collections.abc import Callable
from pathlib import Path

from ...engine.run.released import FOLDER, RECORD, Release, releases
from ...system.files import write_whole
from ..library.library import Library
from ..local.clock import now_iso
from ..local.refusal import Refusal, not_found
from ..local.workers import Worker
from ..models.protocols import Hazard, Words
from ..models.runs import Released, StartRun, ToRelease
from .launching import text_of

LONGEST_S = 120.0


class Releasing:
    """`check_list` raises Refusal where a point of a danger's checklist is not ticked."""

    def __init__(
        self, library: Library, worker: Worker, runs: Path, lab_file: Path | None,
        check_list: Callable[[list[Hazard], list[str]], None],
    ) -> None:  # fmt: skip
        self._library = library
        self._worker = worker
        self._runs = runs
        self._lab_file = lab_file
        self._check_list = check_list
        self._prepared: dict[str, Release] = {}

    async def close(self) -> None:
        """Delete the copies that nobody has released."""
        for id in list(self._prepared):
            self._delete(id)

    async def prepare(self, asked: StartRun) -> ToRelease:
        """Copy what the run will use, and tell it in words; nothing is released yet."""
        self._library.read(asked.protocol)
        params = {name: text_of(value) for name, value in asked.params.items()}
        told = {
            "file": str(self._library.folder / asked.protocol), "revision": asked.revision,
            "runs": str(self._runs), "lab": str(self._lab_file) if self._lab_file else None,
            "params": params, "bind": asked.bind,
        }  # fmt: skip
        found = await self._worker.ask("release", told, LONGEST_S)
        record = Release.model_validate(
            {**found["record"], "by": asked.operator, "checklist": asked.checklist}
        )
        self._prepared[record.id] = record
        try:
            self._check_list(
                [Hazard.model_validate(one) for one in found["hazards"]], asked.checklist
            )
        except Refusal:
            self._delete(record.id)
            raise
        return ToRelease(id=record.id, words=Words.model_validate(found["words"]))

    async def release(self, id: str, by: str) -> Released:
        """What was prepared may be started by a program, once; raises Refusal."""
        if id not in self._prepared:
            raise not_found("prepared release", id, "prepare it again")
        if not by.strip():
            raise Refusal(422, "NO_NAME", "a release is a person's word: your name is needed")
        record = self._prepared.pop(id).model_copy(update={"by": by.strip(), "at": now_iso()})
        path = self._runs / FOLDER / id / RECORD
        await to_thread(write_whole, path, record.model_dump_json(indent=1).encode())
        return Released.of(record)

    def all(self) -> list[Released]:
        """Those that no program has started yet, oldest first."""
        return [Released.of(one) for one in releases(self._runs)]

    def take_back(self, id: str) -> None:
        """Delete a release, or what was prepared for one; raises Refusal (404)."""
        if id not in self._prepared and id not in {one.id for one in releases(self._runs)}:
            raise not_found("release", id, "it was taken back, or a program has started it")
        self._delete(id)

    def _delete(self, id: str) -> None:
        self._prepared.pop(id, None)
        shutil.rmtree(self._runs / FOLDER / id, ignore_errors=True)
