"""SiLA 2 servers: `get` is a property (`Shaking.Speed`), `call` a command (`Shaking.SetSpeed`).

SiLA 2 Part A 1.1. What an observable command returns is asked for by its execution's UUID until it
is there, over a broken connection, too. `labrun new device NAME --from sila2://host:port` writes the
actions of a server's features.
"""

import os
import re
import time
from pathlib import Path
from typing import Any, ClassVar

from ...schemas.contract import Action
from ...system.extras import needed
from ..driver import ActionFailed
from .bridge import Values
from .library import Library, Refused, ServerConfig
from .resource import read_resource

REFUSALS = ("ValidationError", "CommandExecutionNotAccepted", "InvalidMetadata")
LOOK_S, LOOK_AT_MOST_S = 0.05, 0.5


class Sila2Config(ServerConfig):
    """The config of `driver: sila2`: `url: sila2://10.0.0.9:50052`, and how it is encrypted."""

    schemes = ("sila2://",)

    insecure: bool = False
    root_certs: str | None = None


class Sila2(Library):
    """Implements whichever contract its lab says or names."""

    extra: ClassVar[str | None] = "sila2"
    config_model: ClassVar = Sila2Config
    library: ClassVar = "SiLA"
    stops_beside = True

    def connect(self) -> Any:
        said: Sila2Config = self.config
        client = connected(said.url, insecure=said.insecure, root_certs=said.root_certs)
        service = client.SiLAService
        names = ("ServerName", "ServerType", "ServerVersion", "ServerUUID")
        self.versions = {name: str(getattr(service, name).get()) for name in names}
        return client

    def disconnect(self, instrument: Any) -> None:
        instrument.close()

    def get(self, path: str) -> Any:
        return native(self._of(path).get())

    def set(self, path: str, value: Any) -> None:
        raise Refused("a property of SiLA is never set; a command sets it: `call: Feature.Command`")

    def call(self, path: str, values: Values, action: Action) -> Any:
        command, client = self._of(path), self._instrument
        inner = command._wrapped_command
        params = {plain_name(one._identifier): one._identifier for one in inner.parameters}
        given = {params.get(plain_name(name), name): value for name, value in values.items()}
        answer = command(**given)
        if hasattr(answer, "get_responses"):
            answer = self._finished(answer, client)
        return by_plain_name(native(answer), action.returns.get("properties", {}))

    def _of(self, path: str) -> Any:
        feature, _, name = path.partition(".")
        found = getattr(getattr(self._instrument, feature, None), name, None)
        if found is None:
            known = ", ".join(self._instrument._features)
            raise ActionFailed("Rejected", f"the server has no {path}; its features: {known}", "no")
        return found

    def _finished(self, execution: Any, client: Any) -> Any:
        """The responses of an observable command; its timeout is the action's."""
        pause_s = LOOK_S
        while True:
            try:
                return execution.get_responses()
            except Exception as fault:  # as in `meaning`
                lost = type(fault).__name__ in (
                    "CommandExecutionNotFinished",
                    "SilaConnectionError",
                )
                if not lost or self._instrument is not client:  # nobody waits for it any more
                    raise
            time.sleep(pause_s)
            pause_s = min(2 * pause_s, LOOK_AT_MOST_S)

    def meaning(self, path: str, fault: Exception, action: Action) -> Exception:
        if isinstance(fault, (Refused, ActionFailed)):
            return fault
        # By name: the client makes classes of the features.
        kind, name = type(fault).__name__, getattr(fault, "identifier", None)
        words = f"{self.place.device} was asked for {path}: {fault}"
        if kind in REFUSALS:
            return Refused(str(fault))
        if kind == "SilaConnectionError":
            return ConnectionError(words)
        if name in action.errors:
            return ActionFailed(name, words)
        return ActionFailed("Failed", words, "unknown")


def connected(url: str, *, insecure: bool, root_certs: str | None) -> Any:
    """A client that has read what the server's features are; raises OSError."""
    os.environ.setdefault("GRPC_VERBOSITY", "NONE")  # it would write to the terminal by itself
    library = needed("sila2.client")
    at = read_resource(url.removeprefix("sila2://"))
    certs = Path(root_certs).expanduser().read_bytes() if root_certs is not None else None
    return library.SilaClient(at.host, at.port, insecure=insecure, root_certs=certs)


def native(found: Any) -> Any:
    """SiLA's structures as data."""
    if hasattr(found, "_asdict"):
        return {name: native(value) for name, value in found._asdict().items()}
    return [native(one) for one in found] if isinstance(found, list) else found


def by_plain_name(told: Values, returns: Values) -> Values:
    """What was answered, and each of it by the name that the contract has for it, too."""
    named = {plain_name(name): value for name, value in told.items()}
    wanted = {name: plain_name(name) for name in returns}
    return told | {name: named[plain] for name, plain in wanted.items() if plain in named}


def plain_name(name: str) -> str:
    """`TargetSpeed`, `Target Speed` and `target_speed` are the same."""
    return re.sub(r"[\W_]", "", name).lower()
