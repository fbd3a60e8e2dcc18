"""A device on a real server, and a client that holds it, as an engine would."""

import asyncio
import itertools
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...schemas.contract import Contract
from ...schemas.messages import FileContent, Goal
from ...schemas.patterns import validator
from ...system.tasks import end, first_of, spawn
from ..client.client import DeviceClient
from ..client.outcome import Outcome
from ..driver import GoalContext
from ..server.host import serving
from ..server.server import DeviceServer
from ..server.settings import ServerSettings
from .case import Case, Params

MOMENT_S = 0.3
"""After this long an action that has begun is halfway through."""

TOLD_LATE_S = 2.0
OWNER = "run"

_numbers = itertools.count(1)


@dataclass(slots=True)
class Session:
    """One client with the device's lease."""

    case: Case
    contract: Contract
    client: DeviceClient
    statuses: list[dict[str, Any]] = field(default_factory=list)

    def goal(
        self, action: str, params: Params | None = None, timeout_s: float | None = None
    ) -> Goal:
        """A new goal, with the parameters of the valid call by default."""
        params = dict(self.case.good[action] if params is None else params)
        read, _ = self.contract.actions[action].path_params()
        return Goal(
            id=f"run/{action}/{next(_numbers)}", device=self.case.device, action=action,
            boot=self.client.boot, epoch=self.client.epoch(self.case.device), params=params,
            timeout_s=timeout_s,
            files={name: FileContent.of(str(params[name]), self.case.files[name])
                   for name in read if name in params},
        )  # fmt: skip

    async def do(self, action: str, params: Params | None = None) -> Outcome:
        """Send a goal and wait for its end."""
        return await self.client.follow(self.goal(action, params))

    async def prepare(self, action: str) -> None:
        """Do what is needed before the action."""
        for need in self.case.needs.get(action, []):
            outcome = await self.do(need)
            assert outcome.state == "SUCCEEDED", f"{need}, before {action}: {outcome.error}"

    async def begin(
        self, action: str, timeout_s: float | None = None
    ) -> tuple[Goal, "asyncio.Task[Outcome]"]:
        """Send a valid call and return in the middle of it, or at its beginning if it is quick."""
        begun = asyncio.Event()
        goal = self.goal(action, timeout_s=timeout_s)
        following = spawn(
            f"following {goal.id}", self.client.follow(goal, lambda report: begun.set())
        )
        waiting = spawn(f"the first report on {goal.id}", begun.wait())
        await first_of({following, waiting})
        await end(waiting)
        if action in self.case.quick:
            return goal, following
        await asyncio.wait({following}, timeout=MOMENT_S)
        assert not following.done(), (
            f"{action} was over within {MOMENT_S:g} s ({following.result()}): `slow` must make it "
            "last for more than two seconds"
        )
        return goal, following

    async def renew_for(self, ttl_s: float) -> None:
        """Renew the lease once, for this long: by the client's own renewals it lasts much longer."""
        device = self.case.device
        request = {
            "device": device,
            "owner": OWNER,
            "ttl_s": ttl_s,
            "epoch": self.client.epoch(device),
        }
        await self.client._link.call("lease", request)

    async def newest_status(self) -> dict[str, Any]:
        """The next status that the server sends."""
        self.statuses.clear()
        async with asyncio.timeout(10):
            while not self.statuses:  # noqa: ASYNC110 - the client reports through a callback
                await asyncio.sleep(0.01)
        return self.statuses[-1]

    async def status_once(self, true: Callable[[Params], bool]) -> Params:
        """The first status for which this is true; after two seconds the latest, whatever it is.

        An instrument's status may be slightly older than its last command.
        """
        until = asyncio.get_running_loop().time() + TOLD_LATE_S
        while not true(status := await self.newest_status()):
            if asyncio.get_running_loop().time() > until:
                break
        return status


@asynccontextmanager
async def connected(
    case: Case, contract: Contract, url: str, *, owner: str | None = OWNER
) -> AsyncIterator[Session]:
    """A session with the server at `url`; without an owner it holds no lease and only reads."""
    statuses: list[dict[str, Any]] = []
    client = DeviceClient(url, on_status=lambda device, status: statuses.append(status))
    await client.open()
    try:
        if owner is not None:
            await client.take_lease(case.device, owner)
        yield Session(case, contract, client, statuses)
    finally:
        await client.close()


@asynccontextmanager
async def serving_in_process(
    settings: Params,
) -> AsyncIterator[tuple[DeviceServer, str, list[str]]]:
    """A server in this process, its address, and the list of calls to its driver."""
    async with serving(ServerSettings.model_validate(settings)) as (server, url):
        calls: list[str] = []
        for device in server.devices.values():
            _note_calls(device._driver, calls)
        yield server, url, calls


def settings(case: Case, contract: Contract, config: Params, folder: Path) -> Params:
    """The settings of a server for this one device."""
    device = {
        "contract": contract.model_dump(mode="json"),
        "driver": case.driver,
        "config": config,
        "limits": case.limits,
    }
    return {
        "devices": {case.device: device},
        "folder": str(folder / "server"),
        "world": str(folder / "world"),
    }


def check_status(session: Session, status: Params) -> None:
    assert "fault" not in status, status["fault"]
    faults = validator(session.contract.status).iter_errors(status)
    assert not (words := [fault.message for fault in faults]), f"status: {'; '.join(words)}"


def _note_calls(driver: Any, calls: list[str]) -> None:
    unnoted = driver.method

    def method(name: str) -> Any:
        async def noted(goal: GoalContext, **params: Any) -> Any:
            if not goal.id.startswith("safe:"):  # the server's own way into the safe state
                calls.append(name)
            return await unnoted(name)(goal, **params)

        return noted

    driver.method = method
