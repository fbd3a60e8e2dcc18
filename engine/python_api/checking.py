"""`labrun.check` and `labrun.rehearse`."""

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ..check import Checked, check_file, check_text
from .faults import ProtocolFault, Refused
from .problems import Check, Problems
from .protocol import Protocol, plain
from .threads import Work, result

PathLike = str | os.PathLike[str]
ProtocolLike = PathLike | Protocol


class Rehearsed(dict[str, Any]):
    """The figures of a rehearsal, by name; as text what `labrun rehearse` prints."""

    def __init__(self, figures: Mapping[str, Any], lines: Iterable[str]) -> None:
        super().__init__(figures)
        self._text = "\n".join(lines)

    def __repr__(self) -> str:
        return self._text


def check(
    protocol: ProtocolLike,
    *,
    lab: PathLike | None = None,
    bind: Mapping[str, str] | None = None,
    params: Mapping[str, Any] | None = None,
    **more_params: Any,
) -> Check:
    """Check a protocol as `labrun check` does: `ok`, and `problems` with line and column.

    protocol: a file, or a Protocol built in Python. lab: the lab's file, the simulated lab if None.
    bind: role -> device. Parameters are texts with units, such as pitch="0.5 mm", quantities or plain values;
    those whose name is taken here (`lab`, `params`) go into `params`. A parameter without a value is
    a warning.
    """
    given = {**(params or {}), **more_params}
    checked = checked_protocol(protocol, lab, bind, given, needed=False)
    return Check(Problems(checked.problems, checked.source), ok=checked.ok)


def rehearse(
    protocol: ProtocolLike,
    *,
    lab: PathLike | None = None,
    bind: Mapping[str, str] | None = None,
    fail: Mapping[str, float] | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    **more_params: Any,
) -> Rehearsed:
    """Play a protocol on simulated devices and a virtual clock; the figures of `labrun rehearse --json`.

    They show themselves as `labrun rehearse` does.

    fail: {"libs.measure": 0.05} lets an action fail with that probability. Raises ProtocolFault, and
    Refused for a `fail` that cannot be, or a device that cannot be rehearsed.
    """
    from ..commands.options import WrongUsage
    from ..commands.rehearse import ordered
    from ..rehearse.rehearse import NoRehearsal, Rehearsal
    from ..rehearse.table import lines

    checked = checked_protocol(protocol, lab, bind, {**(params or {}), **more_params}, needed=True)
    try:
        faults = ordered([f"{name}:{chance}" for name, chance in (fail or {}).items()], checked)
        # A virtual clock needs a loop of its own, and a notebook has one running here.
        rehearsal = Rehearsal(checked, faults, seed)
        totals = result(Work("rehearsal", rehearsal.play).ended)
        return Rehearsed(totals.as_dict(), lines(totals, rehearsal.real_s))
    except (NoRehearsal, WrongUsage) as fault:
        raise Refused(str(fault)) from None


def checked_protocol(
    protocol: ProtocolLike, lab: PathLike | None, bind: Mapping[str, str] | None,
    params: Mapping[str, Any], *, needed: bool,
) -> Checked:  # fmt: skip
    """The checked protocol; with `needed`, one that can be run: raises ProtocolFault."""
    plainly = {name: plain(value) for name, value in params.items()}
    given: Any = {"lab": None if lab is None else Path(lab), "bind": bind, "params": plainly}
    if isinstance(protocol, Protocol):
        name = f"{protocol.name} (built in Python)"
        checked = check_text(protocol.dump(), name, needed=needed, **given)
    else:
        checked = check_file(Path(protocol), needed=needed, **given)
    if needed and not checked.ok:
        raise ProtocolFault(checked.problems, checked.source)
    return checked
