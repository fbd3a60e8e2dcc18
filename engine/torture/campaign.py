"""One tortured run: started, killed, resumed, until it ends by itself."""

import asyncio
import contextlib
import functools
import json
import shutil
import signal
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import TypeVar

from ...system.tasks import in_time, spawn
from ..control.server import NotLive, ask_run
from .accounts import Account, account
from .bench import Bench
from .plan import STOPPED_S, Kill, Whom
from .verdict import Breach
from .victim import kill_servers

T = TypeVar("T")
DEAD_S = 0.3
"""So long after a SIGKILL nobody writes any more."""
STILL_S = 150.0
"""An engine that prints nothing for this long is stuck."""
TAKES = 8
"""How many resumes in a row may fail to reach the devices before that is a breach."""


@dataclass(slots=True)
class Campaign:
    """A run and its kills. `dealt` counts the kills that happened, by their labels."""

    protocol: Path
    lab: Path
    options: list[str]
    folder: Path
    kills: Iterator[Kill]
    budget: int
    random: Random
    bench: Bench | None = None
    run: Path | None = None
    dealt: Counter[str] = field(default_factory=Counter)
    breaches: list[Breach] = field(default_factory=list)
    _copies: dict[Path, dict[Path, bytes]] = field(default_factory=dict)
    _unreached: int = 0
    _heard_at: float = 0.0

    @property
    def world(self) -> Path:
        """Where the simulated devices keep the logs of what they did."""
        assert self.run is not None
        return (self.bench.folder if self.bench else self.run / "servers") / "world"

    async def suffer(self) -> Account | None:
        """Run to the end; returns the two accounts of the run, or None if it never started."""
        while True:
            if await self._session(self._next_kill()):
                break
        return None if self.run is None else account(self.run, self.world)

    def _next_kill(self) -> Kill | None:
        return next(self.kills, None) if self.budget > sum(self.dealt.values()) else None

    async def _session(self, kill: Kill | None) -> bool:
        """Run one engine session; True when the run needs no other."""
        process = await self._start(kill)
        listening = spawn("listen to the engine", self._listen(process))
        aborted = False
        try:
            while kill is not None and kill.after_s is not None:
                if await in_time(process.wait(), kill.after_s):
                    break
                aborted = kill.whom == "abort"
                self._strike(process, kill)
                if not kill.whom.startswith("servers"):
                    break
                kill = self._next_kill()
                while kill is not None and kill.after_s is None:
                    kill = self._next_kill()
            await self._end_of(process)
            if self.bench is not None:
                await self.bench.back()
        finally:
            with contextlib.suppress(ProcessLookupError):
                process.kill()
            await process.wait()
            await listening
        if kill is not None and kill.flush and process.returncode == -signal.SIGKILL:
            self.dealt[kill.label] += 1
        return self._over(process.returncode, aborted=aborted)

    async def _start(self, kill: Kill | None) -> asyncio.subprocess.Process:
        command = ["-m", "labrun.engine"]
        if kill is not None and kill.flush:
            doom: dict[str, object] = {"flush": kill.flush, "form": kill.form, "servers": None}
            if kill.whom == "engine and servers":
                doom["servers"] = str(self.bench.folder) if self.bench else "own"
            command = ["-m", "labrun.engine.torture.victim", json.dumps(doom)]
        runs = self.folder / "runs"
        if self.run is None:
            shutil.rmtree(runs, ignore_errors=True)
            lab = self.bench.lab_file if self.bench else self.lab
            command += ["run", str(self.protocol), *self.options, "--lab", str(lab)]
        else:
            command += ["resume", self.run.name]
        self.folder.mkdir(parents=True, exist_ok=True)
        self._heard_at = asyncio.get_running_loop().time()
        with (self.folder / "engine.log").open("ab") as log:
            return await asyncio.create_subprocess_exec(
                sys.executable, *command, "--yes", "--json", "--runs", str(runs),
                stdin=asyncio.subprocess.DEVNULL, stdout=asyncio.subprocess.PIPE, stderr=log,
                limit=2**24,
            )  # fmt: skip

    def _strike(self, process: asyncio.subprocess.Process, kill: Kill) -> None:
        with contextlib.suppress(ProcessLookupError):
            if kill.whom == "abort":
                process.send_signal(signal.SIGTERM)
            elif not kill.whom.startswith("servers"):
                process.kill()
        self.dealt[kill.label] += bool(self._strike_servers(kill.whom))

    def _strike_servers(self, whom: Whom) -> int:
        """Servers get their share of a kill; returns whether it happened."""
        match whom:
            case "engine" | "abort":
                return 1
            case "servers end":
                return self._signal_some_servers(signal.SIGTERM)
            case "servers stop":
                go_on = functools.partial(self._signal_some_servers, signal.SIGCONT, every=True)
                asyncio.get_running_loop().call_later(STOPPED_S, go_on)
                return self._signal_some_servers(signal.SIGSTOP)
            case "ledgers":
                struck = self._signal_some_servers(signal.SIGKILL, every=True)
                return struck if self.bench is not None else self._put_back_ledgers()
            case _:
                return self._signal_some_servers(signal.SIGKILL)

    def _signal_some_servers(self, by: signal.Signals, *, every: bool = False) -> int:
        if self.bench is not None:
            names = self.bench.devices if every else self._some(self.bench.devices)
            self.bench.kill(names, by)
            return len(names)
        present = sorted((self.folder / "runs").glob("*/servers/*/server.json"))
        return kill_servers(present if every else self._some(present), by)

    def _some(self, of: list[T]) -> list[T]:
        return self.random.sample(of, self.random.randint(1, len(of))) if of else []

    def _put_back_ledgers(self) -> int:
        """Of servers that are dead: an older copy, or no write-ahead log any more, or none at all."""
        time.sleep(DEAD_S)
        changed = 0
        for ledger in sorted((self.folder / "runs").glob("*/servers/*/ledger.sqlite")):
            log = ledger.with_name("ledger.sqlite-wal")
            older = self._copies.get(ledger)
            self._copies[ledger] = {p: p.read_bytes() for p in (ledger, log) if p.exists()}
            how = self.random.choice(("copy", "log", "none", "as it is"))
            if how in ("log", "none") or (how == "copy" and older):
                log.unlink(missing_ok=True)
                changed += 1
            if how == "none":
                ledger.unlink()
            for path, data in (older or {}).items() if how == "copy" else ():
                path.write_bytes(data)
        return changed

    async def _end_of(self, process: asyncio.subprocess.Process) -> None:
        clock = asyncio.get_running_loop().time
        while not await in_time(process.wait(), 1.0):
            if clock() - self._heard_at > STILL_S:
                self._breach("end", f"it printed nothing for {STILL_S:g} s and was killed")
                process.kill()

    async def _listen(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdout is not None
        async for line in process.stdout:
            self._heard_at = asyncio.get_running_loop().time()
            with contextlib.suppress(ValueError):
                event = json.loads(line)
                if event["event"] == "run":
                    self.run = self.folder / "runs" / event["path"]
                elif event["event"] == "question" and event["state"] == "open":
                    await asyncio.to_thread(self._answer, event)

    def _answer(self, event: dict) -> None:
        """Answer as a person does: look at the device, and state what is true."""
        assert self.run is not None
        choice = event["data"]["choices"][0]
        goal, mark, _ = event["path"].rpartition("/unknown")
        if mark:
            done = {deed.goal for deed in account(self.run, self.world).deeds}
            choice = "skip" if f"{self.run.name}/{goal}" in done else "repeat"
        request = {"verb": "answer", "id": event["path"], "choice": choice, "by": "torture"}
        with contextlib.suppress(NotLive):  # the engine was killed: the next one asks again
            ask_run(self.run, request)

    def _over(self, status: int | None, *, aborted: bool) -> bool:
        if self.run is None:
            self._forget_nameless()
            return status in (0, 2, 70)
        if status == -signal.SIGKILL or aborted:
            return bool(self.breaches) or account(self.run, self.world).succeeded
        self._unreached = self._unreached + 1 if status == 4 else 0
        if status == 4 and self._unreached < TAKES:
            return False
        if status not in (0, 1):
            self._breach("end", f"exit status {status}; see {self.folder / 'engine.log'}")
        return True

    def _forget_nameless(self) -> None:
        """Killed before it printed its name: nothing may have been done, and a new run starts."""
        for folder in (self.folder / "runs").glob("*"):
            kill_servers(sorted(folder.glob("servers/*/server.json")))
            done = [p for p in folder.glob("servers/world/truth/*.jsonl") if p.stat().st_size]
            if done:
                self._breach("announced", f"{done[0].stem} acted before the run had a name")

    def _breach(self, promise: str, text: str) -> None:
        name = self.run.name if self.run else self.folder.name
        self.breaches.append(Breach(promise, name, text))
