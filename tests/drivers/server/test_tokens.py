"""The token that a server makes for its own user, and those that people choose."""

import asyncio
import os
import socket
import stat
import time

import pytest
import socketio

from labrun.drivers.client.launch import start_server
from labrun.drivers.server import tokens
from labrun.drivers.server.tokens import WeakToken, chosen

OWN = 0o666 if os.name == "nt" else 0o600
"""Windows keeps others out by the user's folder, and knows of a file only whether it may be written."""


def test_a_server_makes_a_token_that_only_its_own_user_finds(bench):
    async def story():
        server = await start_server(bench.settings(own_token=True), bench.folder)
        path = tokens._path(server.url)
        mode, token = path.stat().st_mode, tokens.found(server.url)
        with pytest.raises(socketio.exceptions.ConnectionError):
            async with bench.raw(server.url):  # knows nothing of it
                pass
        async with bench.raw(server.url, token), bench.client(server.url) as client:
            outcome = await client.follow(bench.goal(client, "go", x=1))
        await server.stop()
        return stat.S_IMODE(mode), token, outcome.state, path

    mode, token, state, path = asyncio.run(story())

    assert (mode, state) == (OWN, "SUCCEEDED")
    assert token is not None and len(token) >= tokens.LEAST
    assert not path.exists()
    assert stat.S_IMODE((bench.folder / "server_settings.json").stat().st_mode) == OWN


def test_a_client_finds_the_new_token_of_a_server_that_was_started_again(bench):
    async def story():
        first = await start_server(bench.settings(own_token=True), bench.folder)
        port = int(first.url.rpartition(":")[2])
        async with bench.client(first.url) as client:
            before = tokens.found(first.url)
            assert first.process is not None
            first.process.kill()  # its file stays
            await first.process.wait()
            again = await start_server(bench.settings(own_token=True, port=port), bench.folder)
            async with asyncio.timeout(500):
                outcome = await client.follow(bench.goal(client, "go", x=1))
                while outcome.state != "SUCCEEDED":  # of the boot that is gone
                    await asyncio.sleep(0.1)
                    outcome = await client.follow(bench.goal(client, "go", x=1))
            after = tokens.found(first.url)
        await again.stop()
        return before != after, outcome.state

    assert asyncio.run(story()) == (True, "SUCCEEDED")


def test_what_killed_servers_left_is_removed_by_the_next_one(tmp_path, monkeypatch):
    monkeypatch.setattr(
        tokens, "_path", lambda url: tmp_path / f"{socket.gethostname()}-{url.rpartition(':')[2]}"
    )
    with socket.create_server(("127.0.0.1", 0)) as alive, socket.socket() as gone:
        gone.bind(("127.0.0.1", 0))  # and does not listen
        old, young, new = gone.getsockname()[1], 2, 3
        for port, age_s in ((alive.getsockname()[1], 700), (old, 700), (young, 0)):
            path = tokens._path(f"http://127.0.0.1:{port}")
            path.write_text("of another server")
            written = time.time() - age_s
            os.utime(path, (written, written))
        with tokens.findable(f"http://127.0.0.1:{new}", tokens.made()):
            there = {int(path.name.rpartition("-")[2]) for path in tmp_path.iterdir()}

        assert there == {alive.getsockname()[1], young, new}


def test_only_addresses_of_this_machine_have_such_a_token():
    assert tokens.found("http://10.0.0.7:4101") is None


def test_a_token_comes_from_a_file_a_variable_or_the_command(tmp_path, monkeypatch):
    file = tmp_path / "token"
    file.write_text("sixteen-in-a-file\n")
    monkeypatch.setenv("LABRUN_TOKEN", "sixteen-in-the-environment")

    assert chosen(None, file, "LABRUN_TOKEN", "127.0.0.1") == "sixteen-in-a-file"
    assert chosen(None, None, "LABRUN_TOKEN", "127.0.0.1") == "sixteen-in-the-environment"
    assert (
        chosen("sixteen-as-an-option", None, "LABRUN_TOKEN", "127.0.0.1") == "sixteen-as-an-option"
    )
    assert chosen(None, None, "LABRUN_OTHER_TOKEN", "127.0.0.1") is None


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"], ids=["Notepad", "PowerShell's `>`"])
def test_a_file_with_a_mark_in_front_of_the_token_is_read_without_it(tmp_path, encoding):
    file = tmp_path / "token"
    file.write_bytes("sixteen-in-a-file\r\n".encode(encoding))

    assert chosen(None, file, "LABRUN_TOKEN", "127.0.0.1") == "sixteen-in-a-file"


def test_a_token_that_is_short_or_cannot_be_read_is_a_sentence(tmp_path):
    with pytest.raises(WeakToken, match="15 characters is easily guessed; use 16 or more"):
        chosen("x" * 15, None, "LABRUN_TOKEN", "127.0.0.1")
    with pytest.raises(WeakToken, match="No such file"):
        chosen(None, tmp_path / "none", "LABRUN_TOKEN", "127.0.0.1")
    with pytest.raises(
        WeakToken, match=r"--host 0\.0\.0\.0: .* a token is required; give --token-file"
    ):
        chosen(None, None, "LABRUN_OTHER_TOKEN", "0.0.0.0")
