"""`labrun web --demo`: a bench without hardware, the same each time, with chosen faults."""

import pytest

LASER_LIST = ["enclosure closed", "nobody in the beam path", "sample fixed"]
SMALL = {"width": "0.4 mm", "height": "0.4 mm"}


@pytest.fixture
def control(lasting_demo):
    """A browser with control of the demonstration."""
    client = lasting_demo.client()
    client.take("Ada", reason="a test begins")
    client.command("/demo/fault", {"device": "libs", "kind": "clear"})
    return client


@pytest.mark.soak
def test_the_shipped_protocols_run_on_the_demonstration(control):
    control.reach("gantry", "libs", "reduce")
    names = [one["name"] for one in control.get("/protocols").json()]
    id = control.run_of("pegmatite_map.yaml", params=SMALL)
    run = control.until(id, "succeeded", "failed")
    maps = {head["column"] for head in control.get(f"/runs/{id}/maps").json()["maps"]}

    assert "pegmatite_map.yaml" in names and "weigh_and_dispense.json" in names
    assert run["fate"] == "succeeded", run["reason"]
    assert run["done"] == 9 and {"Li", "K", "Si"} <= maps


@pytest.mark.soak
def test_a_fault_that_was_ordered_happens_and_is_told(control):
    control.reach("gantry", "libs", "reduce")
    ordered = control.command(
        "/demo/fault",
        {"device": "libs", "action": "measure", "error": "ButtonNotFound", "count": 2},
    )
    id = control.run_of("pegmatite_map.yaml", params=SMALL)
    run = control.until(id, "succeeded", "failed")
    problems = control.get(f"/runs/{id}/log", params={"problems": True}).json()["lines"]

    assert ordered.status_code == 200
    assert run["fate"] == "succeeded" and run["retries"] == 2
    assert sum("ButtonNotFound" in line["text"] for line in problems) == 2
    assert run["nodes"]["main/scan/*/shoot"]["retries"] == 2


@pytest.mark.soak
def test_a_server_is_killed_to_order_and_comes_back(control, lasting_demo, wait_for):
    control.reach("camera")
    pid = lasting_demo.server_pid("camera")
    control.command("/demo/fault", {"device": "camera", "kind": "kill"})
    wait_for(lambda: lasting_demo.server_pid("camera") != pid, "another server")

    control.reach("camera")


@pytest.mark.soak
def test_a_frozen_device_does_not_confirm_the_stop_until_it_thaws(control, wait_for):
    control.reach("balance")
    control.command("/demo/fault", {"device": "balance", "kind": "freeze"})
    frozen = control.post("/stop").json()
    control.command("/demo/fault", {"device": "balance", "kind": "thaw"})
    control.reach("balance")

    def silent(stopped):
        return [one["device"] for one in stopped["devices"] if not one["confirmed"]]

    assert "balance" in silent(frozen)
    wait_for(lambda: not silent(control.post("/stop").json()), "the stop of every device")


@pytest.mark.soak
def test_a_device_is_unwell_until_all_is_put_right(control, wait_for):
    def libs():
        return control.get("/devices/libs").json()["status"]

    def unconfirmed():
        return [
            one["device"] for one in control.post("/stop").json()["devices"] if not one["confirmed"]
        ]

    control.reach("libs", "gantry")
    for kind in ("interlock", "slow", "stop"):
        control.command("/demo/fault", {"device": "libs", "kind": kind})
    wait_for(lambda: libs()["interlock"] == "open", "the enclosure to be open")
    faults = control.get("/demo/faults/libs").json()

    assert {one["kind"] for one in faults["ordered"]} == {"interlock", "slow", "stop"}
    assert "NoSignal" in faults["errors"]["measure"]
    assert "libs" in unconfirmed()
    control.command("/demo/fault", {"device": "libs", "kind": "clear"})
    wait_for(lambda: libs()["interlock"] == "closed", "the enclosure to be closed")
    wait_for(lambda: "libs" not in unconfirmed(), "the stop to be confirmed")
    assert control.get("/demo/faults/libs").json()["ordered"] == []


@pytest.mark.soak
@pytest.mark.parametrize(
    "order",
    [
        {"device": "none", "kind": "kill"}, {"device": "libs", "action": "fire"},
        {"device": "libs", "action": "measure", "error": "Sneeze"},
        {"device": "libs", "action": "disarm"}, {"device": "gantry", "kind": "interlock"},
    ],
)  # fmt: skip
def test_faults_that_there_are_not_are_refused(control, order):
    assert control.command("/demo/fault", order).status_code in (404, 422)


@pytest.mark.slow
def test_faults_are_for_the_demonstration_only(shared, page):
    answer = page.command("/demo/fault", {"device": "libs", "kind": "kill"})

    assert (answer.status_code, answer.json()["code"]) == (404, "NO_DEMO")


@pytest.mark.soak
def test_the_demonstration_leaves_nothing_behind_and_ends_its_runs(lasting_demo, control, wait_for):
    folder = lasting_demo.library
    control.reach("gantry", "libs", "reduce")
    run = control.run_of("pegmatite_map.yaml")  # it would take hours
    wait_for(lambda: control.run(run)["live"], "a live run")
    lasting_demo.stop()

    assert not folder.exists()
