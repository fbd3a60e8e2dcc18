"""Services: `call_service`, answered by `service_response`."""

import asyncio
import logging
from typing import Any

from ....engine.language.suggest import did_you_mean
from ..offers.offer import Refused, Service
from .client import FAULT, Client, Message
from .fragments import fragment_size
from .frames import Misformed, may, want

LONGEST_S = 3600.0
LOG = logging.getLogger(__name__)


def call_service(client: Client, message: Message) -> None:
    """Call a service; every call is answered."""
    name = want(message, "service", str, "a service's name")
    id = may(message, "id", (str, int), "a text")
    if id is None and "#" in name:  # as old clients send it
        id = name.partition("#")[2]
    size = fragment_size(message)

    def answer(values: Any, result: bool) -> None:
        said = {"op": "service_response", "service": name, "values": values, "result": result}
        client.send(said if id is None else {**said, "id": id}, size)

    service = client.rooms.service(name)
    if service is None:
        hint = did_you_mean(name, client.rooms.offers.services)
        answer(f"there is no service {name}{hint}; rosapi/services lists them", False)
        return
    try:
        values = may(message, "args", (dict, list), "an object", {})
        timeout_s = may(message, "timeout", (int, float), "seconds", 0) or LONGEST_S
    except Misformed as fault:
        answer(str(fault), False)
        return
    client.do(
        f"a call of {name}", _answered(service, _arguments(service, values), timeout_s, answer)
    )


def _arguments(service: Service, values: Any) -> Any:
    """Arguments as an object; a list gives them in order."""
    if not isinstance(values, list):
        return values
    return {f.name: v for f, v in zip(service.kind.request.fields, values, strict=False)}


async def _answered(service: Service, values: Any, timeout_s: float, answer: Any) -> None:
    try:
        async with asyncio.timeout(max(0.0, min(timeout_s, LONGEST_S))):
            response = await service.answer(values)
    except Refused as fault:
        answer(str(fault), False)
    except TimeoutError:
        answer(f"{service.name} did not answer within {timeout_s:g} s", False)
    except Exception:  # every call is answered, and the log says why
        LOG.exception("%s failed", service.name)
        answer(FAULT, False)
    else:
        answer(response, True)
