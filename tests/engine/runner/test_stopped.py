"""A stop is never a point's failure: the run is paused, says who it was, and goes on when told to."""

import asyncio
from threading import Thread

import pytest

SCAN = """
steps:
  - id: scan
    foreach: {i: [0, 1, 2]}
    keep_going: {max_failed: 3}
    steps:
      - {do: a.act, with: {name: "go${{ i }}"}}
      - {id: shot, do: a.shoot, with: {name: "shot${{ i }}", seconds: "${{ SHOT }}"}, on_error: continue}
      - {id: look, do: a.act, with: {name: "look${{ i }}", script: "${{ LOOK }}"}}
    collect: {i: "${{ i }}", n: "${{ steps.look.n }}"}
on_resume:
  - {do: a.act, with: {name: home}}
"""
ENDS = ("aborted", "canceled", "succeeded")
LONG_SHOT = SCAN.replace("SHOT", "20 if i == 1 else 0").replace("LOOK", "'ok'")
LONG_LOOK = SCAN.replace("SHOT", "0").replace("LOOK", "'hang,ok' if i == 1 else 'ok'")


def stops_at(device, path, then="continue", *, late=False):
    """Stop the device when something at `path` is under way, and answer the pause that follows.

    `late`: as a person does, once what was cut has ended and the tree was ticked again.
    """
    stoppers, told, due = [], [], {"pause", "end"}

    def watch(event):
        if event.event == "goal" and event.path.endswith(path) and event.state in ENDS:
            heard("end")
        if event.path.endswith(path) and event.event == "feedback" and not stoppers:
            stoppers.append(Thread(target=device.stop_by_hand))
            stoppers[0].start()
        if event.event == "control":
            told.append((event.state, event.text))
            if event.state == "pause" and then:
                stoppers[0].join()  # until then the device is closed to whoever comes
                heard("pause")

    def heard(what):
        due.discard(what)
        if not late and what == "pause":
            device.control.ask(then, "the test")
        elif late and not due and stoppers:
            due.add("never")
            asyncio.get_running_loop().call_soon(device.control.ask, then, "the test")

    watch.told = told
    return watch


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize(
    ("protocol", "path", "sent"),
    [
        # cut while it moved: idempotent, done again after what the device was set to before
        (LONG_LOOK, "1/look", ["shot1", "look1", "home", "go1", "look1"]),
        # a shot that the device finished in spite of the stop: done, and not fired again
        (LONG_SHOT, "1/shot", ["shot1", "home", "go1", "look1"]),
    ],
)
def test_a_device_that_is_stopped_pauses_the_run_and_costs_no_point(
    own_device, protocol, path, sent, late
):
    device = own_device()
    watch = stops_at(device, path, late=late)

    ran = device.run(protocol, watch=watch)

    assert (ran.status, ran.finished.holes) == (0, 0)
    before, after = ["go0", "shot0", "look0", "go1"], ["go2", "shot2", "look2"]
    assert ran.sent() == before + sent + after
    assert [row["fate"] for row in ran.rows()] == ["succeeded"] * 3
    assert all(row["n"] for row in ran.rows())
    (pause, _) = watch.told
    assert "a was stopped by the test (by hand)" in pause[1]


def test_a_shot_in_flight_when_its_device_is_stopped_is_marked(own_device):
    device = own_device()

    ran = device.run(LONG_SHOT, watch=stops_at(device, "1/shot"))

    ended = {r.id.partition("/")[2]: r for r in ran.records if r.kind == "ended"}
    assert ended["main/scan/1/shot/1"].state == "SUCCEEDED"
    assert ended["main/scan/1/shot/1"].error.name == "Stopped"
    assert "the test (by hand)" in ended["main/scan/1/shot/1"].error.message
    assert ended["main/scan/0/shot/1"].error is None


def test_what_a_stop_has_cut_is_unfinished_when_the_run_is_aborted_and_resumed(own_device):
    device = own_device()
    first = device.run(LONG_LOOK, watch=stops_at(device, "1/look", then="abort"))

    ran = device.resume()

    assert (first.status, ran.status, ran.finished.holes) == (1, 0, 0)
    assert [row["fate"] for row in ran.rows()] == ["succeeded"] * 3
    assert all(row["n"] for row in ran.rows())
    assert [name for name in ran.sent() if "shot" in name] == ["shot0", "shot1", "shot2"]
