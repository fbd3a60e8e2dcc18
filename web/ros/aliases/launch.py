"""`/launch`: start and stop the protocols that the lab registers for it; nothing reaches a shell."""

from collections.abc import Mapping
from pathlib import Path

from ....engine.lab.lab import LoadedLab
from ....engine.language.suggest import listed
from ..interfaces.fault import RosFault
from ..offers.goals import Goal
from ..offers.offer import Refused, Service, Values
from ..offers.run_protocol import NAME as RUN_PROTOCOL
from ..offers.run_protocol import RunProtocol
from .kinds import LAUNCH_REQUEST
from .paper import Paper

NAME = "/launch"
START, STOP = ("launch", "run"), ("kill", "stop", "abort")


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

    async def answer(self, values: Values) -> Values:
        """`{file_name, message, is_launched}`; raises Refused."""
        given = values if isinstance(values, dict) else {}
        asked = {name: given.get(name) or "" for name in ("cmd", "file_name", "args")}
        odd = [name for name, value in asked.items() if not isinstance(value, str)]
        if odd:
            raise Refused(f"{odd[0]} must be a string")
        cmd, name = asked["cmd"], asked["file_name"]
        if cmd not in (*START, *STOP):
            raise Refused(
                f"cmd must be one of {listed((*START, *STOP))}, not {cmd[:40]!r}; no command line is run"
            )
        if name not in self._names:
            raise Refused(
                f"{name[:100]!r} is not registered; `ros: launch:` of the lab has {listed(self._names)}"
            )
        running = self._running.get(name)
        if running is not None and running.ended is not None:
            del self._running[name]
            running = None
        if cmd in STOP:
            return self._stop(name, running)
        if running is not None:
            return _said(name, f"{name} has already been launched.", True)
        goal = {"protocol": name, "params_json": asked["args"]}
        self._running[name] = await self._goals.begin(self._run, goal, lambda feedback: None)
        return _said(name, f"{name} is launched", True)

    def _stop(self, name: str, running: Goal | None) -> Values:
        if running is None:
            return _said(name, f"{name} has not been launched yet.", False)
        self._goals.cancel(running)
        return _said(name, f"{name} is being aborted", False)


def _said(name: str, message: str, launched: bool) -> Values:
    return {"file_name": name, "message": message, "is_launched": launched}
