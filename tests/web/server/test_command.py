"""`labrun web` without --port: the first free one, and one page for each folder."""

import json
import socket
from http.server import BaseHTTPRequestHandler, HTTPServer
from threading import Thread

import pytest
import typer

from labrun.drivers.server.tokens import findable
from labrun.web.server import command


class Settings(BaseHTTPRequestHandler):
    """Answers as the page of the folder `/served` does."""

    def do_GET(self):
        self.send_response(200)
        self.end_headers()
        self.wfile.write(json.dumps({"about": {"protocols": "/served"}}).encode())

    def log_message(self, *words):
        pass


def test_a_port_that_is_in_use_is_passed_over(monkeypatch, tmp_path, capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        first = taken.getsockname()[1]
        monkeypatch.setattr(command, "PORT", first)
        port = command._next_free("127.0.0.1", tmp_path)

    assert first < port < first + command.NEXT
    assert f"port {first} is in use" in capsys.readouterr().out


@pytest.mark.parametrize("folder", ["/served", "/other"])
def test_a_folder_that_has_a_page_is_told_where_and_another_gets_its_own(monkeypatch, folder):
    with HTTPServer(("127.0.0.1", 0), Settings) as page:
        Thread(target=page.serve_forever, daemon=True).start()
        first = page.server_address[1]
        monkeypatch.setattr(command, "PORT", first)
        with findable(f"http://127.0.0.1:{first}", "a token of 24 characters"):
            try:
                port = command._next_free("127.0.0.1", folder)
            except typer.Exit as ended:
                port = ended.exit_code
        page.shutdown()

    assert port == 4 if folder == "/served" else port > first
