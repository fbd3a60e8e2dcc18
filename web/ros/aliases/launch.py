"""`/launch`: start and stop the protocols that the lab registers for it; nothing reaches a shell."""

import asyncio
import json
import logging
import shlex
from collections.abc import Mapping
from pathlib import Path

from ....engine.lab.lab import LoadedLab
from ....engine.language.suggest import listed
from ..interfaces.fault import RosFault
from ..offers.goals import CANCELING, Goal
from ..offers.offer import Refused, Service, Values
from ..offers.run_protocol import NAME as RUN_PROTOCOL
from ..offers.run_protocol import RunProtocol
from .kinds import LAUNCH_REQUEST
from .paper import Paper

NAME = "/launch"
START, STOP = ("launch", "run"), ("kill", "stop", "abort")
LOG = logging.getLogger(__name__)


def add(paper: Paper, protocols: Mapping[str, str], lab: LoadedLab) -> None:
    """Offer it if anything is registered; raises RosFault if a file does not exist."""
    if not protocols:
        return
    base = lab.path.parent.resolve() if lab.path is not None else Path.cwd()
    run = paper.offered.offers.actions[RUN_PROTOCOL]
    assert isinstance(run, RunProtocol)
    for name, file in protocols.items():
        path = (base / file).resolve()
        if not path.is_file():
            raise RosFault(f"ros.launch: {name}: the file {path} does not exist")
        run.registered[name] = path
    paper.offered.offers.services[NAME] = Launch(paper, run, list(protocols))


class Launch(Service):
    """Unlike the paper's service, this runs no command line that a browser sends (`cmd=cli`)."""

    kind = LAUNCH_REQUEST

    def __init__(self, paper: Paper, run: RunProtocol, names: list[str]) -> None:
        self.name = NAME
        self._goals = paper.offered.goals
        self._run = run
        self._names = names
        self._running: dict[str, Goal] = {}
        self._turn = asyncio.Lock()  # a second click while the first is being checked

    async def answer(self, values: Values) -> Values:
        """`{message, is_launched, file_name}`: a refusal, too, is an answer, as in the paper."""
        async with self._turn:
            return await self._answer(values)

    async def _answer(self, values: Values) -> Values:
        given = values if isinstance(values, dict) else {}
        asked = [given.get(name) or "" for name in ("cmd", "package", "file_name", "args")]
        cmd, package, name, args = (str(word) for word in asked)
        full = f"{package} {name}".strip()[:200]
        running = self._running.get(name)
        if running is not None and running.ended is not None:
            del self._running[name]
            running = None
        if cmd in STOP:
            return self._stop(name, full, running)
        if cmd not in START:
            words = f"cmd is one of {listed((*START, *STOP))}, not {cmd[:40]!r}"
            return _said(name, f"{words}; no command line is run.", False)
        if running is not None and running.status == CANCELING:
            words = (
                f"{full} failed to launch: it is still being stopped; try again when it has ended."
            )
            return _said(name, words, False)
        if running is not None:
            return _said(name, f"{full} has already been launched.", True)
        try:
            await self._launch(name, args)
        except Refused as fault:
            LOG.warning("%s: %s is not launched: %s", NAME, full, fault)
            return _said(name, f"{full} failed to launch: {fault}", False)
        return _said(name, f"{full} was launched successfully.", True)

    async def _launch(self, name: str, args: str) -> None:
        if name not in self._names:
            raise Refused(
                f"{name[:100]!r} is not registered; `ros: launch:` of the lab has {listed(self._names)}"
            )
        goal = {"protocol": name, "params_json": params_json(args)}
        self._running[name] = await self._goals.begin(self._run, goal, lambda feedback: None)

    def _stop(self, name: str, full: str, running: Goal | None) -> Values:
        if running is None:
            return _said(name, f"{full} has not been launched yet.", False)
        self._goals.cancel(running)
        return _said(name, f"{full} is being stopped.", False)


def params_json(args: str) -> str:
    """Parameters as JSON text, from a JSON object or from ROS's words; raises Refused.

    `--ros-args -p NAME:=VALUE`, as `ros2 run` takes them; `NODE:NAME` is NAME.
    """
    if not args.strip() or args.lstrip().startswith("{"):
        return args
    try:
        words = shlex.split(args)
    except ValueError as fault:
        raise Refused(f"args: {fault}: {args[:100]!r}") from fault
    found: dict[str, str] = {}
    if words.pop(0) != "--ros-args":
        raise Refused(f"args: {args[:100]!r} does not begin with --ros-args")
    while words:
        option = words.pop(0)
        name, assigns, value = (words.pop(0) if words else "").partition(":=")
        if option not in ("-p", "--param") or not name or not assigns:
            raise Refused(f"args: after --ros-args come `-p NAME:=VALUE`, not {option[:40]!r}")
        found[name.rpartition(":")[2]] = value
    return json.dumps(found)


def _said(name: str, message: str, launched: bool) -> Values:
    return {"message": message, "is_launched": launched, "file_name": name}
