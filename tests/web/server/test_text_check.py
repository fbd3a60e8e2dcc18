"""What the checker and the views say of a text, over the wire."""

import re

import httpx
import pytest

from labrun.engine.check import check_text

SUB = "labrun: 1\nname: sub\ndevices: {gantry: gantry@1}\nsteps: [{do: gantry.home, timeout: 1 min}]\n"


def grid(page):
    return page.get("/protocols/grid.yaml").json()["text"]


@pytest.mark.slow
def test_problems_have_their_place_and_their_pointer(shared, page):
    text = grid(page).replace("libs.measure", "libs.mesaure").replace("z: 5 mm", "z: 5 s")
    told = page.post("/check", json={"text": text, "name": "grid.yaml"}).json()
    expected = check_text(text, "grid.yaml", lab=shared.folder / "lab.yaml").problems
    lines = text.splitlines()

    assert not told["ok"]
    assert [(p["line"], p["column"], p["code"], p["message"]) for p in told["problems"]] == [
        (p.line, p.column, p.code, p.message) for p in expected
    ]
    shoot = next(p for p in told["problems"] if "mesaure" in p["message"])
    assert shoot["pointer"] == "/steps/0/steps/1/do" and shoot["file"] == "grid.yaml"
    part = lines[shoot["line"] - 1][shoot["column"] - 1 :][: shoot["length"]]
    assert part in ("libs.mesaure", "mesaure")
    z = next(p for p in told["problems"] if "time" in p["message"])
    assert z["pointer"] == "/finally/0/with/z"


def test_pointers_tell_keys_from_values_and_steps(shared, page):
    text = "labrun: 1\nname: x\ndevices: {gantry: gantry@1}\nsteps:\n  - do: gantry.home\n    retyr: 3\n"
    told = page.post("/check", json={"text": text}).json()["problems"]
    pointers = {problem["code"]: problem["pointer"] for problem in told}

    assert pointers["E110"] == "/steps/0/retyr"


def test_text_that_is_no_yaml_is_one_more_problem(shared, page):
    told = page.post("/check", json={"text": "labrun: [1\nname: x"}).json()

    assert not told["ok"] and told["title"] is None
    assert told["problems"][0]["code"].startswith("E10")


def test_a_check_gives_the_form_with_which_it_is_started(shared, page):
    told = page.post("/check", json={"text": grid(page), "name": "grid.yaml"}).json()
    params = {param["name"]: param for param in told["params"]}

    assert params["pitch"] == params["pitch"] | {
        "type": "quantity", "unit": "mm", "default": "1 mm", "minimum": "0.1 mm", "required": False,
    }  # fmt: skip
    assert told["roles"][0] == {
        "role": "gantry", "contract": "gantry@1", "device": "gantry", "choices": ["gantry"],
    }  # fmt: skip
    assert told["hazards"] == [
        {"danger": "laser", "device": "libs", "action": "measure", "pointer": "/steps/0/steps/1"}
    ]


def test_other_protocols_are_found_beside_the_name_that_is_given(shared, page):
    page.post("/protocols", json={"name": "sub/inner.yaml", "text": SUB})
    text = "labrun: 1\nname: outer\ndevices: {gantry: gantry@1}\nsteps: [{use: ./inner.yaml}]\n"
    beside = page.post("/check", json={"text": text, "name": "sub/outer.yaml"}).json()
    elsewhere = page.post("/check", json={"text": text, "name": "outer.yaml"}).json()
    outside = page.post("/check", json={"text": text, "name": "../outer.yaml"})

    assert beside["ok"], beside["problems"]
    assert not elsewhere["ok"]
    assert str(shared.folder) not in "".join(p["file"] for p in elsewhere["problems"])
    assert outside.status_code == 422


def test_words_and_explain_say_what_the_shell_says(shared, page):
    asked = {"text": grid(page), "name": "grid.yaml"}
    words = page.post("/words", json=asked).json()
    lines = page.post("/explain", json=asked).json()["lines"]
    broken = page.post("/words", json={"text": "labrun: 1\n"})

    assert words["sections"][0]["title"] == "grid" and words["markdown"].startswith("# grid")
    procedure = next(s for s in words["sections"] if s["title"] == "Procedure")
    assert procedure["items"][0]["text"].startswith("At each of 6 points of a 3 x 2 grid")
    assert len(procedure["items"][0]["below"]) == 3
    assert any("gantry.move_to" in line for line in lines)
    assert (broken.status_code, broken.json()["code"]) == (422, "PROBLEMS")


def test_a_preview_has_points_limits_counts_and_time(shared, page):
    asked = {"text": grid(page), "name": "grid.yaml", "params": {"pitch": "0.5 mm"}}
    told = page.post("/preview", json=asked).json()
    (track,) = told["tracks"]

    assert len(track["x_mm"]) == len(track["y_mm"]) == 15
    assert track["x_mm"][:6] == [0, 0.5, 1, 1.5, 2, 2] and track["length_mm"] == 7
    assert track["area"] == {"x0": 0, "x1": 730, "y0": 0, "y1": 400}
    assert track["allowed"]["y1"] == 810 and track["outside"] == []
    assert told["shots"] == told["actions"]["libs.measure"] == 15
    assert 0 <= told["time_s"]["low"] <= told["time_s"]["high"]


def test_points_outside_the_bench_are_shown_and_told(shared, page):
    text = grid(page).replace('x: "${{ point.x }}", y:', 'x: "${{ point.x + 729.5 mm }}", y:')
    told = page.post("/preview", json={"text": text, "name": "grid.yaml"}).json()

    assert told["tracks"][0]["outside"] == [1, 2, 3, 4]


@pytest.mark.slow
def test_times_are_those_of_past_runs_once_there_were_any(page, finished):
    told = page.post("/preview", json={"text": grid(page), "name": "grid.yaml"}).json()

    assert told["time_s"]["runs"] >= 1


@pytest.mark.slow
def test_a_rehearsal_gives_figures_and_faults_that_were_ordered(shared, page):
    asked = {"text": grid(page), "name": "grid.yaml"}
    plain = page.post("/rehearse", json=asked).json()
    faults = page.post("/rehearse", json={**asked, "fail": ["libs.measure:0.9"], "seed": 4}).json()
    wrong = page.post("/rehearse", json={**asked, "fail": ["nonsense"]})
    broken = page.post("/rehearse", json={"text": "labrun: 1\n"})

    assert plain["fate"] == "succeeded" and plain["lasts_s"] > 6 * 8
    assert any(re.match(r"libs\.measure +6 ", line) for line in plain["lines"])
    assert any("travels" in line for line in plain["lines"])
    assert {len(row) for row in plain["gantt"].values()} == {120} and max(
        plain["gantt"]["libs.measure"]
    ) == 1
    assert len(faults["lines"]) > len(plain["lines"])
    assert wrong.status_code == 422 and "ROLE.ACTION" in wrong.json()["message"]
    assert broken.status_code == 422 and broken.json()["problems"]


def test_the_schema_is_that_of_the_lab(shared, page):
    schema = page.get("/schema").json()

    assert "small" in schema["title"]
    assert re.search(r"gantry\.move_to|move_to", str(schema["$defs"]))


@pytest.mark.slow
def test_a_rehearsal_that_nobody_waits_for_makes_room_for_the_next(shared, page):
    steps = (
        "steps:\n  - repeat: 100000000\n    steps:\n      - {do: gantry.move_to, with: {x: 1}}\n"
    )
    endless = "labrun: 1\nname: endless\ndevices: {gantry: gantry@1}\n" + steps
    with pytest.raises(httpx.ReadTimeout):
        page.post("/rehearse", json={"text": endless}, timeout=4)
    after = page.post("/rehearse", json={"text": grid(page), "name": "grid.yaml"})

    assert after.status_code == 200 and after.json()["fate"] == "succeeded"
