"""What travels is, byte for byte, what python-socketio's own packets are."""

import pytest
from socketio import packet

from labrun.drivers.server.packet import Packet

PAYLOADS = {
    "an action": ["goal", {"id": "r/main/0", "n": 3, "params": {"x": 1.5, "on": True}, "s": None}],
    "signs": ["update", {"message": "5 \u00b5m, \u201cdone\u201d \U0001f52c", "n": [[], {}, -0.0, 1e300]}],
    "a file": ["update", {"files": {"a": {"path": "a.csv", "data": b"\x00\xff"}}, "seq": 4}],
    "files in a list": [{"ok": True, "all": [1, [bytearray(b"x")], {"data": b""}]}],
    "many digits": ["goal", {"n": 10**90}],
    "nothing": [],
}  # fmt: skip


@pytest.mark.parametrize("kind", [packet.EVENT, packet.ACK])
@pytest.mark.parametrize("name", PAYLOADS)
def test_a_packet_is_written_and_read_as_the_library_does_it(kind: int, name: str) -> None:
    said = {"packet_type": kind, "data": PAYLOADS[name], "namespace": "/action", "id": 7}
    ours, theirs = Packet(**said), packet.Packet(**said)
    assert ours.encode() == theirs.encode()

    texts = ours.encode() if isinstance(ours.encode(), list) else [ours.encode()]
    for reader in (Packet(encoded_packet=texts[0]), packet.Packet(encoded_packet=texts[0])):
        for attachment in texts[1:]:
            reader.add_attachment(attachment)
        assert (reader.data, reader.id, reader.namespace) == (PAYLOADS[name], 7, "/action")
