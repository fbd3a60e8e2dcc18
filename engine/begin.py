"""A run as it begins: new, or with a journal to go on from."""

import platform
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from .. import __version__
from ..schemas import journal as j
from .check import Checked
from .clock import RunClock
from .control import Control
from .encode import encode
from .history import History
from .journal import Journal
from .questions import Questions
from .run import Listener, Run
from .run_folder import hashes

Watcher = Callable[[Run, Control], Listener]


@dataclass(slots=True)
class Wishes:
    """What the person who started a run wants beside its protocol."""

    yes: bool = False
    answers: dict[str, str] = field(default_factory=dict)
    watchers: list[Watcher] = field(default_factory=list)
    live_figures: bool = False


def new_run(
    folder: Path, checked: Checked, wishes: Wishes, *, journal: Journal | None = None,
    clock: RunClock | None = None,
) -> Run:  # fmt: skip
    """A run at its very beginning, its journal open."""
    assert checked.protocol is not None
    journal = journal or Journal(folder / "journal.jsonl")
    run = _run(folder, checked, wishes, journal, History())
    run.clock = clock or run.clock
    run.record(
        j.Started(
            run=run.id, protocol=checked.protocol.name, labrun=__version__,
            python=platform.python_version(), began=run.about["started"], params=encode(checked.params),
            roles={name: role.device for name, role in checked.roles.items()},
            files=hashes(folder),
        )
    )  # fmt: skip
    return run


def old_run(
    folder: Path, checked: Checked, wishes: Wishes, journal: Journal, history: History, torn: int
) -> Run:
    """A run that goes on from its journal."""
    if history.finished is not None:
        history.spend()
    history.resumes += 1
    run = _run(folder, checked, wishes, journal, history)
    run.holes = history.holes
    history.resumed_n = run.record(
        j.Resumed(count=history.resumes, labrun=__version__, torn=torn)
    )  # fmt: skip
    return run


def _run(folder: Path, checked: Checked, wishes: Wishes, journal: Journal, history: History) -> Run:
    assert checked.protocol is not None and checked.lab is not None
    about = {
        "id": folder.name,
        "name": checked.protocol.name,
        "simulated": checked.lab.lab.simulated,
        "started": history.started.began if history.started else _now(),
    }
    return Run(
        id=folder.name, folder=folder, journal=journal, history=history, roles=checked.roles,
        params=checked.params, about=about,
        questions=Questions(yes=wishes.yes, answers=wishes.answers),
    )  # fmt: skip


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
