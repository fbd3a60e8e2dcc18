"""The server is killed, restarted, or ended: runs belong to their engines and go on."""

import contextlib
import os
import time


def test_a_run_goes_on_when_the_server_is_killed_and_is_found_again(house, wait_for):
    made = house(clock=0.5)  # half as fast as real: it must not be over before the server is back
    client = made.client()
    client.take()
    client.reach("gantry")
    id = client.run_of("long.yaml", checklist=[], operator="Ada")
    wait_for(lambda: client.run(id)["done"] >= 2, "two points")
    before = client.run(id)
    made.kill()
    journal = made.folder / "protocols" / "runs" / id / "journal.jsonl"
    size = journal.stat().st_size
    wait_for(lambda: journal.stat().st_size > size + 500, "the run to go on without a server")
    made.start()
    again = made.client()
    found = again.run(id)
    listed = again.get("/runs").json()
    again.take()
    run = again.until(id, "succeeded")
    truth = [entry["end"][0] for entry in made.truth("gantry") if entry["what"] == "move"]

    assert before["live"] and before["total"] == 12
    assert found["live"] and found["fate"] == "running" and found["total"] == 12
    assert found["launch"]["operator"] == "Ada" and listed[0]["id"] == id
    assert run["done"] == 12 and run["resumes"] == 0
    assert [round(x) for x in truth] == [20 * i + 20 for i in range(12)]  # each once, in order


def test_a_question_is_still_open_after_a_restart_and_can_be_answered(house, wait_for):
    made = house()
    client = made.client()
    client.take()
    client.reach("gantry")
    id = client.run_of("talk.yaml", checklist=[])
    wait_for(lambda: client.run(id)["open_questions"], "a question")
    made.kill()
    made.start()
    again = made.client()
    again.take()
    wait_for(lambda: again.run(id)["live"], "live")
    asked = again.run(id)["open_questions"]
    again.command(f"/runs/{id}/questions/ready", {"choice": "yes"})

    assert asked[0]["text"] == "Is the bench clear?"
    assert again.until(id, "succeeded")


def test_an_orderly_end_leaves_a_live_run_and_its_devices_alone(house, wait_for):
    made = house(clock=1)
    client = made.client()
    client.take()
    client.reach("gantry")
    id = client.run_of("long.yaml", checklist=[])
    wait_for(lambda: client.run(id)["done"] >= 1, "a point")
    pid = made.server_pid("gantry")
    said = made.stop()
    journal = made.folder / "protocols" / "runs" / id / "journal.jsonl"
    wait_for(lambda: '"finished"' in journal.read_text(), "the end of the run")

    assert "a run is still going on" in said
    assert '"fate":"succeeded"' in journal.read_text().splitlines()[-1]
    os.kill(pid, 0)  # raises if the device server had been ended with the page's


def test_an_orderly_end_without_a_run_ends_the_device_servers(house, wait_for):
    made = house()
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


def test_a_killed_engine_leaves_an_interrupted_run_that_goes_on_in_a_new_one(house, wait_for):
    import json
    import signal

    made = house(clock=4)
    client = made.client()
    client.take()
    client.reach("gantry")
    id = client.run_of("long.yaml", checklist=[])
    wait_for(lambda: client.run(id)["done"] >= 2, "two points")
    control = made.folder / "protocols" / "runs" / id / "control.json"
    os.kill(json.loads(control.read_text())["pid"], signal.SIGKILL)
    run = client.until(id, "interrupted")
    wait_for(lambda: client.command(f"/runs/{id}/resume", {}).status_code == 202, "a new engine")
    over = client.until(id, "succeeded")
    log = client.get(f"/runs/{id}/log", params={"find": "went on"}).json()

    assert not run["live"] and "resume" in run["reason"] and not run["under_way"]
    assert over["resumes"] == 1 and over["done"] == 12
    assert len(log["lines"]) == 1


def test_two_servers_on_one_port_are_refused_with_a_sentence(house):
    import subprocess
    import sys

    made = house()
    port = made.url.rpartition(":")[2]
    second = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "web", "--demo", "--no-browser", "--port", port],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip

    assert second.returncode == 4
    assert "listens at" in second.stderr and "Traceback" not in second.stderr


def test_a_browser_that_closes_does_nothing_to_its_run(house, socket, wait_for):
    made = house(clock=8)
    client = made.client()
    client.take()
    client.reach("gantry")
    ui = socket(made, client)
    id = client.run_of("long.yaml", checklist=[])
    ui.call("watch", {"run": id})
    ui.close()
    other = made.client()
    time.sleep(0.2)

    assert other.until(id, "succeeded")["done"] == 12
