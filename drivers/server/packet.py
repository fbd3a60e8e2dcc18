"""A message of Socket.IO: the library's own, at less cost, since an action takes three.

Its JSON coders are made once and not for each message, and what can hold no file is not searched for one.
"""

import json
from types import SimpleNamespace
from typing import Any

from socketio import packet

PLAIN = frozenset((str, int, float, bool, type(None)))
_ENCODER = json.JSONEncoder(separators=(",", ":"))
_DECODER = json.JSONDecoder()


class Packet(packet.Packet):
    """The `serializer` of a server and of a client; each reads what the library's own writes."""

    json = SimpleNamespace(dumps=lambda data, **_: _ENCODER.encode(data), loads=_DECODER.decode)

    @classmethod
    def data_is_binary(cls, data: Any) -> bool:
        """Whether bytes are in it, which travel behind the text."""
        if not isinstance(data, list | dict):
            return isinstance(data, bytes | bytearray)
        for item in data.values() if isinstance(data, dict) else data:
            if type(item) not in PLAIN and cls.data_is_binary(item):
                return True
        return False
