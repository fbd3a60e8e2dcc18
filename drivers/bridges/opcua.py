"""OPC UA servers: `get` and `set` are variables, `call` methods, by their names or node ids.

Names are browse names from Objects on, `DeviceSet/Oven/Temperature/CurrentValue`, as OPC UA LADS
(OPC 30500-1) has them; the number of a namespace may stand before one, `2:Oven`, and may change with the
server's next start. `labrun new device NAME --from opc.tcp://host:port` writes the actions of a server.
"""

import contextlib
from typing import Any, ClassVar

from ...schemas.contract import Action
from ..driver import ActionFailed
from .bridge import Values
from .library import Library, Refused, ServerConfig
from .opcua_nodes import arguments, connected, native, node_at, variant
from .sila2 import by_plain_name, plain_name

REFUSALS = (
    "BadArgumentsMissing", "BadAttributeIdInvalid", "BadInvalidArgument", "BadInvalidState",
    "BadMethodInvalid", "BadNodeIdInvalid", "BadNodeIdUnknown", "BadNotExecutable", "BadNotSupported",
    "BadNotWritable", "BadOutOfRange", "BadTooManyArguments", "BadTypeMismatch",
    "BadUserAccessDenied", "BadWriteNotSupported",
)  # fmt: skip
"""Status codes (OPC 10000-4) by which the server has looked at a request, and has not done it."""
LOST = ("Connection", "Session", "SecureChannel", "Communication", "Shutdown", "ServerHalted")


class OpcuaConfig(ServerConfig):
    """The config of `driver: opcua`; `security` is the library's string of policy, mode and files."""

    schemes = ("opc.tcp://", "opc.wss://")

    user: str | None = None
    password: str | None = None
    security: str | None = None


class Opcua(Library):
    """Implements whichever contract its lab says or names."""

    extra: ClassVar[str | None] = "opcua"
    config_model: ClassVar = OpcuaConfig
    library: ClassVar = "OPC UA"
    on_loop = True

    async def connect(self) -> Any:
        said: OpcuaConfig = self.config
        client = await connected(
            said.url, self.timeout_s(None), said.user, said.password, said.security
        )
        self._nodes: dict[str, Any] = {}
        try:
            if any("at" in one for act in said.actions.values() for one in act.returns.values()):
                # What the server's structures have in them.
                await client.load_data_type_definitions()
            server = client.get_node("i=2261")  # Server_ServerStatus_BuildInfo_ProductName
            self.versions = {"server": str(await server.read_value())}
        except BaseException:  # a cancel as well
            with contextlib.suppress(Exception):  # it may be gone already
                await self.disconnect(client)
            raise
        return client

    async def disconnect(self, instrument: Any) -> None:
        await instrument.disconnect()

    async def get(self, path: str) -> Any:
        return native(await (await self._node(path)).read_value())

    async def set(self, path: str, value: Any) -> None:
        node = await self._node(path)
        await node.write_value(variant(value, await node.read_data_type_as_variant_type()))

    async def call(self, path: str, values: Values, action: Action) -> Any:
        method = await self._node(path)
        owner = await self._node(path.rpartition("/")[0]) if "/" in path else None
        owner = owner or await method.get_parent()
        given = {plain_name(name): value for name, value in values.items()}
        inputs = await arguments(self._instrument, method, "InputArguments")
        lacking = [name for name, _, _ in inputs if plain_name(name) not in given]
        if lacking:
            raise Refused(f"the method needs {', '.join(lacking)}")
        put = [variant(given[plain_name(name)], kind) for name, kind, _ in inputs]
        found = await owner.call_method(method.nodeid, *put)
        outputs = await arguments(self._instrument, method, "OutputArguments")
        told = found if len(outputs) > 1 else [found]
        named = {name: native(value) for (name, _, _), value in zip(outputs, told, strict=False)}
        return by_plain_name(named, action.returns.get("properties", {}))

    async def _node(self, path: str) -> Any:
        """The node of a path, or of an id as `ns=2;s=Oven`; raises Refused."""
        if path not in self._nodes:
            self._nodes[path] = await node_at(self._instrument, path)
        return self._nodes[path]

    def meaning(self, path: str, fault: Exception, action: Action) -> Exception:
        kind = type(fault).__name__  # the library has a class for each status
        if isinstance(fault, (Refused, OSError)) or "Timeout" in kind:
            return fault
        if kind in REFUSALS:
            return Refused(f"the server refused it: {fault} ({kind})")
        if any(one in kind for one in LOST):
            return ConnectionError(f"{kind}: {fault}")
        words = f"{self.place.device} was asked for {path}: {fault} ({kind})"
        return ActionFailed("Failed", words, "unknown")
