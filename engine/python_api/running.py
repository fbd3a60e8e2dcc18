"""`labrun.run`, `arun` and `start`: run a protocol from Python, in a notebook's running loop too."""

import asyncio
import concurrent.futures.thread  # noqa: F401 - see _live
import inspect
import json
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from ..check import Checked
from ..commands.run import begin, in_words
from ..control.control import Control
from ..control.server import NotLive, ask_run
from ..dispatch.connect import NotReached
from ..journal.journal import JournalFault
from ..run.folder import FolderFault
from ..run.run import Listener, Run
from ..runner.begin import RunOptions
from .bar import watch
from .checking import PathLike, ProtocolLike, checked_protocol
from .faults import Refused
from .protocol import plain
from .recorded_run import RecordedRun
from .threads import POLL_S, Work, result

P = ParamSpec("P")
T = TypeVar("T")
BY = "Python"


class LiveRun:
    """A run that goes on in a thread of its own; `wait` for its end, or `abort` it."""

    def __init__(
        self, checked: Checked, runs: Path, given: dict[str, str], options: RunOptions
    ) -> None:
        self._aborted_by: list[str] = []
        self._control: tuple[asyncio.AbstractEventLoop, Control] | None = None
        options.watchers = [self._watch, *options.watchers]
        try:
            run, self._lock = begin(checked, runs, given, options)
        except (FolderFault, JournalFault) as fault:
            raise Refused(str(fault)) from None
        self.folder: Path = run.folder
        work = Work(f"run {run.id}", lambda: self._run(run, checked, options))
        self._work: Work[None] = work
        _live.add(self)

    def wait(self, timeout: float | None = None) -> RecordedRun:
        """Wait for the end, at most `timeout` seconds (then TimeoutError; the run goes on).

        Ctrl-C aborts the run as in a terminal, twice at once, and the end is waited for. Raises
        Refused where a device could not be reached, or the run's folder failed it.
        """
        try:
            result(self._work.ended, timeout, lambda: self.abort("Ctrl-C"))
            self._work.join()
        except TimeoutError:
            raise TimeoutError(f"{self.folder.name} has not ended; it goes on") from None
        return RecordedRun(self.folder)

    async def ended(self) -> RecordedRun:
        """The same for a coroutine; being cancelled aborts the run and waits for its end."""
        ended = asyncio.wrap_future(self._work.ended)
        try:
            while not ended.done():  # a notebook's loop hears of an interrupt only when it wakes up
                await asyncio.wait({ended}, timeout=POLL_S)
        except asyncio.CancelledError:
            self.abort()
            await asyncio.wait({ended})
            raise
        await ended
        return RecordedRun(self.folder)

    def answer(self, id: str, choice: str, **returned: str) -> None:
        """Answer an open question; `returned` with `happened`: what the action returned. Raises Refused."""
        asked = {"verb": "answer", "id": id, "choice": choice, "values": returned}
        try:
            complied, text = ask_run(self.folder, asked)
        except NotLive as fault:
            raise Refused(str(fault)) from None
        if not complied:
            raise Refused(text)

    def pause(self) -> None:
        """Finish what is running, then hold."""
        self._ask("pause")

    def go_on(self) -> None:
        """Continue after a pause."""
        self._ask("continue")

    def abort(self, by: str = BY) -> None:
        """Cancel, run `finally`, bring devices to their safe state; a second time: at once."""
        self._aborted_by.append(by)
        self._ask("abort", by)

    def _ask(self, verb: Any, by: str = BY) -> None:
        if self._control is not None and self._work.is_alive():
            loop, control = self._control
            loop.call_soon_threadsafe(control.ask, verb, by)

    def _watch(self, run: Run, control: Control) -> Listener:
        self._control = (asyncio.get_running_loop(), control)
        for by in self._aborted_by:  # while devices were being reached
            control.ask("abort", by)
        return lambda event: None

    def _run(self, run: Run, checked: Checked, options: RunOptions) -> None:
        from ..runner.runner import run_session

        try:
            asyncio.run(run_session(run, checked, options))
        except (JournalFault, NotReached, OSError) as fault:
            raise Refused(in_words(fault)) from None
        finally:
            self._lock.release()
            _live.discard(self)

    def __repr__(self) -> str:
        state = "live" if self._work.is_alive() else "ended"
        return f"<labrun run {self.folder.name}: {state}>"


def _wait_for_all() -> None:
    """A program that ends waits for its runs; Ctrl-C aborts them."""
    for live in [*_live]:
        try:
            live.wait()
        except Exception as fault:  # nobody else is there to be told
            print(fault, file=sys.stderr)


_live: set[LiveRun] = set()
# `atexit` is too late: Python has ended its pools of threads then, without which no run goes on. What
# is registered here comes before what was registered earlier, as `concurrent.futures.thread` was.
threading._register_atexit(_wait_for_all)  # type: ignore[attr-defined]


def start(
    protocol: ProtocolLike,
    *,
    lab: PathLike | None = None,
    bind: Mapping[str, str] | None = None,
    runs: PathLike = "runs",
    yes: bool = False,
    answers: Mapping[str, str] | None = None,
    progress: bool = True,
    params: Mapping[str, Any] | None = None,
    **more_params: Any,
) -> LiveRun:
    """Check a protocol, begin to run it in a thread, and return at once.

    lab, bind and parameters as in `labrun.check`. runs: the folder that the run's folder is made in.
    yes: answer every `confirm` with yes. answers: question id -> choice; what is asked beyond these
    waits for `LiveRun.answer`, `labrun answer` or the page. progress: print what `labrun run` prints.
    Raises ProtocolFault, and Refused where no folder can be made.
    """
    given = {**(params or {}), **more_params}
    checked = checked_protocol(protocol, lab, bind, given, needed=True)
    options = RunOptions(yes=yes, answers=dict(answers or {}), live_figures=True)
    if progress:
        options.say = print
        options.watchers = [lambda run, control: watch()]
    texts = {name: _text(plain(value)) for name, value in given.items()}
    return LiveRun(checked, Path(runs), texts, options)


def _text(value: Any) -> str:
    """A parameter as it is written on the command line: what a resume reads."""
    return value if isinstance(value, str) else json.dumps(value)


def _called_as(other: Callable[P, Any]) -> Callable[[Callable[..., T]], Callable[P, T]]:
    """The parameters of another function, for type checkers, editors and a notebook's help."""

    def called(function: Any) -> Any:
        mine, theirs = inspect.signature(function), inspect.signature(other)
        returns = mine.return_annotation
        function.__signature__ = theirs.replace(return_annotation=returns)
        return function

    return called


@_called_as(start)
def run(*protocol: Any, **options: Any) -> RecordedRun:
    """Check a protocol, run it to its end, and return what is in its folder; options as `start`.

    A run that fails or is aborted is returned, too: look at its `fate`. Raises ProtocolFault, and
    Refused where a device could not be reached, or the run's folder failed it.
    """
    return start(*protocol, **options).wait()


@_called_as(start)
async def arun(*protocol: Any, **options: Any) -> RecordedRun:
    """The same as a coroutine: the loop goes on meanwhile. Being cancelled aborts the run."""
    return await start(*protocol, **options).ended()
