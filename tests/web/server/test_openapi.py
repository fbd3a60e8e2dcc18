"""The description of the API is the one that lies in the repository: the page's types are made of it."""

import json
import subprocess
import sys

from labrun.web.server.openapi import FILE, openapi_text


def test_the_committed_description_is_the_present_one():
    assert FILE.read_text(encoding="utf-8") == openapi_text(), "python -m labrun.web.server.openapi"


def test_every_route_has_a_name_of_its_own_words_and_a_fault():
    told = json.loads(openapi_text())
    routes = [route for path in told["paths"].values() for route in path.values()]
    names = [route["operationId"] for route in routes]

    assert len(set(names)) == len(names)
    assert all(route["description"] for route in routes)
    assert all("4XX" in route["responses"] for route in routes)


def test_every_command_says_which_headers_it_wants():
    told = json.loads(openapi_text())["paths"]
    wanted = {
        "/api/v1/devices/{device}/actions/{action}": {
            "Idempotency-Key",
            "X-Control-Lease",
            "X-Deadline",
        },
        "/api/v1/runs/{id}/pause": {"X-Deadline", "X-Name"},
        "/api/v1/stop": {"Idempotency-Key", "X-Deadline", "X-Name"},
    }
    for path, headers in wanted.items():
        given = {p["name"] for p in told[path]["post"]["parameters"] if p["in"] == "header"}
        assert given == headers, path


def test_other_commands_start_without_the_page():
    code = (
        "import sys; sys.argv = ['labrun', 'check', '--help']\n"
        "from labrun.engine.cli import main\n"
        "try: main()\nexcept SystemExit: pass\n"
        "print([m for m in sys.modules if m.split('.')[0] in ('fastapi', 'starlette', 'uvicorn')])"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)

    assert told.stdout.splitlines()[-1] == "[]"
