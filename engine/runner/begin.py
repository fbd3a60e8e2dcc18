"""Start a run: a new one, or one continued from its journal."""

import platform
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from ... import __version__
from ...schemas import journal as j
from ..check import Checked
from ..control.control import Control
from ..dispatch.served_lab import serve_home
from ..journal.encode import encode
from ..journal.history import History
from ..journal.journal import Journal
from ..run.clock import RunClock
from ..run.copies import keep_used
from ..run.folder import hashes, keep_inputs, protocol_file
from ..run.questions import Questions
from ..run.run import Listener, Run

Watcher = Callable[[Run, Control], Listener]


@dataclass(slots=True)
class RunOptions:
    """What the person who started a run wants besides its protocol; `say` tells them what it waits for.

    `by`: who has asked for a resume. `wait_s`: how long devices that others hold are waited for.
    """

    yes: bool = False
    by: str = ""
    answers: dict[str, str] = field(default_factory=dict)
    watchers: list[Watcher] = field(default_factory=list)
    live_figures: bool = False
    wait_s: float = 0.0
    say: Callable[[str], None] = lambda text: None


def keep(folder: Path, checked: Checked, given: dict[str, str]) -> None:
    """Copy what the run uses into its folder."""
    assert checked.source is not None and checked.lab is not None and checked.survey is not None
    lab = checked.lab
    used = {device.contract for device in lab.lab.devices.values()}
    used |= {role.contract.type for role in checked.roles.values()}
    keep_inputs(
        folder, checked.source.text, checked.source.name, lab.lab,
        lab.path.parent if lab.path else None,
        {name: contract for name, contract in lab.contracts.items() if name in used},
        {
            "file": checked.source.name,
            "params": given,
            "roles": {name: role.device for name, role in checked.roles.items()},
            **({"served_as": serve_home(lab).name} if lab.path else {}),
        },
    )  # fmt: skip
    keep_used(folder, protocol_file(folder).name, checked.survey)


def new_run(
    folder: Path, checked: Checked, options: RunOptions, *, journal: Journal | None = None,
    clock: RunClock | None = None,
) -> Run:  # fmt: skip
    """A new run, with its journal open."""
    assert checked.protocol is not None
    journal = journal or Journal(folder / "journal.jsonl")
    run = _run(folder, checked, options, journal, History())
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
    folder: Path,
    checked: Checked,
    options: RunOptions,
    journal: Journal,
    history: History,
    torn: int,
) -> Run:
    """A run continued from its journal."""
    run = _run(folder, checked, options, journal, history)
    count = history.resumes + 1
    run.record(
        j.Resumed(
            count=count, labrun=__version__, torn=torn, by=options.by,
            put_back=journal.put_back or None,
        )
    )  # fmt: skip
    return run


def _run(
    folder: Path, checked: Checked, options: RunOptions, journal: Journal, history: History
) -> Run:
    assert checked.protocol is not None and checked.lab is not None
    # A renamed folder is the same run: its goals keep their ids.
    name = history.started.run if history.started else folder.name
    about = {
        "id": name,
        "name": checked.protocol.name,
        "simulated": checked.lab.lab.simulated,
        "started": history.started.began if history.started else _now(),
    }
    return Run(
        id=name, folder=folder, journal=journal, history=history, roles=checked.roles,
        params=checked.params, about=about,
        questions=Questions(yes=options.yes, answers=options.answers),
    )  # fmt: skip


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
