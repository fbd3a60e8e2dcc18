"""What browsers are told: a snapshot, then patches without gaps that add up to the state."""

import pytest
from socketio.exceptions import ConnectionError as Unconnected


def test_a_browser_gets_a_snapshot_and_then_patches_without_gaps(shared, page, socket, wait_for):
    page.reach("gantry", "libs")
    ui = socket(shared, page)
    snapshot = wait_for(lambda: ui.all("snapshot"), "a snapshot")[0]
    page.command("/devices/gantry/jog/step", {"axis": "x", "distance_mm": 1})
    wait_for(lambda: any(patch["goals"] for patch in ui.all("patch")), "a goal")
    numbers = [patch["seq"] for patch in ui.all("patch")]
    again = ui.call("snapshot")

    assert set(snapshot["devices"]) == {"gantry", "libs"}
    assert snapshot["control"]["holder"] == "Ada" and snapshot["server_time_ms"] > 1e12
    assert numbers == list(range(snapshot["seq"] + 1, snapshot["seq"] + 1 + len(numbers)))
    assert again["seq"] >= numbers[-1] and again["goals"]


@pytest.mark.soak
def test_a_watched_run_tells_points_steps_and_lines_and_they_add_up(shared, page, socket, wait_for):
    page.reach("gantry", "libs")
    ui = socket(shared, page)
    id = page.run_of("grid.yaml")
    first = ui.call("watch", {"run": id})
    asked = page.get(f"/runs/{id}/points", params={"loop": "main/scan"})
    begun = asked.json() if asked.status_code == 200 else {"key": [], "status": []}
    run = page.until(id, "succeeded")
    wait_for(
        lambda: ui.all("run_patch") and ui.all("run_patch")[-1]["head"]["fate"] == "succeeded",
        "the last patch",
    )
    # What is under way while the answer is made is in it already.
    patches = [patch for patch in ui.all("run_patch") if patch["seq"] > first["run"]["seq"]]
    points = {k: s for k, s in zip(begun["key"], begun["status"], strict=True) if k is not None}
    for patch in patches:
        points |= {point["key"]: point["status"] for point in patch["points"]}
    nodes = dict(first["run"]["nodes"])
    for patch in patches:
        nodes |= patch["nodes"]
    lines = [line["n"] for log in ui.all("log") for line in log["lines"]]

    assert first["ok"]
    assert [p["seq"] for p in patches] == list(
        range(first["run"]["seq"] + 1, first["run"]["seq"] + 1 + len(patches))
    )
    assert nodes == run["nodes"]
    assert set(points.values()) <= {"ok", "running"} and points["2,1"] == "ok"
    assert lines == sorted(set(lines))
    assert not ui.call("watch", {"run": "none"})["ok"]


def test_two_browsers_see_the_same(shared, page, socket, wait_for):
    page.reach("gantry")
    other = shared.client()
    left, right = socket(shared, page), socket(shared, other)
    step = page.command("/devices/gantry/jog/step", {"axis": "x", "distance_mm": 1})
    assert step.status_code == 202, step.text

    def holder_told(ui):
        return [p for p in ui.all("patch") if p["goals"]]

    wait_for(lambda: holder_told(left) and holder_told(right), "both")
    goal = next(iter(holder_told(right)[0]["goals"].values()))

    assert goal["by"] == "Ada"


def test_a_socket_without_a_session_or_from_another_site_is_refused(shared, page, socket):
    with pytest.raises(Unconnected):
        socket(shared, {})
    with pytest.raises(Unconnected):
        socket(shared, page, Origin="http://evil.example")

    socket(shared, page, Origin=shared.url).call("snapshot")


def test_nonsense_on_the_socket_does_no_harm(shared, page, socket):
    ui = socket(shared, page)
    for event, data in (("jog", {"id": 5}), ("jog", "x"), ("watch", {}), ("jog", {"id": "none"})):
        ui.emit(event, data)

    assert ui.call("snapshot")["devices"]
