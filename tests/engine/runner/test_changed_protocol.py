"""A run resumes with a changed protocol: only what still means the same counts as done."""

import subprocess
import sys

import pytest

from labrun.engine.journal.journal import read_records

PROTOCOL = """labrun: 1
name: changed
params: {depth: {type: quantity, unit: mm, default: 1 mm}}
devices: {a: scripted@1, b: scripted@1}
steps:
  - id: scan
    foreach: {i: "${{ range(3) }}"}
    steps:
      - {id: lower, do: a.act, with: {name: "lower${{ i }}", x: "${{ params.depth }}"}}
      - {id: shoot, do: a.shoot, with: {name: "shot${{ i }}"}}
      - {id: look, do: b.act, with: {name: "look${{ i }}"}}
    collect: {i: "${{ i }}", look: "${{ steps.look.name }}"}
  - {id: break, do: b.act, with: {name: break, script: Broken}}
"""
COMMAND = [sys.executable, "-m", "labrun.engine"]


class Story:
    def __init__(self, folder, bench):
        self.folder, self.bench = folder, bench
        assert self.labrun("run", self.write("first.yaml", PROTOCOL), "--lab", bench.lab)[0] == 1

    def write(self, name, text):
        (self.folder / name).write_text(text, encoding="utf-8")
        return self.folder / name

    def labrun(self, *words):
        ended = subprocess.run(
            [*COMMAND, *map(str, words), "--runs", str(self.folder / "runs")],
            capture_output=True, text=True,
        )  # fmt: skip
        return ended.returncode, ended.stderr

    def resume(self, *changes, more=()):
        text = PROTOCOL
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        return self.labrun("resume", "last", "--changed", self.write("second.yaml", text), *more)

    @property
    def run(self):
        return next((self.folder / "runs").iterdir())

    def done(self):
        return [c["name"] for c in self.bench.calls(self.run.name) if c["word"] == "done"]

    def rows(self):
        return (self.run / "data.csv").read_text().splitlines()[1:]


@pytest.fixture
def story(tmp_path, bench):
    return Story(tmp_path, bench)


MENDED = ("name: break, script: Broken", "name: mended")


@pytest.mark.slow
def test_what_is_equal_counts_as_done(story):
    status, said = story.resume(MENDED)

    assert status == 0, said
    assert "9 finished actions mean the same" in said
    assert sorted(story.done()) == sorted(
        [*(f"{what}{i}" for what in ("lower", "shot", "look") for i in range(3)), "mended"]
    )


@pytest.mark.soak
def test_more_items_are_done_and_those_before_are_not_done_again(story):
    status, said = story.resume(MENDED, ("range(3)", "range(5)"))

    assert status == 0, said
    assert [n for n in story.done() if n.startswith("shot")] == [f"shot{i}" for i in range(5)]
    assert len(story.rows()) == 5


@pytest.mark.slow
def test_what_changed_after_the_shots_is_done_again_without_them(story):
    status, said = story.resume(MENDED, ('"look${{ i }}"', '"look again ${{ i }}"'))

    assert status == 0, said
    assert "b.act: name look0 -> look again 0 (at main/scan/0/look)" in said
    assert [n for n in story.done() if n.startswith("shot")] == ["shot0", "shot1", "shot2"]
    assert story.rows() == [f"{i},{i},look again {i},succeeded" for i in range(3)]


@pytest.mark.slow
def test_a_finished_shot_that_changed_is_refused_and_nothing_is_sent(story):
    before = story.done()
    status, said = story.resume(MENDED, ('"shot${{ i }}"', '"other${{ i }}"'))

    assert status == 2
    assert (
        "name shot0 -> other0 at main/scan/0/shoot: it was done already, and is not done twice"
        in said
    )
    assert story.done() == before


@pytest.mark.slow
def test_shots_after_a_move_that_changed_are_kept_only_if_a_person_says_so(story):
    refused, said = story.labrun("resume", "last", "-p", "depth=2 mm")
    status, _ = story.resume(MENDED, ("default: 1 mm", "default: 2 mm"), more=["--yes"])

    assert refused == 2
    assert "main/scan/0/shoot was done after the former a.act (a.act: x 1 -> 2)" in said
    assert status == 0
    assert [n for n in story.done() if n.startswith("shot")] == ["shot0", "shot1", "shot2"]


@pytest.mark.soak
def test_the_change_is_kept_and_counts_for_every_later_resume(story):
    status, _ = story.resume(("name: break, script: Broken", "name: still, script: Broken"))
    again, said = story.labrun("resume", "last")

    assert (status, again) == (1, 1), said
    assert [c["name"] for c in story.bench.calls(story.run.name)].count("still") == 2
    (record,) = [r for r in read_records(story.run / "journal.jsonl") if r.kind == "changed"]
    assert (story.run / record.folder / "protocol.yaml").read_text().count("still") == 1


@pytest.mark.slow
def test_a_copy_that_was_edited_by_hand_is_refused_with_the_way_out(story):
    copy = story.run / "protocol.yaml"
    copy.write_text(copy.read_text().replace(*MENDED))
    status, said = story.labrun("resume", "last")

    assert status == 2
    assert "has changed since the run began" in said
    assert "--changed FILE" in said


@pytest.mark.soak
def test_problems_of_a_changed_protocol_are_told_as_of_any_other(story):
    status, said = story.resume(("do: a.shoot", "do: a.shot"))

    assert status == 2
    assert "did you mean" in said
    assert len(story.done()) == 9


LIVE = PROTOCOL.replace("  - {id: break, do: b.act, with: {name: break, script: Broken}}\n", "")
GATE = "  - {id: gate, ask: go on?, choices: [yes]}\n"


@pytest.mark.slow
def test_a_live_run_is_changed_from_another_shell(tmp_path, bench):
    first, second = tmp_path / "first.yaml", tmp_path / "second.yaml"
    first.write_text(LIVE.replace("labrun: 1\nname: changed", "labrun: 1\nname: live") + GATE)
    second.write_text(first.read_text().replace("range(3)", "range(5)"))
    runs = ["--runs", str(tmp_path / "runs")]

    def labrun(*words):
        told = subprocess.run([*COMMAND, *words, *runs], capture_output=True, text=True)
        return told.returncode, told.stdout + told.stderr

    engine = subprocess.Popen(
        [*COMMAND, "run", str(first), "--lab", str(bench.lab), "--json", *runs],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    opened = (line for line in engine.stdout if '"question"' in line)
    next(opened)
    told = labrun("change", "last", str(second))
    changed = labrun("change", "last", str(second), "--yes")
    next(opened)  # it is asked again, behind the new points
    answered = labrun("answer", "last", "gate", "yes")
    rest = engine.communicate()[0]
    over = labrun("change", "last", str(second))

    assert told[0] == 0
    assert "9 finished actions mean the same" in told[1]
    assert "nothing was changed; add --yes" in told[1]
    assert changed[0] == 0, changed[1]
    assert "goes on with the changed protocol (changes/1)" in changed[1]
    assert answered[0] == engine.returncode == 0, rest
    (run,) = (tmp_path / "runs").iterdir()
    assert len((run / "data.csv").read_text().splitlines()) == 6
    shots = [c["name"] for c in bench.calls(run.name) if c["action"] == "shoot"]
    assert shots.count("shot0") == 2  # begun and done, once
    assert over[0] == 1 and "--changed FILE` changes it" in over[1]
