"""`labrun.run`, `arun` and `start`: run a protocol from Python, in a notebook's running loop too."""

import asyncio
from collections.abc import Mapping
from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYet
from pathlib import Path
from threading import Thread
from typing import Any

from ..check import Checked
from ..control.control import Control
from ..run.run import Listener, Run
from ..runner.begin import RunOptions
from .checking import PathLike, checked_protocol
from .recorded_run import RecordedRun

BY = "Python"
POLL_S = 0.2
"""How soon Ctrl-C is heard while a run is waited for."""


class LiveRun:
    """A run that goes on in a thread of its own; `wait` for its end, or `abort` it."""

    def __init__(
        self, checked: Checked, runs: Path, given: dict[str, str], options: RunOptions
    ) -> None:
        from ..commands.run import begin

        self._aborted_by: list[str] = []
        self._control: tuple[asyncio.AbstractEventLoop, Control] | None = None
        options.watchers = [self._watch, *options.watchers]
        run, self._lock = begin(checked, runs, given, options)
        self.folder: Path = run.folder
        self._ended: Future[None] = Future()
        # Not a daemon: a program that ends waits until devices are safe.
        self._thread = Thread(target=self._run, args=(run, checked, options), name=f"run {run.id}")
        self._thread.start()

    def wait(self, timeout: float | None = None) -> RecordedRun:
        """Wait for the end, at most `timeout` seconds (then TimeoutError; the run goes on).

        Ctrl-C aborts the run as in a terminal, twice at once, and the end is waited for. Raises
        NotReached where a device could not be reached, and OSError or JournalFault where the run's
        folder failed it.
        """
        waited = 0.0
        while True:
            try:
                self._ended.result(POLL_S)
                self._thread.join()
                return RecordedRun(self.folder)
            except KeyboardInterrupt:
                self.abort("Ctrl-C")
            except NotYet:
                if self._ended.done():
                    raise
                waited += POLL_S
                if timeout is not None and waited >= timeout:
                    raise TimeoutError(f"{self.folder.name} has not ended; it goes on") from None

    async def ended(self) -> RecordedRun:
        """The same for a coroutine; being cancelled aborts the run and waits for its end."""
        ended = asyncio.wrap_future(self._ended)
        try:
            await asyncio.shield(ended)
        except asyncio.CancelledError:
            self.abort()
            await asyncio.wait({ended})
            raise
        return RecordedRun(self.folder)

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
        if self._control is not None and not self._ended.done():
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
        except BaseException as fault:  # told to whoever waits
            self._ended.set_exception(fault)
        else:
            self._ended.set_result(None)
        finally:
            self._lock.release()

    def __repr__(self) -> str:
        return f"<labrun run {self.folder.name}: {'ended' if self._ended.done() else 'live'}>"


def start(
    protocol: PathLike,
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
    waits for `labrun answer`, or the page. progress: print what `labrun run` prints. Raises
    ProtocolFault, or FolderFault, JournalFault or OSError where no folder can be made.
    """
    given = {**(params or {}), **more_params}
    checked = checked_protocol(protocol, lab, bind, given, needed=True)
    options = RunOptions(yes=yes, answers=dict(answers or {}), live_figures=True)
    if progress:
        from ..progress.plain import PlainWatch

        options.say = print
        options.watchers = [lambda run, control: PlainWatch()]
    return LiveRun(
        checked, Path(runs), {name: str(value) for name, value in given.items()}, options
    )


def run(protocol: PathLike, **options: Any) -> RecordedRun:
    """Check a protocol, run it to its end, and return what is in its folder; options as `start`.

    A run that fails or is aborted is returned, too: look at its `fate`.
    """
    return start(protocol, **options).wait()


async def arun(protocol: PathLike, **options: Any) -> RecordedRun:
    """The same as a coroutine: the loop goes on meanwhile. Being cancelled aborts the run."""
    return await start(protocol, **options).ended()
