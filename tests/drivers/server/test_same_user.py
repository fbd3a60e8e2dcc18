"""Whose program is at the other end of a connection: asked of the kernel, with real sockets."""

import os
import socket

import pytest

from labrun.drivers.server import same_user
from labrun.drivers.server.same_user import is_own, is_told

pytestmark = pytest.mark.skipif(
    not same_user.TABLES[4].exists(), reason="this kernel does not tell"
)


@pytest.fixture(params=["127.0.0.1", "::1"])
def ends(request):
    """The addresses of a client and of a server that it is connected to."""
    family = socket.AF_INET6 if ":" in request.param else socket.AF_INET
    try:
        door = socket.create_server((request.param, 0), family=family)
    except OSError:
        pytest.skip(f"{request.param} is not an address of this machine")
    with door, socket.create_connection(door.getsockname()[:2]) as client:
        yield client.getsockname()[:2], door.getsockname()[:2]


@pytest.mark.posix("users have no numbers there")
def test_a_program_of_this_user_is_told_from_one_of_another(ends, monkeypatch):
    client, server = ends
    own, own_user = (is_own(client, server), is_told(server)), os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: own_user + 1)

    assert own == (True, True)
    assert (is_own(client, server), is_told(server)) == (False, False)


def test_a_connection_that_is_not_there_is_nobodys(ends):
    client, (host, port) = ends

    assert not is_own(client, (host, port + 1))
    assert not is_own(("somewhere", 1), (host, port))
    assert not is_told((host, client[1] + 1))


def test_a_connection_that_its_program_has_closed_is_nobodys():
    """The kernel says user 0 of it, which a server may be itself."""
    with socket.create_server(("127.0.0.1", 0)) as door:
        with socket.create_connection(door.getsockname()) as client:
            ends = client.getsockname(), door.getsockname()
            served, _ = door.accept()
        with served:
            assert not is_own(*ends)


def test_where_nothing_is_told_a_token_is_asked_for(ends, monkeypatch, tmp_path):
    monkeypatch.setattr(same_user, "TABLES", {4: tmp_path / "none", 6: tmp_path / "none"})

    assert not is_own(*ends) and not is_told(ends[1])
