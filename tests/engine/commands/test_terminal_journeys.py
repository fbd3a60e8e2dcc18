"""What people at terminals are told of stops, holes and resumes, beside what the simulated devices did.

Real commands on real pseudo-terminals; the truth is the twins' own log, which nothing on the wire shows.
"""

import json
import re
import subprocess
import sys
import time

import pytest

from ...found import found

pytestmark = pytest.mark.slow
COMMAND = [sys.executable, "-m", "labrun.engine"]
LAB = """
name: bench
simulated: true
devices:
  gantry: {{contract: gantry@1, driver: sim_gantry, config: {{clock: 20, homed: true}}}}
  libs:
    contract: libs_analyzer@1
    driver: sim_libs
    config:
      {{clock: 20, gantry: gantry, core: 3, seed: {seed}, faults: {{measure: {{ButtonNotFound: {rate}}}}}}}
"""
SCAN = """labrun: 1
name: scan
devices: {{libs: libs_analyzer@1, gantry: gantry@1}}
defaults: {{timeout: 60 s}}
steps:
  - id: scan
    foreach: {{point: "${{{{ grid(x=span(0, 2 mm, 1 mm), y=span(0, {rows} mm, 1 mm)) }}}}"}}
    key: ${{{{ point.ix }}}},${{{{ point.iy }}}}
    keep_going: {keep_going}
    steps:
      - {{do: gantry.move_to, with: {{x: "${{{{ point.x }}}}", y: "${{{{ point.y }}}}", z: 0 mm}}}}
      - {{id: shoot, do: libs.measure}}
    collect: {{x: "${{{{ point.x }}}}", y: "${{{{ point.y }}}}", shot: "${{{{ steps.shoot.shot_id }}}}"}}
on_resume: [{{do: gantry.halt}}]
finally:
  - {{fail: the valve is still open, on_error: continue}}
  - {{do: gantry.move_to, with: {{z: 5 mm}}}}
"""


class Bench:
    """A folder with a lab and a protocol, and what its devices truly did."""

    def __init__(self, folder, terminal):
        self.folder = folder
        self._terminal = terminal

    def set_up(self, *, seed=1, rate=0, keep_going="true", rows=1):
        (self.folder / "lab.yaml").write_text(LAB.format(seed=seed, rate=rate))
        (self.folder / "scan.yaml").write_text(SCAN.format(keep_going=keep_going, rows=rows))

    def terminal(self, *words):
        return self._terminal(*words, TMPDIR=str(self.folder))

    def run(self):
        return self.terminal("run", "scan.yaml", "--lab", "lab.yaml", "--yes")

    def say(self, *words):
        """Another shell: its status and all that it said."""
        done = subprocess.run(
            [*COMMAND, *words], cwd=self.folder, capture_output=True, text=True, check=False
        )
        return done.returncode, done.stdout + done.stderr

    def told(self):
        """What `labrun runs` tells of the only run."""
        _, said = self.say("runs", "--json")
        (row,) = json.loads(said)
        return row["word"], [row[name] for name in ("plan", "measured", "failed", "left")]

    def truth(self, device, what):
        """What a twin has truly done, as its own log says."""
        path = found(self.folder, f"truth/{device}.jsonl")
        lines = [] if path is None else path.read_text().splitlines()
        return [entry for entry in map(json.loads, lines) if what in entry.values()]

    def fired(self):
        """The points at which the laser has fired, in order."""
        return [shot["goal"].split("/")[3] for shot in self.truth("libs", "shot")]

    def place(self):
        """Where the carriage truly is."""
        path = found(self.folder, "gantry.json")
        return json.loads(path.read_text()) if path else {"x": 0.0}


@pytest.fixture
def bench(tmp_path, terminal):
    return Bench(tmp_path, terminal)


def wait_until(holds, timeout_s=500):
    until = time.monotonic() + timeout_s
    while not holds() and time.monotonic() < until:
        time.sleep(0.02)


def test_ctrl_c_in_a_call_stops_the_axis_and_says_where_it_stands(bench):
    bench.set_up()
    words = ("gantry.move_to", "x=700 mm", "feed=600 mm/min", "--lab", "lab.yaml", "--yes")
    terminal = bench.terminal("call", *words)
    wait_until(lambda: bench.place()["x"] > 1)
    terminal.press("\x03")
    terminal.wait_for("gantry now: ")
    status = terminal.end()

    (told,) = re.findall(r"gantry now: state idle.*? x ([\d.]+)", terminal.screen)
    assert status == 130
    assert "gantry.move_to was cancelled by Ctrl-C and ended CANCELED" in terminal.screen
    assert 1 < float(told) < 700


def test_a_stop_from_another_shell_makes_no_hole_and_finally_runs_whatever_fails_in_it(bench):
    bench.set_up(rows=11)  # so long that the other shell has started before its end
    terminal = bench.run()
    wait_until(lambda: len(bench.fired()) == 2)
    stopped, said = bench.say("stop", "--lab", "lab.yaml")
    terminal.wait_for("(labrun stop on")
    held, shown = bench.say("status", "gantry", "--lab", "lab.yaml")
    before = len(bench.fired())
    time.sleep(1)  # time for two shots, if it did not stand still
    after = len(bench.fired())
    continued, _ = bench.say("continue", "last")
    status = terminal.end()

    assert (stopped, held, continued, status) == (0, 0, 0, 0), (said, shown, terminal.screen)
    assert "libs is in its safe state" in said and "was stopped by" in shown
    assert before == after
    assert bench.told() == ("succeeded", [36, 36, 0, 0])
    assert "run succeeded, but finally: the valve is still open" in terminal.screen
    assert bench.truth("gantry", "move")[-1]["end"][2] == pytest.approx(5, abs=0.01)
    assert sorted(bench.fired()) == sorted(set(bench.fired())) and len(bench.fired()) == 36


@pytest.mark.soak
def test_holes_are_told_and_measured_again_for_a_named_person(bench):
    bench.set_up(rate=0.4, rows=15)  # which fail depends on the run's id: some of 48 always do
    terminal = bench.run()
    status = terminal.end()
    word, (plan, measured, failed, left) = bench.told()
    fired = bench.fired()
    again = bench.terminal("resume", "last", "--holes", "--by", "Ada")
    again.wait_for(f"{failed} holes will be measured again (pass 2, Ada)")
    second = again.end()
    _, numbers = bench.told()

    assert (status, word, plan, left) == (0, f"succeeded with {failed} holes", 48, 0)
    assert f"run {word}" in terminal.screen
    assert f"points: {measured} of 48 measured, {failed} failed" in terminal.screen
    assert "(left out: a hole)" in terminal.screen
    assert 1 < failed < 48 and len(fired) == measured == len(set(fired))
    assert second == 0 and numbers == [48, len(set(bench.fired())), 48 - len(set(bench.fired())), 0]
    assert len(bench.fired()) == len(set(bench.fired())) > len(fired)


@pytest.mark.soak
def test_a_run_of_which_nothing_succeeded_failed_in_words(bench):
    bench.set_up(rate=1)
    terminal = bench.run()
    status = terminal.end()
    again, said = bench.say("resume", "last")

    assert status == 1 and bench.told() == ("failed", [6, 0, 6, 0])
    assert "run failed: step scan: none of its 6 iterations succeeded" in terminal.screen
    assert "measure its 6 holes again with: labrun resume" in terminal.screen
    assert "continue with" not in terminal.screen
    assert again == 2 and "no point succeeded" in said
    assert bench.fired() == []


@pytest.mark.soak
def test_one_failure_too_many_names_the_point_and_keeps_the_size_of_the_plan(bench):
    bench.set_up(rate=1, keep_going="{max_failed: 2}")
    terminal = bench.run()
    status = terminal.end()

    assert status == 1 and bench.told() == ("failed", [6, 0, 2, 4])
    assert re.search(
        r"run failed: point 3 of 6 \(x = 2 mm, y = 0 mm\): libs\.measure: .*; no more than 2 may fail",
        terminal.screen,
    )
    assert "main/scan" not in terminal.screen
    assert bench.truth("gantry", "move")[-1]["end"][2] == pytest.approx(
        5, abs=0.01
    )  # `finally` all the same


def test_ctrl_c_in_a_run_leaves_what_it_cut_unfinished_and_a_resume_fires_nothing_twice(bench):
    bench.set_up()
    terminal = bench.run()
    wait_until(lambda: len(bench.fired()) == 3)
    terminal.press("\x03")
    status = terminal.end()
    word, (plan, measured, failed, left) = bench.told()
    again = bench.terminal("resume", "last", "--by", "Ada")
    second = again.end()

    assert (status, word, plan, failed) == (130, "aborted", 6, 0)
    assert measured + left == 6 and "run aborted by Ctrl-C" in terminal.screen
    assert second == 0, again.screen
    assert bench.told() == ("succeeded", [6, 6, 0, 0])
    assert sorted(bench.fired()) == sorted(set(bench.fired())) and len(bench.fired()) == 6
