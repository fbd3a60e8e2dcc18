"""The server is killed, restarted, or ended: runs belong to their engines and go on."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time

import pytest


@pytest.fixture(scope="module")
def killed_often(lasting):
    return lasting(clock=2)


@pytest.fixture
def made(killed_often):
    """A server that may be killed or ended; the next test starts it again."""
    if killed_often.process.poll() is not None:
        killed_often.start()
    return killed_often


def begun(made):
    """A browser with control, and a run that asks midway."""
    client = made.client()
    client.take("Ada", reason="a test begins")
    client.reach("gantry")
    return client, client.run_of("midway.yaml", checklist=[], operator="Ada")


def journal(made, id):
    return (made.library / "runs" / id / "journal.jsonl").read_text()


@pytest.mark.soak
def test_a_run_goes_on_when_the_server_is_killed_and_is_found_again_with_its_question(
    made, wait_for
):
    client, id = begun(made)
    wait_for(lambda: client.run(id)["done"] >= 1, "a point")
    before = client.run(id)
    asked_before = '"asked"' in journal(made, id)
    made.kill()
    wait_for(lambda: '"asked"' in journal(made, id), "the run to go on without a server")
    made.start()
    again = made.client()
    found = again.run(id)
    listed = again.get("/runs").json()
    again.take("Ada", reason="after a restart")
    wait_for(lambda: again.run(id)["open_questions"], "its question")
    asked = again.run(id)["open_questions"]
    again.command(f"/runs/{id}/questions/ready", {"choice": "yes"})
    run = again.until(id, "succeeded")
    truth = [entry["end"][0] for entry in made.truth("gantry") if entry["what"] == "move"]

    assert before["live"] and not asked_before
    assert found["live"] and found["fate"] == "running"
    assert found["launch"]["operator"] == "Ada" and listed[0]["id"] == id
    assert asked[0]["text"] == "Is the bench clear?"
    assert run["done"] == 8 and run["resumes"] == 0
    assert [round(x) for x in truth] == [20 * i + 20 for i in range(8)]  # each once, in order


@pytest.mark.soak
def test_an_orderly_end_leaves_a_live_run_and_its_devices_alone(made, wait_for):
    client, id = begun(made)
    wait_for(lambda: client.run(id)["open_questions"], "a question")
    pid = made.server_pid("gantry")
    said = made.stop()
    os.kill(pid, 0)  # raises if the device server had been ended with the page's
    made.start()
    again = made.client()
    again.take("Ada", reason="after an end")
    wait_for(lambda: again.run(id)["live"], "live")
    again.command(f"/runs/{id}/questions/ready", {"choice": "yes"})

    assert "a run is still going" in said
    assert again.until(id, "succeeded")["resumes"] == 0


@pytest.mark.slow
def test_an_orderly_end_without_a_run_ends_the_device_servers(made, wait_for):
    client = made.client()
    client.reach("gantry", "libs")
    pids = [made.server_pid(device) for device in ("gantry", "libs")]
    made.stop()

    def gone(pid):
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, 0)
            return False
        return True

    wait_for(lambda: all(gone(pid) for pid in pids), "the end of both")

    assert made.process.returncode == 0


@pytest.mark.soak
def test_a_killed_engine_leaves_an_interrupted_run_that_goes_on_in_a_new_one(
    unhurried, hand, wait_for
):
    client = hand
    id = client.run_of("long.yaml", checklist=[])
    wait_for(lambda: client.run(id)["done"] >= 2, "two points")
    control = unhurried.library / "runs" / id / "control.json"
    os.kill(json.loads(control.read_text())["pid"], signal.SIGKILL)
    run = client.until(id, "interrupted")
    wait_for(lambda: client.command(f"/runs/{id}/resume", {}).status_code == 202, "a new engine")
    over = client.until(id, "succeeded")
    log = client.get(f"/runs/{id}/log", params={"find": "resumed"}).json()

    assert not run["live"] and "resume" in run["reason"] and not run["under_way"]
    assert over["resumes"] == 1 and over["done"] == 12
    assert len(log["lines"]) == 1


@pytest.mark.slow
def test_two_servers_on_one_port_are_refused_with_a_sentence(shared):
    port = shared.url.rpartition(":")[2]
    second = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "web", "--demo", "--no-browser", "--port", port],
        capture_output=True, text=True,
    )  # fmt: skip

    assert second.returncode == 4
    assert "is already in use" in second.stderr and "Traceback" not in second.stderr


@pytest.mark.slow
def test_a_browser_that_closes_does_nothing_to_its_run(shared, page, socket):
    page.reach("gantry")
    ui = socket(shared, page)
    id = page.run_of("long.yaml", checklist=[])
    ui.call("watch", {"run": id})
    ui.close()
    other = shared.client()
    time.sleep(0.2)

    assert other.until(id, "succeeded")["done"] == 12
