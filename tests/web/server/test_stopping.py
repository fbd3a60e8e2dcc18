"""STOP ALL while a run is live: asked by two ways at once, as the page does, it is one stop."""

import json
import threading
import time

import pytest


@pytest.mark.slow
def test_a_stop_that_is_asked_for_twice_at_once_is_one_and_the_run_ends_in_order(
    unhurried, hand, wait_for, socket
):
    made, client = unhurried, hand.reach("libs")
    id = client.run_of("grid.yaml")
    wait_for(lambda: client.run(id)["under_way"], "an action")
    ui = socket(made, client)
    by_socket = []
    press = {"press": "pressed-at-noon", "name": "Ada L."}
    other = threading.Thread(target=lambda: by_socket.append(ui.call("stop", press)))
    other.start()
    by_post = client.post("/stop", headers={
        "Idempotency-Key": press["press"], "X-Name": "Ada%20L.",
    }).json()  # fmt: skip
    other.join()
    late = ui.call("stop", press)
    run = client.until(id, "aborted")
    journal = (made.library / "runs" / id / "journal.jsonl").read_text().splitlines()
    controls = [r for r in map(json.loads, journal) if r["kind"] == "control"]
    verbs = [r["verb"] for r in controls]

    assert by_socket == [by_post] == [late]
    assert by_post["runs"][0]["told"] and by_post["all_confirmed"]
    assert verbs in (["abort"], ["pause", "abort"])  # its devices may be the first to tell
    assert run["fate"] == "aborted" and run["nodes"]["finally/0"]
    assert controls[-1]["by"] == "Ada L. (STOP ALL on the page)"


@pytest.mark.slow
def test_a_run_that_comes_up_is_never_told_as_interrupted(unhurried, hand, wait_for):
    made, client = unhurried, hand.reach("libs")
    before = {run["id"] for run in client.get("/runs").json()}
    seen = []
    over = threading.Event()

    def look():
        eye = made.client()
        while not over.is_set():
            seen.extend(run for run in eye.get("/runs").json() if run["id"] not in before)

    watching = threading.Thread(target=look)
    watching.start()
    id = client.run_of("long.yaml", checklist=[])
    wait_for(lambda: client.run(id)["live"], "live")
    over.set()
    watching.join()

    assert {run["fate"] for run in seen} <= {"starting", "running"}
    assert {run["protocol"] for run in seen} <= {"long"}


@pytest.mark.slow
def test_a_stop_that_lay_in_a_stalled_line_is_late_and_one_in_time_is_not(shared, page, socket):
    page.reach("gantry", "libs")
    ui = socket(shared, page)
    late = ui.call("stop", {"until_ms": 1.0})
    in_time = ui.call("stop", {"until_ms": (time.time() + 30) * 1000})

    assert late["code"] == "LATE" and "devices" not in late
    assert {"gantry", "libs"} <= {one["device"] for one in in_time["devices"]}
