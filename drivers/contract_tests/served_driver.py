"""The setting of the contract tests: the driver on a real server, its peer, and a kill -9 between."""

import asyncio
import functools
import inspect
import json
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any, ClassVar

from ...schemas.contract import Action
from ...schemas.messages import Goal
from ..client.launch import start_server
from .case import Case, Params
from .session import Session, connected, serving_in_process, settings

AT_MOST_S = 100.0


def blocking(story: Callable[..., Awaitable[None]]) -> Callable[..., None]:
    """Run an async test as pytest calls it."""

    @functools.wraps(story)
    def test(*given: Any, **more: Any) -> None:
        async def all_of_it() -> None:
            async with asyncio.timeout(AT_MOST_S):
                await story(*given, **more)

        asyncio.run(all_of_it())

    return test


def _takes_action(test: Callable[..., None]) -> bool:
    return "action" in inspect.signature(test).parameters


class Stage:
    """What a subclass defines for its driver: `case` and, if needed, the methods that follow."""

    case: ClassVar[Case]
    _actions: ClassVar[dict[str, Action]]

    @contextmanager
    def peer(self, folder: Path, *, slow: bool) -> Iterator[Params]:
        """The peer that the driver talks to during a test; yields more configuration.

        An emulator on a pseudo-terminal yields its port. It outlives the server, as the real
        instrument would. `slow` is true if an action has to be interrupted halfway.
        """
        yield {}

    def is_safe(self, status: Params) -> bool:
        """Whether a device with this status is in its safe state; override it if status shows that."""
        return True

    def happened(self, folder: Path, goal_id: str) -> bool:
        """What the instrument itself knows about a goal; a labrun twin logs what it did."""
        path = folder / "world" / "truth" / f"{self.case.device}.jsonl"
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        return any(json.loads(line).get("goal") == goal_id for line in lines)

    def rest(self, folder: Path) -> None:
        """Wait until the instrument has carried out its commands; a separate instrument carries on
        when its server is killed, and what it knows about a goal counts from then on."""

    def __init_subclass__(cls, **more: Any) -> None:
        """Drop the tests that apply to no action of this contract."""
        super().__init_subclass__(**more)
        if "case" in cls.__dict__:
            cls._actions = cls.case.read_contract().actions
            for name in [n for n in dir(cls) if n.startswith("test_")]:
                if _takes_action(getattr(cls, name)) and not cls._about(name):
                    setattr(cls, name, None)

    def pytest_generate_tests(self, metafunc: Any) -> None:
        """Run a test that takes `action` once for each action it applies to."""
        if "action" in metafunc.fixturenames:
            metafunc.parametrize("action", self._about(metafunc.function.__name__))

    @classmethod
    def _about(cls, test: str) -> list[str]:
        actions = cls._actions
        about = {
            "cancellable": [n for n, a in actions.items() if a.cancel],
            "once": [n for n, a in actions.items() if a.effect == "once" and a.probe],
        }
        return next((names for kind, names in about.items() if kind in test), list(actions))

    @asynccontextmanager
    async def _serving(
        self, folder: Path, config: Params, *, slow: bool
    ) -> AsyncIterator[tuple[str, list[str]]]:
        """A server of the driver: its address, and the actions that its driver is called for."""
        case = self.case
        config = {**case.config, **(case.slow if slow else {}), **config}
        async with serving_in_process(settings(case, case.read_contract(), config, folder)) as (
            _, url, calls,
        ):  # fmt: skip
            yield url, calls

    @asynccontextmanager
    async def _killable(
        self, folder: Path, config: Params
    ) -> AsyncIterator[tuple[str, asyncio.subprocess.Process]]:
        """The same in a process of its own, with actions that last: its address, and the process."""
        case = self.case
        config = {**case.config, **case.slow, **config}
        server = await start_server(settings(case, case.read_contract(), config, folder), folder)
        try:
            assert server.process is not None
            yield server.url, server.process
        finally:
            await server.stop()

    @asynccontextmanager
    async def _served(
        self, folder: Path, *, slow: bool = False
    ) -> AsyncIterator[tuple[str, list[str]]]:
        with self.peer(folder, slow=slow) as found:
            async with self._serving(folder, found, slow=slow) as served:
                yield served

    @asynccontextmanager
    async def _session(
        self, folder: Path, *, slow: bool = False
    ) -> AsyncIterator[tuple[Session, list[str]]]:
        async with (
            self._served(folder, slow=slow) as (url, calls),
            connected(self.case, self.case.read_contract(), url) as session,
        ):
            yield session, calls

    @asynccontextmanager
    async def _killed(
        self, folder: Path, action: str, *, wait: bool = False
    ) -> AsyncIterator[tuple[Session, Goal]]:
        """Kill the server in the middle of an action and restart it; its peer keeps running."""
        case, contract = self.case, self.case.read_contract()
        with self.peer(folder, slow=True) as found:
            async with (
                self._killable(folder, found) as (url, process),
                connected(case, contract, url) as session,
            ):
                await session.prepare(action)
                goal, following = await session.begin(action)
                while wait and not following.done() and not self.happened(folder, goal.id):  # noqa: ASYNC110
                    await asyncio.sleep(0.02)
                process.kill()
                await process.wait()
                following.cancel()
                await asyncio.gather(following, return_exceptions=True)
            async with (
                self._serving(folder, found, slow=False) as (url, _),
                connected(case, contract, url, owner="next") as session,
            ):
                yield session, goal
