"""Runs from the page: started, watched, paused, answered, aborted, resumed."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

AGENT = "import asyncio; from pathlib import Path; from labrun.web.agents.tools import Tools; "
LASER_LIST = ["enclosure closed", "nobody in the beam path", "sample fixed"]


def test_a_run_is_started_and_told_to_its_end(shared, page):
    page.reach("gantry", "libs")
    id = page.run_of("grid.yaml", operator="Ada L.", note="first light", params={"sample": "a"})
    run = page.until(id, "succeeded", "failed")

    assert run["fate"] == "succeeded", run["reason"]
    assert run["done"] == run["total"] == 6
    assert run["launch"]["operator"] == "Ada L."
    assert run["launch"]["checklist"] == LASER_LIST
    assert run["params"]["sample"] == "a"


def test_the_points_of_a_run_have_places_keys_and_fates(page, finished):
    id = finished
    points = page.get(f"/runs/{id}/points", params={"loop": "main/scan", "limit": 4}).json()

    assert points["total"] == 6
    assert points["key"] == ["0,0", "1,0", "2,0", "2,1"]
    assert points["x_mm"] == [0, 1, 2, 2] and points["y_mm"] == [0, 0, 0, 1]
    assert points["status"] == ["ok"] * 4


def test_a_point_leads_to_its_actions_their_lines_its_row_and_its_spectrum(page, finished):
    id, run = finished, page.run(finished)
    point = page.get(f"/runs/{id}/point", params={"loop": "main/scan", "key": "2,1"}).json()
    lines = run["protocol_text"].splitlines()

    assert [a["action"] for a in point["actions"]] == ["move_to", "measure", "export"]
    assert "libs.measure" in lines[point["actions"][1]["line"] - 1]
    assert point["actions"][1]["result"]["shot_id"]
    assert point["row"]["x"] == {"$quantity": [2.0, "mm"]}
    assert point["spectra"] == ["spectra/2_1.csv"]
    assert [line["kind"] for line in point["log"]] == ["ended"] * 3


def test_the_outline_has_a_row_a_step_with_its_line_and_what_became_of_it(page, finished):
    run = page.run(finished)
    told = {node["path"]: node for node in run["outline"]}

    assert list(told) == [
        "main/scan", "main/scan/*/travel", "main/scan/*/shoot", "main/scan/*/export", "finally/0",
    ]  # fmt: skip
    assert told["main/scan/*/shoot"]["danger"] == "laser"
    assert told["main/scan/*/shoot"]["pointer"] == "/steps/0/steps/1"
    assert told["main/scan"]["title"].startswith("At each of 6 points of a 3 x 2 grid")
    assert run["nodes"]["main/scan/*/shoot"]["ok"] == 6
    assert run["nodes"]["main/scan"]["status"] == "ok"
    assert run["nodes"]["finally/0"]["status"] == "ok"


def test_the_log_comes_in_windows(page, finished):
    id = finished
    last = page.get(f"/runs/{id}/log", params={"limit": 5}).json()
    before = page.get(
        f"/runs/{id}/log", params={"limit": 5, "before": last["lines"][0]["n"]}
    ).json()
    libs = page.get(f"/runs/{id}/log", params={"device": "libs", "find": "MEASURE"}).json()

    assert last["more_before"]
    assert before["lines"][-1]["n"] < last["lines"][0]["n"]
    assert last["lines"][-1]["text"] == "run succeeded"
    assert len(libs["lines"]) == 6 and all(line["device"] == "libs" for line in libs["lines"])


@pytest.mark.soak
def test_a_question_is_answered_from_the_page(shared, page, wait_for):
    page.reach("gantry")
    id = page.run_of("talk.yaml", checklist=[])
    wait_for(lambda: page.run(id)["open_questions"], "a question")
    question = page.run(id)["open_questions"][0]
    wrong = page.command(f"/runs/{id}/questions/ready", {"choice": "perhaps"})
    right = page.command(f"/runs/{id}/questions/ready", {"choice": "yes"})
    run = page.until(id, "succeeded")

    assert question["text"] == "Is the bench clear?" and question["choices"] == ["yes", "no"]
    assert wrong.status_code == 409 and "choose yes, no" in wrong.json()["message"]
    assert right.status_code == 200
    assert run["nodes"]["main/ready"]["message"] == "yes (Ada)"


@pytest.mark.soak
def test_pausing_needs_no_control_and_going_on_does(unhurried, hand, wait_for):
    client, other = hand, unhurried.client()
    id = client.run_of("long.yaml", checklist=[])
    wait_for(lambda: client.run(id)["live"], "live")
    paused = other.post(f"/runs/{id}/pause", json={}, headers={"X-Name": "Bo%20%C3%98."})
    client.until(id, "paused")
    refused = other.command(f"/runs/{id}/continue")
    client.command(f"/runs/{id}/continue")
    client.until(id, "running")
    aborted = client.command(f"/runs/{id}/abort")
    run = client.until(id, "aborted")

    assert paused.status_code == 200 and "paused" in paused.json()["text"]
    assert refused.status_code == 423
    assert aborted.status_code == 200
    assert run["reason"] == "aborted by Ada"
    assert "pause by Bo Ø. (the page)" in client.get(f"/runs/{id}/log").text


def test_a_run_pauses_after_the_point_that_is_under_way(hand, wait_for):
    client = hand
    id = client.run_of("long.yaml", checklist=[])
    wait_for(lambda: client.run(id)["loops"][0]["current"], "a point")
    said = client.post(f"/runs/{id}/pause", json={"when": "after_point"})
    run = client.until(id, "paused")
    key = said.json()["text"].split()[6]
    points = client.get(f"/runs/{id}/points", params={"loop": "main/walk"}).json()

    assert points["status"][int(key)] == "ok"
    assert 0 < run["done"] < 12 and not run["pausing"]


@pytest.mark.soak
def test_an_aborted_run_goes_on_where_it_was(hand, wait_for):
    client = hand
    id = client.run_of("long.yaml", checklist=[])
    wait_for(lambda: client.run(id)["done"] >= 2, "two points")
    client.command(f"/runs/{id}/abort")
    done = client.until(id, "aborted")["done"]
    wait_for(lambda: not client.run(id)["live"], "the end of its engine")
    changes = client.post(f"/runs/{id}/changes", json={}).json()
    launch = client.command(f"/runs/{id}/resume", {})
    run = client.until(id, "succeeded")

    assert launch.status_code == 202
    assert changes == changes | {"same_text": True, "can_resume": True}
    assert run["resumes"] == 1 and run["done"] == 12 > done


def test_a_run_goes_on_with_a_changed_protocol_and_the_difference_is_told_before(hand, wait_for):
    client = hand
    client.post("/protocols", json={"name": "changed.yaml", "copy_of": "long.yaml"})
    id = client.run_of("changed.yaml", checklist=[])
    wait_for(lambda: client.run(id)["done"] >= 2, "two points")
    client.command(f"/runs/{id}/abort")
    client.until(id, "aborted")
    wait_for(lambda: not client.run(id)["live"], "the end of its engine")
    old = client.get("/protocols/changed.yaml").json()
    text = old["text"].replace("range(12)", "range(14)")
    client.put("/protocols/changed.yaml", json={"text": text, "base": old["revision"]})
    changes = client.post(f"/runs/{id}/changes", json={"protocol": "changed.yaml"}).json()
    client.command(f"/runs/{id}/resume", {"protocol": "changed.yaml"})
    run = client.until(id, "succeeded")

    assert any(line.startswith("+") and "range(14)" in line for line in changes["diff"])
    assert changes["can_resume"] and not changes["in_the_way"]
    assert run["done"] == run["total"] == 14 and run["changes"] == 1


def test_what_cannot_be_started_says_why(shared, page):
    page.reach("gantry", "libs")
    unticked = page.command("/runs", {"protocol": "grid.yaml", "checklist": ["enclosure closed"]})
    wrong = page.command(
        "/runs", {"protocol": "grid.yaml", "params": {"pitch": "1 s"}, "checklist": LASER_LIST}
    )
    changed = page.command(
        "/runs", {"protocol": "grid.yaml", "revision": "0" * 64, "checklist": LASER_LIST}
    )
    missing = page.command("/runs", {"protocol": "none.yaml"})

    assert (unticked.status_code, unticked.json()["code"]) == (422, "CHECKLIST")
    assert unticked.json()["details"]["missing"] == LASER_LIST[1:]
    assert (wrong.status_code, wrong.json()["code"]) == (422, "PROBLEMS")
    assert wrong.json()["problems"][0]["message"]
    assert (changed.status_code, changed.json()["code"]) == (409, "CHANGED")
    assert missing.status_code == 404


def test_runs_that_are_not_there_or_not_live_say_so(page, finished):
    id = finished
    told = [
        page.get("/runs/none"), page.get("/runs/..%2f..%2fetc"),
        page.get(f"/runs/{id}/point", params={"loop": "main/scan", "key": "9,9"}),
        page.post(f"/runs/{id}/pause", json={}), page.command(f"/runs/{id}/abort"),
        page.command(f"/runs/{id}/questions/ready", {"choice": "yes"}),
    ]  # fmt: skip

    assert [answer.status_code for answer in told] == [404, 404, 404, 409, 409, 409]
    assert all(answer.json()["message"] for answer in told)


def test_a_program_starts_what_was_ticked_and_read_on_the_page_and_nothing_written_since(
    shared, page
):
    page.reach("gantry", "libs")
    asked = {"protocol": "grid.yaml", "params": {"sample": "K17"}, "operator": "Ada"}
    unticked = page.post("/releases", json=asked)
    old = page.post("/releases", json={**asked, "checklist": LASER_LIST, "revision": "0" * 64})
    left = page.post("/releases", json={**asked, "checklist": LASER_LIST}).json()["id"]
    page.delete(f"/releases/{left}")
    told = page.post("/releases", json={**asked, "checklist": LASER_LIST}).json()
    before = page.get("/releases").json()
    given = page.post(f"/releases/{told['id']}", json={"by": "Ada"})
    file = shared.library / "grid.yaml"
    read = file.read_text()
    file.write_text(read.replace("span(0, 2 mm", "span(0, 200 mm"))
    about = page.get("/settings").json()["about"]
    runs = Path(about["runs"])
    truth = shared.servers / "world" / "truth" / "libs.jsonl"
    shots = len(shared.truth("libs")) if truth.exists() else 0
    tools = (
        f"Tools(Path({str(shared.library)!r}), Path({str(runs)!r}), Path({about['lab_file']!r}))"
    )
    start = f"print(asyncio.run({tools}.launch({told['id']!r})))"
    said = subprocess.check_output([sys.executable, "-c", AGENT + start], text=True)
    begun = said.split()[1]
    file.write_text(read)
    run = page.until(begun, "succeeded")
    launch = json.loads((runs / begun / "launch.json").read_text())

    assert unticked.status_code == 422 and "not ticked" in unticked.json()["message"]
    assert old.status_code == 409 and before == []
    assert "K17" in told["words"]["markdown"]
    assert given.json()["by"] == "Ada" and page.get("/releases").json() == []
    assert page.delete(f"/releases/{told['id']}").status_code == 404
    assert run["done"] == 6 and run["params"]["sample"] == "K17"
    assert len(shared.truth("libs")) > shots and not (runs / begun / "servers").exists()
    assert launch["operator"] == "Ada" and launch["checklist"] == LASER_LIST
    assert [path.name for path in (runs / ".released").iterdir()] == [f"{told['id']}-started"]
