"""The tools, thin: each reads or does one thing that the page does, too. Their docstrings are for agents."""

import asyncio
import json
import re
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

from ...engine.lab.lab import LoadedLab, load_lab
from ...engine.language.source import parse_source
from ...engine.python_api.recorded_run import RecordedRun, load, runs
from ...engine.run.came_to import value_text
from ...engine.run.folder import LAB, FolderFault
from ...engine.run.labels import LAUNCH
from ...engine.run.released import lab_digest, put_back, releases, take
from ...system.files import write_whole
from ..library.library import Library
from ..library.names import place_of
from ..library.rehearsals import Rehearsals
from ..library.text_check import TextCheck
from ..local.clock import now_iso
from ..local.refusal import Refusal, not_found
from ..local.workers import Workers
from ..models.protocols import CheckText, ProtocolText, RehearseText
from ..models.runs import Launch
from ..runs.engine import last_words, run_told, start_engine

Params = dict[str, Any]
CHECK_S = 60.0
STARTED_S = 120.0
LOOK_S = 0.05
MOST_RUNS = 200
MOST_ROWS = 1000
COMMENT = "# "
NONE = "there are none"
BEGINS = re.compile(r"^labrun\s*:", re.MULTILINE)


class Tools:
    """What an agent can do in one folder of protocols, against one lab."""

    def __init__(self, protocols: Path, runs: Path, lab: Path | None) -> None:
        state = protocols / ".labrun" / "agents"
        self._folder, self._runs, self._lab = protocols, runs, lab
        self._state = state
        self._workers = Workers()
        self._library = Library(protocols, state, runs)
        timings = state / "timings.json"
        self._checks = TextCheck(self._workers.checks, protocols, lab, timings, timeout_s=CHECK_S)
        self._rehearsals = Rehearsals(self._workers.rehearsals, self._checks, protocols, lab)

    def all(self) -> list[Callable[..., Any]]:
        """Each becomes a tool with its name, parameters and docstring."""
        return [
            self.contracts, self.protocols, self.read_protocol, self.write_protocol, self.check,
            self.words, self.rehearse, self.problem, self.runs, self.run, self.table,
            self.releases, self.launch,
        ]  # fmt: skip

    async def close(self) -> None:
        """End the processes that check and rehearse; runs go on."""
        await self._workers.close()

    def contracts(self) -> str:
        """The lab's devices, each with its contract and the limits of this bench.

        A contract has the actions, their parameters with units and ranges, results and errors.
        """
        lab = self._loaded()
        return _json({
            name: {
                "contract": lab.contracts[device.contract].model_dump(mode="json", exclude_defaults=True),
                "limits": {n: limit.model_dump(mode="json") for n, limit in device.limits.items()},
            }
            for name, device in lab.lab.devices.items()
        })  # fmt: skip

    def protocols(self) -> str:
        """The names of the protocols in the folder."""
        names = self._library.names()
        return "\n".join(name for name in names if self._is_protocol(name)) or NONE

    def read_protocol(self, name: str) -> str:
        """A protocol's YAML. The first line is a comment with its revision, which `write_protocol` wants."""
        found = self._read(name)
        return f"{COMMENT}revision: {found.revision}\n{found.text}"

    async def write_protocol(self, name: str, text: str, revision: str | None = None) -> str:
        """Save a protocol, and check it; without `revision` a new file.

        With `revision` over the text that had it: another one means that somebody has changed it.
        """
        self._writable(name, text)
        if revision is None:
            if place_of(self._folder, name).exists():
                raise Refusal(
                    409, "EXISTS", f"{name} already exists",
                    "give the revision that `read_protocol` shows, or choose another name",
                )  # fmt: skip
            self._library.create(name, text)
        else:
            self._library.save(name, text, revision)
        return await self.check(name)

    async def check(
        self, name: str, params: Params | None = None, bind: dict[str, str] | None = None
    ) -> str:
        """Every problem of a protocol, with line and column.

        params: texts with units, such as {"pitch": "0.5 mm"}. bind: role -> device of the lab.
        """
        from .server import problem_line

        found = self._read(name)
        asked = CheckText(text=found.text, name=name, params=params or {}, bind=bind or {})
        checked = await self._checks.check(asked)
        lines = [problem_line(one) for one in checked.problems]
        return "\n".join([f"revision {found.revision}", *(lines or ["no problems"])])

    async def words(
        self, name: str, params: Params | None = None, bind: dict[str, str] | None = None
    ) -> str:
        """A protocol in plain sentences, as a person reads it before releasing it."""
        from ..models.protocols import Words

        asked = CheckText(
            text=self._read(name).text, name=name, params=params or {}, bind=bind or {}
        )
        return _json((await self._checks.view("words", asked, Words)).model_dump(mode="json"))

    async def rehearse(
        self, name: str, params: Params | None = None, bind: dict[str, str] | None = None,
        fail: list[str] | None = None, seed: int | None = None,
    ) -> str:  # fmt: skip
        """Play a protocol on simulated devices and a virtual clock: how it ends, how long it lasts.

        fail: ["libs.measure:0.05"] lets an action fail with this probability.
        """
        asked = RehearseText(
            text=self._read(name).text, name=name, params=params or {}, bind=bind or {},
            fail=fail or [], seed=seed,
        )  # fmt: skip
        told = await self._rehearsals.play(asked)
        ended = f"{told.fate}: {told.reason}" if told.reason else told.fate
        return "\n".join([ended, *told.lines])

    def problem(self, code: str) -> str:
        """The manual's page of a problem, such as E204: why it is one, and YAML that passes."""
        from ...engine.problems.manual import page

        found = page(code.strip().upper())
        if found is None:
            raise not_found("problem", code, "a code looks like E204")
        return found.text()

    def runs(self, find: str = "") -> str:
        """Runs, newest first. find: "core sample:K17 pitch<0.2mm outcome:failed since:7d -tag:bad"."""
        found = islice(reversed(runs(self._runs, find=find)), MOST_RUNS)
        named = (repr(one).strip("<>").removeprefix("labrun run ") for one in found)
        return "\n".join(named) or NONE

    def run(self, name: str) -> str:
        """What a run came to: its end and reason, parameters, outputs, tables, spectra.

        name: `last`, the name of a run, or an end of it.
        """
        found = self._run(name)
        summary = found.summary.model_dump(mode="json", exclude={"size", "last"})
        summary["params"] = {n: value_text(v) for n, v in summary["params"].items()}
        outputs = {n: str(value) for n, value in found.outputs.items()}
        return _json({
            **summary, "outputs": outputs, "tables": found.tables, "spectra": len(found.spectra),
        })  # fmt: skip

    def table(self, name: str, table: str = "data", first: int = 0, rows: int = 100) -> str:
        """Rows of one of a run's tables, as CSV with its header; names of columns end in their units."""
        found = self._run(name)
        if table not in found.tables:
            raise not_found("table", table, f"{found.id} has {', '.join(found.tables) or 'none'}")
        with (found.folder / f"{table}.csv").open(encoding="utf-8") as file:
            header = file.readline()
            first, last = max(first, 0), max(first, 0) + min(max(rows, 0), MOST_ROWS)
            return header + "".join(islice(file, first, last))

    def releases(self) -> str:
        """What a person has released to be launched, each once.

        With the sha256 of the protocol's text, its parameters and devices.
        """
        return (
            "\n".join(one.model_dump_json(exclude={"lab"}) for one in releases(self._runs)) or NONE
        )

    async def launch(self, release: str) -> str:
        """Start what a person has released, as it was then; the run goes on by itself.

        What it asks, people answer.
        """
        lab = self._loaded()
        released, folder = take(self._runs, release)
        if released.lab != lab_digest(lab):
            put_back(folder)
            raise FolderFault(
                f"the lab has changed since {release} was released, or it is another one: a person "
                "releases it again"
            )
        arguments = ["run", str(next(folder.glob("protocol.*"))), "--runs", str(self._runs)]
        arguments += [] if self._lab is None else ["--lab", str(self._lab)]
        for option, values in (("-p", released.params), ("--bind", released.roles)):
            for key, value in values.items():
                arguments += [option, f"{key}={value}"]
        log = self._state / "launches" / f"{release}.log"
        engine = start_engine(arguments, log, self._folder)
        try:
            async with asyncio.timeout(STARTED_S):
                while (name := run_told(log)) is None and engine.poll() is None:  # noqa: ASYNC110 - a file
                    await asyncio.sleep(LOOK_S)
        except TimeoutError:
            return f"it has not said its name within {STARTED_S:g} s and may start yet; see {log}"
        if name is None and (name := run_told(log)) is None:
            put_back(folder)
            raise FolderFault(f"it was not started, and stays released: {last_words(log)}")
        said = Launch(
            operator=released.by,
            note=f"started by an agent, released as {release}",
            checklist=released.checklist,
            at=now_iso(),
        )
        write_whole(self._runs / name / LAUNCH, said.model_dump_json(indent=1).encode())
        return f"run {name} has begun"

    def _loaded(self) -> LoadedLab:
        lab, problems = load_lab(self._lab)
        if lab is None or any(one.severity == "error" for one in problems):
            raise Refusal(422, "LAB", f"the lab's file has errors: {problems[0].message}")
        return lab

    def _run(self, name: str) -> RecordedRun:
        """A run of this folder; a path to another one is none."""
        a_name = name.strip(".") and not set(name) & set("/\\")
        found = load(name, self._runs) if a_name else None
        if found is None or found.folder.resolve().parent != self._runs.resolve():
            raise not_found("run", name, "`runs` lists all of them")
        return found

    def _is_protocol(self, name: str) -> bool:
        path = place_of(self._folder, name)
        return _is_protocol(path.read_text("utf-8", errors="replace"), path)

    def _read(self, name: str) -> ProtocolText:
        """A protocol; nothing else in the folder, such as a lab with the tokens of its devices."""
        found = self._library.read(name)
        if not _is_protocol(found.text, place_of(self._folder, name)):
            raise Refusal(422, "NO_PROTOCOL", f"{name} is no protocol: only those are read here")
        return found

    def _writable(self, name: str, text: str) -> None:
        """Raise Refusal for what is no protocol, or would lie among the runs: a lab, a contract, a copy."""
        path = place_of(self._folder, name)
        if path.name.lower() == LAB or path == self._lab:
            raise Refusal(422, "WRONG_NAME", f"{name} is a lab's name", "choose another one")
        if path.resolve().is_relative_to(self._runs.resolve()):
            raise Refusal(422, "WRONG_NAME", f"{name} lies in the folder of the runs")
        if not _is_protocol(text, path):
            raise Refusal(
                422, "NO_PROTOCOL", "this is no protocol: it is YAML that begins with `labrun: 1`"
            )
        if path.exists() and not self._is_protocol(name):
            raise Refusal(
                422, "NO_PROTOCOL", f"{name} is there and is no protocol: choose another name"
            )


def _is_protocol(text: str, path: Path) -> bool:
    """Also one that cannot be parsed, as long as a line of it begins with `labrun:`."""
    source, _ = parse_source(text, path, path.name)
    if source is None:
        return BEGINS.search(text) is not None
    return isinstance(source.data, dict) and "labrun" in source.data


def _json(value: Any) -> str:
    return json.dumps(value, indent=1, ensure_ascii=False)
