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

    def ask(self, verb: Verb, by: str) -> str:
        """Do what a person or a signal requests; returns a sentence."""
        said = {"pause": self._pause, "continue": self._continue, "abort": self._abort}[verb](by)
        self.wake()
        return said

    def _pause(self, by: str) -> str:
        if self.aborted_by:
            return "the run is being aborted"
        if self.paused:
            return "the run is already paused"
        self.paused = True
        self.run.clock.pause()
        self._note("pause", by)
        return "paused: running actions finish, then the run holds"

    def _continue(self, by: str) -> str:
        if not self.paused:
            return "the run is not paused"
        self.paused = False
        self.run.requests.pause = ""
        self.run.clock.go_on()
        self.run.requests.again()
        self._note("continue", by)
        return "the run continues"

    def _abort(self, by: str) -> str:
        self.run.requests.pause = ""
        if self.paused:
            self.paused = False
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
