"""Commands: done once, in time, by one person."""

import sqlite3
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing

import httpx
import pytest


def moves(house):
    return [entry for entry in house.truth("gantry") if entry["what"] == "move"]


def test_the_same_key_gives_the_same_answer_and_does_nothing(shared, page):
    page.reach("gantry")
    before = len(moves(shared))
    asked = {"axis": "x", "distance_mm": 1}
    first = page.command("/devices/gantry/jog/step", asked, key="once-and-never-again")
    second = page.command("/devices/gantry/jog/step", asked, key="once-and-never-again")
    late = page.command("/devices/gantry/jog/step", asked, key="once-and-never-again", until=-60)

    assert len(moves(shared)) == before + 1
    assert first.json() == second.json() == late.json()
    assert second.headers["idempotent-replay"] == "true"


def test_a_key_means_one_command(shared, page):
    page.reach("gantry")
    page.command("/devices/gantry/jog/step", {"axis": "x", "distance_mm": 1}, key="one-meaning")
    other = page.command(
        "/devices/gantry/jog/step", {"axis": "x", "distance_mm": 2}, key="one-meaning"
    )

    assert (other.status_code, other.json()["code"]) == (422, "KEY_USED")


@pytest.mark.slow
def test_what_was_done_before_a_restart_or_was_being_done_is_not_done_again(house, wait_for):
    made = house(clock=1)
    client = made.client()
    client.take()
    client.reach("gantry")
    step, path = "/devices/gantry/jog/step", "/devices/gantry/actions/move_to"
    by_3, to_700 = {"axis": "x", "distance_mm": 3}, {"params": {"x": 700, "feed": 1000}}
    first = client.command(step, by_3, key="before-the-kill")
    wait_for(lambda: client.get(f"/goals/{first.json()['id']}").json()["ended_at"], "the step")
    with ThreadPoolExecutor(1) as pool:
        asking = pool.submit(client.command, path, to_700, key="in-the-middle")
        wait_for(
            lambda: client.get("/devices/gantry").json()["status"]["state"] == "moving", "moving"
        )
        made.kill()
        error = asking.exception(timeout=500)
    made.start()
    again = made.client()
    again.take()
    again.reach("gantry")
    second = again.command(step, by_3, key="before-the-kill")
    other = again.command(path, to_700, key="in-the-middle")
    steps = [move for move in moves(made) if abs(move["end"][0] - move["start"][0] - 3) < 0.01]

    assert second.json() == first.json() and first.json()["state"] == "SUCCEEDED"
    assert len(steps) == 1
    assert isinstance(error, httpx.HTTPError) or asking.result().status_code == 202
    assert other.status_code in (202, 409)
    assert other.headers.get("idempotent-replay") or other.json()["code"] == "UNKNOWN"


def test_a_late_command_is_refused_and_not_done(shared, page):
    page.reach("gantry")
    before = len(moves(shared))
    late = page.command("/devices/gantry/jog/step", {"axis": "x", "distance_mm": 1}, until=-2)
    far = page.command("/devices/gantry/jog/step", {"axis": "x", "distance_mm": 1}, until=3600)
    stopped = page.command("/stop", until=-5)

    assert (late.status_code, late.json()["code"]) == (408, "LATE")
    assert (far.status_code, far.json()["code"]) == (400, "FAR_DEADLINE")
    assert (stopped.status_code, stopped.json()["code"]) == (408, "LATE")
    assert len(moves(shared)) == before


def test_commands_without_their_headers_are_refused(shared, page):
    page.reach("gantry")
    path, asked = "/devices/gantry/jog/step", {"axis": "x", "distance_mm": 1}
    lease = {"X-Control-Lease": page.lease}
    deadline = {"X-Deadline": str(time.time() * 1000 + 5000)}
    no_key = page.post(path, json=asked, headers={**lease, **deadline})
    no_deadline = page.post(path, json=asked, headers={**lease, "Idempotency-Key": "12345678"})
    no_lease = page.post(path, json=asked, headers={**deadline, "Idempotency-Key": "12345678"})
    short_key = page.post(path, json=asked, headers={**lease, **deadline, "Idempotency-Key": "1"})
    nonsense = page.post(
        path, json=asked, headers={**lease, "X-Deadline": "nan", "Idempotency-Key": "12345678"}
    )

    assert [a.status_code for a in (no_key, no_deadline, no_lease, short_key, nonsense)] == [
        400, 400, 423, 422, 400,
    ]  # fmt: skip


def test_control_is_held_by_one_and_taken_over_with_a_reason(shared, page, socket):
    other = shared.client()
    ui = socket(shared, page)
    lease = page.lease
    renewed = page.take("Ada").json()["lease"]
    told = other.get("/control").json()
    refused = other.take("Bo")
    asked = other.post("/control/ask", json={"name": "Bo"}).json()
    taken = other.take("Bo", reason="Ada went home")
    before = page.command("/devices/gantry/jog/step", {"axis": "x", "distance_mm": 1})
    other.post("/control/release", headers=other._leased())
    free = page.get("/control").json()

    assert renewed == lease
    assert told["holder"] == "Ada" and told["ends_at"] > told["since"]
    assert (refused.status_code, refused.json()["details"]) == (423, {"holder": "Ada"})
    assert asked["text"] == "Ada was asked"
    assert taken.json()["control"]["holder"] == "Bo"
    assert before.status_code == 423 and "Bo" in before.json()["message"]
    assert free["holder"] is None
    texts = [notice["text"] for notice in ui.all("notice")]
    assert texts == ["Bo asks Ada for control", "Bo took control over from Ada: Ada went home"]


def test_a_command_that_cannot_be_noted_is_not_begun(shared, page):
    page.reach("gantry")
    before = len(moves(shared))
    noted = shared.library / ".labrun" / "web" / "commands.sqlite"
    with closing(sqlite3.connect(noted)) as base:
        base.execute("ALTER TABLE commands RENAME TO lost")
        answer = page.command("/devices/gantry/jog/step", {"axis": "x", "distance_mm": 1})
        base.execute("ALTER TABLE lost RENAME TO commands")

    assert (answer.status_code, answer.json()["code"]) == (507, "NOT_KEPT")
    assert "nothing was done" in answer.json()["message"]
    assert len(moves(shared)) == before


@pytest.mark.slow
def test_a_server_that_cannot_know_what_was_done_does_not_start_and_says_what_to_do(tmp_path):
    noted = tmp_path / ".labrun" / "web" / "commands.sqlite"
    noted.parent.mkdir(parents=True)
    noted.write_bytes(b"SQLite format 3\0" + bytes(range(256)) * 40)
    started = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "web", tmp_path, "--no-browser", "--port", "0"],
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip

    assert started.returncode == 2
    assert "none is done twice" in started.stderr and "move it away" in started.stderr
    assert "Traceback" not in started.stderr
