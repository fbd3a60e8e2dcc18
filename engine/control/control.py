"""Pause, continue, abort: what people and signals request of a live run."""

from collections.abc import Callable
from typing import Literal

from ...schemas.journal import Control as ControlRecord
from ..run.run import Run

Verb = Literal["pause", "continue", "abort"]


class Control:
    """What is requested of the run now. A second abort is immediate."""

    def __init__(self, run: Run, wake: Callable[[], None]) -> None:
        self.run = run
        self.wake = wake
        self.paused = False
        self.aborted_by = ""
        self.now = False
        self.change_due: Callable[[bool], bool] = lambda busy: False
        """Whether a new tree is to be planted, for a change of the protocol: asked in each round."""
        self._held = False
        """Paused for a change alone: nobody else has asked for it since."""

    def ask(self, verb: Verb, by: str) -> str:
        """Do what a person or a signal requests; returns a sentence."""
        said = {"pause": self._pause, "continue": self._continue, "abort": self._abort}[verb](by)
        self.wake()
        return said

    def _pause(self, by: str) -> str:
        if self.aborted_by:
            return "the run is being aborted"
        if self.paused:
            self._held = False
            return "the run is already paused"
        self.paused = True
        self.run.clock.pause()
        self._note("pause", by)
        return "paused: running actions finish, then the run holds"

    def _continue(self, by: str) -> str:
        if not self.paused:
            return "the run is not paused"
        self.paused = self._held = False
        self.run.requests.pause = ""
        self.run.clock.go_on()
        self.run.requests.again()
        self._note("continue", by)
        return "the run continues"

    def hold(self, by: str) -> None:
        """Let what runs end, and then nothing begin, until `let_go`; a pause of anybody's outlasts it."""
        if not self.paused and not self.aborted_by:
            self._pause(by)
            self._held = True
        self.wake()

    def let_go(self, by: str) -> None:
        """Go on after `hold`, unless somebody or something else has paused the run."""
        if self._held and not self.run.requests.pause:
            self._continue(by)
        self._held = False
        self.wake()

    def _abort(self, by: str) -> str:
        self.run.requests.pause = ""
        if self.paused:
            self.paused = self._held = False
            self.run.clock.go_on()
        if self.aborted_by:
            self.now = True
            self._note("abort-now", by)
            return "stopping at once; devices go to their safe state"
        self.aborted_by = by
        self._note("abort", by)
        return "aborting: goals are cancelled, then `finally`, then the safe state"

    def _note(self, verb: Literal["pause", "continue", "abort", "abort-now"], by: str) -> None:
        self.run.record(ControlRecord(verb=verb, by=by))
        self.run.tell("control", state=verb, text=by)
