"""Reports of real runs on the simulated lab: one with faults, one that was killed, one aborted."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from hashlib import sha256

import pytest

from labrun.engine.runner.reports import make_reports
from labrun.web.report.report import make

from ...ctrl_c import TO_ONE

COMMAND = [sys.executable, "-m", "labrun.engine"]
FAULTS = "measure: {ButtonNotFound: 0.3, DialogOpen: 0.3}, export: 0.3"
LAB = """simulated: true
devices:
  gantry: {contract: gantry@1, driver: sim_gantry, config: {clock: CLOCK, homed: true}}
  libs:
    contract: libs_analyzer@1
    driver: sim_libs
    config: {clock: fast, gantry: gantry, seed: 2, faults: {FAULTS}}
"""
SCAN = """labrun: 1
name: little-scan
summary: A few shots in a row
params:
  n: {type: integer, default: 4, summary: how many shots}
  rest: {type: quantity, unit: s, default: 0 s}
devices: {gantry: gantry@1, libs: libs_analyzer@1}
steps:
  - foreach: {i: "${{ range(params.n) }}"}
    id: scan
    keep_going: {max_failed: 20}
    steps:
      - {id: travel, do: gantry.move_to, with: {x: "${{ i }}", z: 0}}
      - {id: shoot, do: libs.measure, retry: 4}
      - id: export
        do: libs.export
        with: {shot: "${{ steps.shoot.shot_id }}", file: "spectra/${{ i }}.csv"}
        retry: 5
      - wait: ${{ params.rest }}
    collect: {i: "${{ i }}", shot: "${{ steps.shoot.shot_id }}"}
finally:
  - {do: libs.disarm, on_error: continue}
"""


def prepare(folder, faults="", clock="fast"):
    (folder / "scan.yaml").write_text(SCAN)
    (folder / "lab.yaml").write_text(LAB.replace("FAULTS", faults).replace("CLOCK", clock))


@contextmanager
def begun(folder, *words):
    """An engine at work on the scan; it is gone at the end of the test, whatever happens."""
    command = [*COMMAND, "run", "scan.yaml", "--lab", "lab.yaml", "--runs", "runs", *words]
    with (folder / "said.txt").open("w") as said:
        engine = subprocess.Popen(command, cwd=folder, stdout=said, stderr=subprocess.STDOUT)
    try:
        yield engine
    finally:
        if engine.poll() is None:
            engine.kill()
        engine.wait()


def only_run(folder):
    (found,) = (folder / "runs").iterdir()
    return found


def wait_for(folder, words):
    until = time.monotonic() + 500
    while time.monotonic() < until:
        found = (
            list((folder / "runs").glob("*/journal.jsonl")) if (folder / "runs").exists() else []
        )
        if found and words in found[0].read_text():
            return
        time.sleep(0.01)
    raise AssertionError(f"the journal never said {words}")


def crate_of(run):
    told = json.loads((run / "ro-crate-metadata.json").read_text())
    return {entity["@id"]: entity for entity in told["@graph"]}


@pytest.fixture(scope="module")
def faulty(tmp_path_factory):
    """A run that met many faults and went through."""
    folder = tmp_path_factory.mktemp("faulty")
    prepare(folder, FAULTS)
    with begun(folder, "-p", "n=20") as engine:  # so many that each kind of fault is met
        assert engine.wait() == 0, (folder / "said.txt").read_text()
    return only_run(folder)


@pytest.mark.slow
def test_a_run_with_faults_tells_how_each_was_handled(faulty, outline):
    found = outline((faulty / "report.html").read_text())

    assert "The run succeeded" in found.text
    assert "ButtonNotFound" in found.text and "DialogOpen" in found.text
    assert "which succeeded" in found.text
    assert "the probe last_shot reported" in found.text
    assert "how many shots" in found.text
    assert "all are unchanged" in found.text


@pytest.mark.slow
def test_the_crate_of_a_real_run_has_the_hash_of_everything_in_it(faulty):
    entities = crate_of(faulty)

    held = [entity for entity in entities.values() if entity["@type"] == "File"]
    spectra = [entity for entity in held if entity["@id"].startswith("spectra/")]
    assert {"data.csv", "report.html"} <= {entity["@id"] for entity in held}
    assert spectra
    for entity in held:
        data = (faulty / entity["@id"]).read_bytes()
        assert entity["sha256"] == sha256(data).hexdigest(), entity["@id"]
    assert {spectrum["description"] for spectrum in spectra} == {"Delivered by libs.export"}


def test_a_report_can_be_made_again_and_finds_the_same(faulty):
    before = (faulty / "report.html").read_text()
    made, failed = make_reports(faulty)

    def without_its_time(page):
        return page.partition("Versions of this report")[0]

    assert failed == []
    assert {path.name for path in made} >= {"report.html", "ro-crate-metadata.json"}
    assert without_its_time((faulty / "report.html").read_text()) == without_its_time(before)
    assert not list(faulty.glob(".*.part"))


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Windows has no kill -9")
def test_a_run_that_was_killed_has_a_report_before_and_after_it_went_on(tmp_path, outline):
    prepare(tmp_path, clock="real")
    with begun(tmp_path, "-p", "n=1"):
        wait_for(tmp_path, '"action":"move_to"')
        time.sleep(0.5)  # so that its server has it, too: it takes seconds
    run = only_run(tmp_path)

    make(run)
    before = outline((run / "report.html").read_text())
    went_on = subprocess.run(
        [*COMMAND, "resume", "last", "--runs", "runs"],
        cwd=tmp_path,
        capture_output=True,
    )
    after = outline((run / "report.html").read_text())

    assert went_on.returncode == 0, went_on.stderr
    assert "The run was interrupted" in before.text
    assert "`labrun resume` asks its server" in before.text
    assert "under way when engine 1 ended" in after.text
    assert "after the resume its server reported" in after.text
    assert crate_of(run)["#run"]["actionStatus"].endswith("CompletedActionStatus")


@pytest.mark.slow
@TO_ONE
def test_a_run_that_is_aborted_while_a_report_is_made_is_running_first_and_aborted_then(
    tmp_path, outline
):
    prepare(tmp_path)
    with begun(tmp_path, "-p", "rest=60 s") as engine:
        wait_for(tmp_path, '"files":{"spectra/0.csv"')
        run = only_run(tmp_path)
        make(run)
        during = outline((run / "report.html").read_text())
        engine.send_signal(signal.SIGINT)
        status = engine.wait()
    after = outline((run / "report.html").read_text())

    assert status == 130
    assert "The run is still going" in during.text
    assert "The run was aborted by Ctrl-C" in after.text
    assert "abort Ctrl-C" in after.text
    assert "libs yes" in after.text
    assert "aborted by Ctrl-C" in crate_of(run)["#run"]["error"]
