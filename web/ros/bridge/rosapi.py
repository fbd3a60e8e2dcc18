"""`rosapi`: lists names, types and fields, for clients that look them up first.

Services of rosapi (rosbridge_suite), with the fields that roslib and roslibpy read.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from ..interfaces.kinds import Field, Message, ServiceKind, same_type
from ..offers.offer import Offers, Refused, Service, Values

PACKAGE = "rosapi_msgs"
NODE = "/labrun"
TEXT, TEXTS = ("string", ""), ("string", "[]")


class RosapiService(Service):
    """One look-up."""

    def __init__(self, name: str, offers: Offers) -> None:
        asks, gives, self._look = ROSAPI[name]
        own = "".join(word.capitalize() for word in name.split("_"))
        self.name = f"/rosapi/{name}"
        self.kind = ServiceKind(
            PACKAGE, own, _message(f"{own}_Request", dict.fromkeys(asks, TEXT)),
            _message(f"{own}_Response", gives),
        )  # fmt: skip
        self._asks = asks
        self._offers = offers

    async def answer(self, values: Values) -> Values:
        """Every field; raises Refused."""
        given = values if isinstance(values, dict) else {}
        asked = [given.get(name, "") for name in self._asks]
        for name, value in zip(self._asks, asked, strict=True):
            if not isinstance(value, str):
                raise Refused(f"{self.name}: {name} must be a string")
        return self._look(self._offers, *asked)


def _message(name: str, fields: dict[str, tuple[str, str]]) -> Message:
    made = [Field(name, type, name, array=array) for name, (type, array) in fields.items()]
    return Message(PACKAGE, name, tuple(made))


# --- lists


def _topics(offers: Offers) -> Values:
    found = sorted(offers.topics.items())
    return {"topics": [name for name, _ in found], "types": [topic.kind.type for _, topic in found]}


def _services(offers: Offers) -> Values:
    return {"services": sorted([*offers.services, *(f"/rosapi/{name}" for name in ROSAPI)])}


def _topics_for_type(offers: Offers, type: str) -> Values:
    return {"topics": [n for n, t in sorted(offers.topics.items()) if same_type(type, t.kind.type)]}


def _services_for_type(offers: Offers, type: str) -> Values:
    found = sorted(_all_services(offers).items())
    return {"services": [name for name, one in found if same_type(type, one.kind.type)]}


def _topic_type(offers: Offers, topic: str) -> Values:
    return _type_in(offers.topics, topic)


def _service_type(offers: Offers, service: str) -> Values:
    return _type_in(_all_services(offers), service)


def _action_servers(offers: Offers) -> Values:
    return {"action_servers": sorted(offers.actions)}


def _action_type(offers: Offers, action: str) -> Values:
    return _type_in(offers.actions, action)


def _type_in(offered: Mapping[str, Any], name: str) -> Values:
    found = offered.get(full(name))
    return {"type": found.kind.type if found is not None else ""}


def _interfaces(offers: Offers) -> Values:
    kinds = [*offers.actions.values(), *offers.services.values(), *offers.topics.values()]
    return {"interfaces": sorted({one.kind.type for one in kinds})}


def _raw_types(offers: Offers) -> Values:
    from ..interfaces.render import message_text

    full = [message_text(topic.kind) for _, topic in sorted(offers.topics.items())]
    return {**_topics(offers), "typedefs_full_text": full}


def _nodes(offers: Offers) -> Values:
    return {"nodes": [NODE]}


def _node_details(offers: Offers, node: str) -> Values:
    if full(node) != NODE:
        return {"subscribing": [], "publishing": [], "services": []}
    return {
        "subscribing": [], "publishing": sorted(offers.topics), "services": _services(offers)["services"]
    }  # fmt: skip


def _publishers(offers: Offers, topic: str) -> Values:
    return {"publishers": [NODE] if full(topic) in offers.topics else []}


def _subscribers(offers: Offers, topic: str) -> Values:
    return {"subscribers": []}


def _service_node(offers: Offers, service: str) -> Values:
    return {"node": NODE if _service_type(offers, service)["type"] else ""}


def _get_time(offers: Offers) -> Values:
    now = time.time_ns()
    sec, nanosec = divmod(now, 10**9)
    # ROS 2 has sec and nanosec; roslibpy reads the names of ROS 1.
    return {"time": {"sec": sec, "nanosec": nanosec, "secs": sec, "nsecs": nanosec}}


def _no_params(offers: Offers) -> Values:
    return {"names": []}


def _ros_version(offers: Offers) -> Values:
    return {"version": 2, "distro": "labrun"}


# --- fields


def _message_details(offers: Offers, type: str) -> Values:
    for topic in offers.topics.values():
        for message in (topic.kind, *topic.kind.nested()):
            if same_type(type, message.type):
                return _typedefs(message)
    return {"typedefs": []}


def _of_service(part: int) -> Callable[..., Values]:
    return lambda offers, type: _part(_all_services(offers), type, part)


def _of_action(part: int) -> Callable[..., Values]:
    return lambda offers, type: _part(offers.actions, type, part)


def _part(offered: Mapping[str, Any], type: str, part: int) -> Values:
    for one in offered.values():
        if same_type(type, one.kind.type):
            return _typedefs(one.kind.parts()[part])
    return {"typedefs": []}


def _typedefs(message: Message) -> Values:
    """The message and those within it; array length: -1 for one value, 0 for any number, else fixed."""
    return {"typedefs": [_typedef(one) for one in _unique(message)]}


def _unique(message: Message) -> Iterator[Message]:
    yield from {one.type: one for one in (message, *message.nested())}.values()


def _typedef(message: Message) -> Values:
    constants = [pair for field in message.fields for pair in field.constants]
    return {
        "type": f"{message.package}/{message.name}",
        "fieldnames": [field.name for field in message.fields],
        "fieldtypes": [_type_of(field) for field in message.fields],
        "fieldarraylen": [_length(field) for field in message.fields],
        "examples": [
            "[]" if field.array else EXAMPLES.get(field.type, "{}") for field in message.fields
        ],
        "constnames": [name for name, _ in constants],
        "constvalues": [str(value) for _, value in constants],
    }


EXAMPLES = {
    "bool": "false", "string": "", "float32": "0.0", "float64": "0.0", "int64": "0", "int8": "0",
}  # fmt: skip


def _type_of(field: Field) -> str:
    return (
        f"{field.message.package}/{field.message.name}" if field.message is not None else field.type
    )


def _length(field: Field) -> int:
    if not field.array:
        return -1
    inner = field.array.strip("[]")
    return int(inner) if inner.isdecimal() else 0


def _all_services(offers: Offers) -> dict[str, Service]:
    return {**offers.services, **rosapi_services(offers)}


def rosapi_services(offers: Offers) -> dict[str, Service]:
    """Its own services, by name."""
    return {f"/rosapi/{name}": RosapiService(name, offers) for name in ROSAPI}


def full(name: str) -> str:
    """With its slash, and without the `#id` that old clients append."""
    plain = name.partition("#")[0]
    return plain if plain.startswith("/") else f"/{plain}"


DEFS = {"typedefs": ("TypeDef", "[]")}
ROSAPI: dict[str, tuple[tuple[str, ...], dict[str, Any], Callable[..., Values]]] = {
    "topics": ((), {"topics": TEXTS, "types": TEXTS}, _topics),
    "topics_for_type": (("type",), {"topics": TEXTS}, _topics_for_type),
    "topic_type": (("topic",), {"type": TEXT}, _topic_type),
    "topics_and_raw_types": (
        (),
        {"topics": TEXTS, "types": TEXTS, "typedefs_full_text": TEXTS},
        _raw_types,
    ),
    "services": ((), {"services": TEXTS}, _services),
    "services_for_type": (("type",), {"services": TEXTS}, _services_for_type),
    "service_type": (("service",), {"type": TEXT}, _service_type),
    "service_node": (("service",), {"node": TEXT}, _service_node),
    "action_servers": ((), {"action_servers": TEXTS}, _action_servers),
    "action_type": (("action",), {"type": TEXT}, _action_type),
    "interfaces": ((), {"interfaces": TEXTS}, _interfaces),
    "nodes": ((), {"nodes": TEXTS}, _nodes),
    "node_details": (
        ("node",),
        {"subscribing": TEXTS, "publishing": TEXTS, "services": TEXTS},
        _node_details,
    ),
    "publishers": (("topic",), {"publishers": TEXTS}, _publishers),
    "subscribers": (("topic",), {"subscribers": TEXTS}, _subscribers),
    "message_details": (("type",), DEFS, _message_details),
    "service_request_details": (("type",), DEFS, _of_service(0)),
    "service_response_details": (("type",), DEFS, _of_service(1)),
    "action_goal_details": (("type",), DEFS, _of_action(0)),
    "action_result_details": (("type",), DEFS, _of_action(1)),
    "action_feedback_details": (("type",), DEFS, _of_action(2)),
    "get_time": ((), {"time": ("Time", "")}, _get_time),
    "get_param_names": ((), {"names": TEXTS}, _no_params),
    "get_ros_version": ((), {"version": ("int8", ""), "distro": TEXT}, _ros_version),
}
"""Service -> its request, its response, and its function."""
