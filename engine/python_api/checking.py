"""`labrun.check` and `labrun.rehearse`."""

import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..check import Checked, check_file
from ..problems.print import print_problems

PathLike = str | os.PathLike[str]


class ProtocolFault(ValueError):
    """A protocol with errors; the text is what `labrun check` prints, `problems` are its parts."""

    def __init__(self, checked: Checked) -> None:
        text = io.StringIO()
        print_problems(checked.problems, file=text)
        super().__init__(text.getvalue())
        self.problems = checked.problems


def check(
    protocol: PathLike,
    *,
    lab: PathLike | None = None,
    bind: Mapping[str, str] | None = None,
    params: Mapping[str, Any] | None = None,
    **more_params: Any,
) -> Checked:
    """Check a protocol file as `labrun check` does: `ok`, and `problems` with line and column.

    lab: the lab's file, `lab.yaml` beside or above if None. bind: role -> device. Parameters are
    texts with units, such as pitch="0.5 mm", or plain values; those whose name is taken here
    (`lab`, `params`) go into `params`. A parameter without a value is a warning.
    """
    return checked_protocol(protocol, lab, bind, {**(params or {}), **more_params}, needed=False)


def rehearse(
    protocol: PathLike,
    *,
    lab: PathLike | None = None,
    bind: Mapping[str, str] | None = None,
    fail: Mapping[str, float] | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    **more_params: Any,
) -> dict[str, Any]:
    """Play a protocol on simulated devices and a virtual clock; the figures of `labrun rehearse --json`.

    fail: {"libs.measure": 0.05} lets an action fail with that probability. Raises ProtocolFault, and
    ValueError for a `fail` that cannot be.
    """
    from ..commands.rehearse import ordered
    from ..rehearse.rehearse import Rehearsal

    checked = checked_protocol(protocol, lab, bind, {**(params or {}), **more_params}, needed=True)
    faults = ordered([f"{name}:{chance}" for name, chance in (fail or {}).items()], checked)
    rehearsal = Rehearsal(checked, faults, seed, lambda at_s, goals: None)
    return rehearsal.play().as_dict()


def checked_protocol(
    protocol: PathLike, lab: PathLike | None, bind: Mapping[str, str] | None,
    params: Mapping[str, Any], *, needed: bool,
) -> Checked:  # fmt: skip
    """The checked protocol; with `needed`, one that can be run: raises ProtocolFault."""
    checked = check_file(
        Path(protocol),
        lab=None if lab is None else Path(lab),
        bind=bind,
        params=params,
        needed=needed,
    )
    if needed and not checked.ok:
        raise ProtocolFault(checked)
    return checked
