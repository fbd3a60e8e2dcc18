"""A run's picture from its journal: read as it grows, never twice, also for very many points."""

import pytest

from labrun.engine.check import check_file, check_text
from labrun.engine.journal.journal import Follower, JournalFault
from labrun.schemas import journal as j
from labrun.web.runs.outline import Outline
from labrun.web.runs.picture import Picture

TEXT = """\
labrun: 1
name: big
devices: {gantry: gantry@1, libs: libs_analyzer@1}
defaults: {timeout: 60 s}
steps:
  - id: samples
    foreach: {sample: ["A", "B"]}
    key: ${{ sample }}
    steps:
      - id: scan
        foreach: {point: "${{ grid(x=span(0, 1 mm, 1 mm), y=span(0, 1 mm, 1 mm)) }}"}
        key: ${{ point.ix }},${{ point.iy }}
        steps:
          - {id: go, do: gantry.move_to, with: {x: "${{ point.x }}"}}
          - id: careful
            retry: 2
            steps: [{id: shoot, do: libs.measure, fallback: [{id: plan_b, do: libs.locate}]}]
  - {id: ask_it, ask: "Again?", choices: [yes, no]}
finally: [{do: gantry.move_to, with: {z: 5 mm}}]
"""


@pytest.fixture
def outline():
    checked = check_text(TEXT, "big.yaml")
    assert checked.ok, checked.problems
    return Outline(checked)


def read(picture, follower):
    for offset, record in follower.records():
        picture.read(offset, record)


@pytest.mark.parametrize(
    ("path", "node", "keys"),
    [
        ("main/samples/A/scan/0,1/go", "main/samples/*/scan/*/go", ["A", "0,1"]),
        ("main/samples/A/scan/0,1/careful/shoot", "main/samples/*/scan/*/careful/shoot", ["A", "0,1"]),
        (
            "main/samples/B/scan/1,1/careful/r2/careful/shoot/f1/plan_b",
            "main/samples/*/scan/*/careful/shoot/f1/plan_b", ["B", "1,1"],
        ),
        ("main/samples/A/scan", "main/samples/*/scan", ["A"]),
        ("finally:2/0", "finally/0", []),
        ("main/samples/A/scan/0,1/careful/shoot/probe", "main/samples/*/scan/*/careful/shoot", ["A", "0,1"]),
    ],
)  # fmt: skip
def test_a_path_of_the_journal_leads_to_its_step_and_its_points(outline, path, node, keys):
    found = outline.find(path)

    assert found.step.told.path == node
    assert [key for _, key in found.loops] == keys


@pytest.mark.parametrize(
    ("path", "node", "keys"),
    [
        ("resume:2/main/scan/b/inner/warm", "resume/main/scan/*/inner/warm", ["b"]),
        ("resume:2/main/scan/b/inner/again/r2/again/0", "resume/main/scan/*/inner/again/0", ["b"]),
        ("resume:2/0", "resume/0", []),
        ("resume:2/main/scan/b/inner/other", None, []),
        ("resume:2/main/scan/b", None, []),
    ],
)  # fmt: skip
def test_the_on_resume_of_a_used_protocol_is_below_the_path_of_its_use(tmp_path, path, node, keys):
    file = tmp_path / "outer.yaml"
    (tmp_path / "inner.yaml").write_text(
        "labrun: 1\nname: inner\ndevices: {gantry: gantry@1}\nsteps: [{do: gantry.home}]\n"
        "on_resume:\n  - {id: warm, log: on}\n  - {id: again, retry: 2, steps: [{do: gantry.home}]}\n"
    )
    file.write_text(
        "labrun: 1\nname: outer\ndevices: {gantry: gantry@1}\non_resume: [{log: here}]\nsteps:\n"
        "  - id: scan\n    foreach: {i: [a, b]}\n    key: ${{ i }}\n"
        "    steps: [{id: inner, use: ./inner.yaml}]\n"
    )
    checked = check_file(file)
    assert checked.ok, checked.problems
    found = Outline(checked).find(path)

    assert (found and found.step.told.path) == node
    assert [key for _, key in (found.loops if found else ())] == keys


def test_a_path_of_nothing_leads_nowhere(outline):
    assert outline.find("main/nothing") is None and outline.find("other:1/x") is None


def test_only_what_is_new_in_a_journal_is_read(teller, outline):
    teller.started()
    follower, picture = Follower(teller.path), Picture(teller.path, outline)
    read(picture, follower)
    before = follower.offset
    teller.sent("main/samples/A/scan/0,0/go", action="gantry.move_to")
    new = [record.kind for _, record in follower.records()]

    assert before == teller.path.read_bytes().index(b'{"n":3')
    assert new == ["goal"] and list(follower.records()) == []


def test_a_torn_last_line_waits_for_its_end(teller):
    teller.started()
    follower = Follower(teller.path)
    list(follower.records())
    line = teller._line(j.Phase(phase="finally:1"))
    with teller.path.open("a", newline="\n") as file:
        file.write(line[:20])
    torn = list(follower.records())
    with teller.path.open("a", newline="\n") as file:
        file.write(line[20:])

    assert torn == [] and [r.phase for _, r in follower.records()] == ["finally:1"]


def test_a_journal_that_was_changed_is_shown_up_to_the_damage(teller):
    teller.started().sent("main/a").ended("main/a")
    text = teller.path.read_text().replace("libs", "LIBS")
    teller.path.write_text(text)
    follower, seen = Follower(teller.path), []
    with pytest.raises(JournalFault, match="record 3"):
        seen += [record.n for _, record in follower.records()]

    assert follower.number == 3


def test_points_of_nested_loops_are_told_apart_by_the_keys_around(teller, outline):
    teller.started()
    for sample in "AB":
        for index, key in enumerate(("0,0", "1,0")):
            path = f"main/samples/{sample}/scan/{key}"
            teller.worked(f"{path}/go", action="gantry.move_to")
            teller.failed(f"{path}/careful/shoot") if (sample, key) == ("B", "1,0") else None
            teller.tell(
                j.IterationEnded(
                    loop=f"main/samples/{sample}/scan", index=index, key=key, within=sample,
                    fate="failed" if (sample, key) == ("B", "1,0") else "succeeded",
                    message=f"{path}/careful/shoot: libs.measure: NoSignal: too dark",
                )
            )  # fmt: skip
    teller.finished(holes=1, reason="finally: the valve is open")
    picture = Picture(teller.path, outline)
    read(picture, Follower(teller.path))
    nodes, points, lines = picture.take_changes()
    told = {
        (point.within, point.key): point.status for point in points if point.loop.endswith("scan")
    }

    assert told == {
        ("A", "0,0"): "ok",
        ("A", "1,0"): "ok",
        ("B", "0,0"): "ok",
        ("B", "1,0"): "failed",
    }
    assert nodes["main/samples/*/scan/*/go"].ok == 4
    assert nodes["main/samples/*/scan/*/careful/shoot"].failed == 1
    assert picture.hole_count == 1 and not picture.take_changes()[1]
    assert len(lines) == len(picture.log)
    window = picture.log.window(outline, None, None, 2, problems=False, device=None, find="")
    assert [line.text for line in window.lines] == [
        "1,0: libs.measure: NoSignal: too dark (a hole)",
        "run succeeded with 1 hole, but finally: the valve is open",
    ]


def test_the_point_at_which_the_run_failed_is_a_hole_if_its_shot_had_happened(teller, outline):
    path = "main/samples/A/scan/0,0/careful/shoot"
    loops = ("main/samples/A/scan", "main/samples")

    def ended(fate):
        parts = {"total": 2, "succeeded": 0, "failed": 0, "skipped": 0}
        teller.tell(*(j.LoopEnded(loop=loop, fate=fate, **parts) for loop in loops))

    teller.started().failed(path, happened="yes")
    ended("failed")
    teller.finished("failed", detail=f"{path}: libs.measure: ButtonNotFound: no such luck")
    picture, follower = Picture(teller.path, outline), Follower(teller.path)
    read(picture, follower)
    hole, stands = dict(picture.holes), set(picture.stands)
    (told,) = [p for p in picture.take_changes()[1] if p.loop.endswith("scan")]
    teller.tell(j.Resumed(labrun="0.1.0", count=1))
    read(picture, follower)
    (again,) = [p for p in picture.take_changes()[1] if p.loop.endswith("scan")]
    ended("succeeded")
    read(picture, follower)
    counted = [picture.nodes[loop].state() for loop in ("main/samples/*/scan", "main/samples")]

    assert hole == {("main/samples/*/scan", "A", "0,0"): "main/samples/A/scan/0,0"}
    assert stands == set(hole.values())
    assert (told.key, told.status, told.message) == ("0,0", "failed", "no such luck")
    assert again.status == "waiting"
    assert [(one.status, one.ok, one.failed) for one in counted] == [("ok", 1, 0)] * 2


def test_a_question_and_a_goal_under_way_end_with_the_run(teller, outline):
    teller.started().sent("main/samples/A/scan/0,0/go", action="gantry.move_to")
    teller.tell(j.Asked(path="main/ask_it", id="ask_it", text="Again?", choices=["yes", "no"]))
    picture = Picture(teller.path, outline)
    follower = Follower(teller.path)
    read(picture, follower)
    during = (len(picture.under_way), len(picture.open_questions))
    teller.finished("aborted", reason="aborted by Ada")
    read(picture, follower)

    assert during == (1, 1)
    assert (len(picture.under_way), len(picture.open_questions)) == (0, 0)
    assert picture.fate == "aborted" and picture.nodes["main/ask_it"].running == 0


def test_a_paper_s_scan_is_read_in_one_go_and_told_in_windows(teller, outline):
    teller.started()
    for index in range(1071):
        path = f"main/samples/A/scan/{index},0"
        teller.worked(f"{path}/go", action="gantry.move_to").worked(f"{path}/careful/shoot")
        teller.tell(
            j.IterationEnded(
                loop="main/samples/A/scan",
                index=index,
                key=f"{index},0",
                within="A",
                fate="succeeded",
            )
        )
    picture = Picture(teller.path, outline)
    read(picture, Follower(teller.path))
    table = picture.tables["main/samples/*/scan", "A"]
    window = picture.log.window(outline, None, 1000, 5, problems=False, device="libs", find="")

    assert table.done == 1071 and len(picture.log) == 2 + 2 * 1071
    assert [line.device for line in window.lines] == ["libs"] * 5
    assert window.more_before and window.total == 1071


def test_a_hole_that_is_measured_again_waits_with_all_that_is_in_it(folder, teller, outline):
    teller.started()
    scan = "main/samples/A/scan"
    for key, fate in (("0,0", "succeeded"), ("1,0", "failed")):
        tell = teller.worked if fate == "succeeded" else teller.failed
        tell(f"{scan}/{key}/careful/shoot")
        teller.iteration(key, fate, loop=scan, message="dark" if fate == "failed" else "")
    teller.iteration("A", "failed", loop="main/samples")
    picture, follower = Picture(teller.path, outline), Follower(teller.path)
    read(picture, follower)
    holes = dict(picture.holes)
    count = picture.nodes["main/samples/*/scan/*/careful/shoot"]
    before = count.ok, count.failed
    teller.tell(j.Finished(fate="failed"))
    teller.tell(j.Redo(by="Ada", pass_number=2, iterations=["main/samples/A"]))
    read(picture, follower)
    inner = picture.table("main/samples/*/scan", "A")
    waiting = [inner.point(slot).status for slot in range(2)]
    again = "main/samples/A/pass:2/scan"
    teller.sent(f"{again}/1,0/careful/shoot").ended(f"{again}/1,0/careful/shoot")
    read(picture, follower)

    assert holes == {("main/samples", "", "A"): "main/samples/A"}  # what lies within it is none
    assert before == (1, 1) and (count.ok, count.failed) == (2, 0)
    assert picture.finished is None and picture.holes == {} and waiting == ["waiting", "waiting"]
    assert inner.point(inner.slots["1,0"]).status == "running" and inner.total is not None
    assert picture.table("main/samples", "").done == 0


def test_a_point_that_was_cut_off_is_unfinished_until_it_goes_on(folder, teller, outline):
    teller.started()
    scan = "main/samples/A/scan"
    teller.sent(f"{scan}/0,0/careful/shoot")
    teller.tell(j.Finished(fate="aborted"))
    picture, follower = Picture(teller.path, outline), Follower(teller.path)
    read(picture, follower)
    table = picture.table("main/samples/*/scan", "A")
    slot = table.slots["0,0"]
    cut = table.point(slot).status
    teller.tell(j.Resumed(count=1, labrun="1"))
    teller.sent(f"{scan}/0,0/careful/shoot")
    read(picture, follower)

    assert (cut, table.point(slot).status, table.done) == ("cancelled", "running", 0)
