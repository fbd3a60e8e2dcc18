"""What a run tells people goes to the addresses in its lab, over a real webhook."""

import json
from http.server import BaseHTTPRequestHandler, HTTPServer
from threading import Thread

import pytest

from labrun.engine.check import check_file
from labrun.engine.commands.run import start

pytestmark = pytest.mark.filterwarnings("ignore:'imghdr' is deprecated:DeprecationWarning")
"""Apprise brings it, for Python before 3.13."""

STEPS = """
  - {notify: it has begun}
  - {ask: which?, choices: [A], timeout: 0.5 s, on_error: continue}
  - {fail: enough}
"""


@pytest.fixture
def webhook():
    told = []

    class Hook(BaseHTTPRequestHandler):
        def do_POST(self):
            told.append(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(200)
            self.end_headers()

        def log_message(self, *args):
            pass

    server = HTTPServer(("127.0.0.1", 0), Hook)
    thread = Thread(target=server.serve_forever)
    thread.start()
    yield server.server_port, told
    server.shutdown()
    thread.join()
    server.server_close()


def test_people_are_told_of_what_the_lab_wants(bench, webhook, tmp_path, monkeypatch):
    port, told = webhook
    monkeypatch.setenv("HOOK", f"json://127.0.0.1:{port}/")
    lab = tmp_path / "lab.yaml"
    who = "[$HOOK, {to: 'json://127.0.0.1:9/', on: [failed]}]"
    lab.write_text(bench.lab.read_text() + f"\nnotify: {{to: {who}, on: [failed, question]}}\n")
    file = tmp_path / "p.yaml"
    file.write_text(f"labrun: 1\nname: p\ndevices: {{a: scripted@1}}\nsteps:{STEPS}")
    monkeypatch.setattr("labrun.engine.runner.notify.AGAIN_S", (0.0, 0.01))
    checked = check_file(file, lab=lab)
    assert not [p for p in checked.problems if p.severity == "error"], checked.problems

    status = start(checked, tmp_path / "runs")

    assert status == 1
    assert sorted(one["message"] for one in told) == [
        "a question is open: which?", "failed: enough", "it has begun",
    ]  # fmt: skip
    (kept,) = (tmp_path / "runs").glob("*/messages.json")  # for the page to say
    lost = [one["lost"] for one in json.loads(kept.read_text())]
    assert [words.split(":")[0] for words in sorted(lost)] == [
        "1 of 2 were not told 'failed", "1 of 2 were not told 'it has begun'",
    ]  # fmt: skip


def test_in_quiet_hours_the_end_of_a_run_is_kept_for_the_page(bench, webhook, tmp_path):
    port, told = webhook
    lab = tmp_path / "lab.yaml"
    quiet = 'quiet_from: "00:00", quiet_to: "23:59"'
    lab.write_text(
        f"{bench.lab.read_text()}\nnotify: {{to: ['json://127.0.0.1:{port}/'], {quiet}}}\n"
    )
    file = tmp_path / "p.yaml"
    file.write_text(
        "labrun: 1\nname: p\ndevices: {a: scripted@1}\nsteps: [{notify: begun}, {fail: enough}]\n"
    )

    status = start(check_file(file, lab=lab), tmp_path / "runs")

    (kept,) = (tmp_path / "runs").glob("*/messages.json")
    assert (status, told) == (1, [])
    assert json.loads(kept.read_text()) == [
        {"event": None, "text": "begun", "picture": ""},
        {"event": "failed", "text": "failed: enough", "picture": ""},
    ]  # fmt: skip
