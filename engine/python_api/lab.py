"""`labrun.lab`: the devices of a lab, one action at a time, as `labrun call` does them."""

import asyncio
import functools
import inspect
import secrets
import shutil
import sys
import tempfile
import threading
import weakref
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from typing import Any, get_args

from ...schemas.contract import Danger
from ..commands.call import Called, do_action, find_action, fitted, role_of, used_at
from ..commands.options import WrongUsage
from ..dispatch.connect import Connections, NotReached, connect
from ..journal.encode import with_units
from ..lab.lab import LoadedLab, load_lab
from ..language.arguments import ArgumentFaults
from ..run.names import FileFault
from .bar import in_a_notebook
from .checking import PathLike
from .faults import ActionFailed, NoSuch, Refused
from .problems import Problems
from .threads import Work, result

CLOSE_S = 30.0
"""How long leases and servers are given back before a program ends all the same."""
NOT_OURS = ("Stopped", "Rejected", "Lost")
"""Errors after which a device is reached and leased anew, once a person has read them and goes on."""


class Lab:
    """The devices of a lab by name: `lab.gantry.move_to(x="10 mm")`, or `lab["gantry"]`.

    A device is reached and leased at its first action; `close`, the end of `with` or of the program
    gives it back.
    """

    def __init__(self, loaded: LoadedLab, confirmed: Collection[str]) -> None:
        self._loaded, self._confirmed = loaded, confirmed
        self._session = _Session(loaded)
        self.close = weakref.finalize(self, self._session.close)

    def __getitem__(self, device: str) -> "Device":
        if device not in self._loaded.lab.devices:
            raise Refused(f"no device {device!r} in this lab; it has {', '.join(dir(self))}")
        return Device(self, device)

    def __getattr__(self, device: str) -> "Device":
        # What Python and IPython look for; a device of such a name is lab["_name"].
        if device.startswith("_"):
            raise AttributeError(device)
        try:
            return self[device]
        except Refused as fault:
            raise NoSuch(str(fault)) from None

    def __dir__(self) -> list[str]:
        return list(self._loaded.lab.devices)

    def __enter__(self) -> "Lab":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<labrun lab {self._loaded.lab.name}: {', '.join(dir(self))}>"


class Device:
    """A device; its attributes are the actions of its contract."""

    def __init__(self, lab: Lab, name: str) -> None:
        self._lab, self._name = lab, name
        self._contract = role_of(lab._loaded, name).contract

    def __getattr__(self, action: str) -> "Callable[..., dict[str, Any]]":
        if action.startswith("__"):
            raise AttributeError(action)
        try:
            found = find_action(self._lab._loaded, self._name, action)
        except WrongUsage as fault:
            raise NoSuch(str(fault)) from None

        def call(*unnamed: Any, **arguments: Any) -> dict[str, Any]:
            if unnamed:
                named = ", ".join(found.param_schemas())
                taken = f"its values by name: {named}" if named else "no values"
                raise Refused(f"{self._name}.{action} takes {taken}")
            return _call(self._lab, self._name, action, arguments)

        call.__name__, call.__doc__ = action, found.summary
        keyword = inspect.Parameter.KEYWORD_ONLY
        needed = found.required()
        signed = [
            inspect.Parameter(n, keyword, default=inspect.Parameter.empty if n in needed else None)
            for n in found.param_schemas()
        ]
        call.__signature__ = inspect.Signature(signed)  # type: ignore[attr-defined]
        return call

    def __dir__(self) -> list[str]:
        return list(self._contract.actions)

    def __repr__(self) -> str:
        return f"<{self._contract.type} {self._name}: {', '.join(dir(self))}>"


def lab(file: PathLike | None = None, *, yes: bool | Collection[Danger] = False) -> Lab:
    """The devices of a lab's file, of the simulated lab if None; as a `with` block it is closed after it.

    An action takes texts with units, numbers in its contract's units, or quantities, and returns what
    the device did, with units. Raises Refused before anything is sent, ActionFailed after that; Ctrl-C
    cancels the action. yes: confirm every dangerous action (`labrun call --yes`), or those of some kinds,
    such as ["motion"]; of others a person is asked each time, and without a person they are refused.
    """
    loaded, problems = load_lab(None if file is None else Path(file))
    if loaded is None or any(problem.severity == "error" for problem in problems):
        raise Refused(str(Problems(problems)))
    return Lab(loaded, get_args(Danger) if yes is True else yes or ())


def _call(lab: Lab, device: str, name: str, given: dict[str, Any]) -> dict[str, Any]:
    label = f"{device}.{name}"
    try:
        arguments = fitted(lab._loaded, device, name, given)
    except ArgumentFaults as fault:
        raise Refused(str(fault)) from None
    if not lab.close.alive:
        raise Refused("this lab is closed; `labrun.lab` opens it again")
    action = find_action(lab._loaded, device, name)
    danger = action.danger
    if danger and danger not in lab._confirmed and not _asked(label, danger):
        raise Refused(
            f"{label} is dangerous ({danger}) and nobody has confirmed it; "
            f'`labrun.lab(..., yes=["{danger}"])` confirms it'
        )
    called = lab._session.call(device, name, arguments)
    if called.cancelled_by:
        raise KeyboardInterrupt("\n".join(called.words))
    if not called.ok:
        raise ActionFailed("\n".join(called.words))
    return with_units(called.outcome.result or {}, action.returns)


def _asked(label: str, danger: str) -> bool:
    if not sys.stdin.isatty() and not in_a_notebook():
        return False
    with suppress(EOFError, NotImplementedError):  # a notebook that is run without a person
        said = input(f"{label} is dangerous ({danger}). Do it? [y/N] ")
        return said.strip().lower() in ("y", "yes")
    return False


class _Session:
    """Connections and leases, in a loop of their own, from the first action to `close`."""

    def __init__(self, lab: LoadedLab) -> None:
        self._lab, self._owner, self._count = lab, f"call-{secrets.token_hex(4)}", 0
        self._folder = tempfile.mkdtemp(prefix="labrun-call-")
        self._has_picture = False
        self._connected: dict[str, Connections] = {}
        self._cancels: dict[str, Callable[[str], object]] = {}
        self._loop = asyncio.new_event_loop()
        self._thread = Work("lab", self._loop.run_forever)

    def call(self, device: str, name: str, arguments: dict[str, Any]) -> Called:
        """One action, to its end; Ctrl-C cancels it, and its end is waited for."""
        done = asyncio.run_coroutine_threadsafe(self._call(device, name, arguments), self._loop)

        def interrupted() -> None:
            if not self.cancel(device, "Ctrl-C"):  # being reached: nothing has been sent
                done.cancel()
                raise KeyboardInterrupt

        return result(done, interrupted=interrupted)

    def cancel(self, device: str, why: str) -> bool:
        """Cancel what a device does; False if it does nothing."""
        cancel = self._cancels.get(device)
        if cancel is not None:
            self._loop.call_soon_threadsafe(cancel, why)
        return cancel is not None

    async def _call(self, device: str, name: str, arguments: dict[str, Any]) -> Called:
        role = role_of(self._lab, device)
        self._count += 1
        try:
            if device not in self._connected:
                self._connected[device] = await connect(
                    {device: role}, self._lab, Path(self._folder), self._owner, say=print,
                    found=used_at(self._lab, device),
                )  # fmt: skip
            called = await do_action(
                self._connected[device].clients[device], role.contract, device, name, arguments,
                f"{self._owner}/{name}/{self._count}", hear=functools.partial(self._hear, device), say=print,
            )  # fmt: skip
        except NotReached as fault:
            raise Refused(f"{fault}. Nothing was sent.") from None
        except FileFault as fault:
            raise Refused(str(fault)) from None
        error = called.outcome.error
        self._has_picture |= error is not None and self._folder in error.message
        if error is not None and error.name in NOT_OURS:
            await self._connected.pop(device).close()
        return called

    def _hear(self, device: str, cancel: Callable[[str], object]) -> Callable[[], None]:
        self._cancels[device] = cancel

        def forget() -> None:
            self._cancels.pop(device, None)

        return forget

    def close(self) -> None:
        """Give leases back, and end the servers that were started."""

        async def close() -> None:
            for connections in self._connected.values():
                await connections.close()

        if threading.current_thread() is self._thread:  # forgotten, and collected while it ran
            Work("close lab", self.close)
            return
        with suppress(TimeoutError):
            result(asyncio.run_coroutine_threadsafe(close(), self._loop), CLOSE_S)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
        if not self._has_picture:
            shutil.rmtree(self._folder, ignore_errors=True)
