"""The crate names every file with its hash, what made it, and how the run came out."""

import json
from hashlib import sha256
from urllib.parse import unquote

import pytest

from labrun.schemas import journal as j
from labrun.web.report.report import make

PROFILE = "https://w3id.org/ro/wfrun/process/0.5"


@pytest.fixture
def crate(folder):
    """The crate of the folder: identifier -> entity."""

    def made():
        make(folder)
        told = json.loads((folder / "ro-crate-metadata.json").read_text())
        assert told["@context"][0] == "https://w3id.org/ro/crate/1.1/context"
        entities = {entity["@id"]: entity for entity in told["@graph"]}
        assert len(entities) == len(told["@graph"])
        return entities

    return made


def references(value):
    if isinstance(value, list):
        return [found for item in value for found in references(item)]
    return [value["@id"]] if isinstance(value, dict) else []


def test_every_file_is_an_entity_with_its_size_and_hash_but_the_crate_itself(folder, teller, crate):
    (folder / "spectra").mkdir()
    (folder / "spectra" / "Li Å 1.csv").write_text("wavelength,intensity\n")
    (folder / "servers").mkdir()
    (folder / "servers" / "ledger.sqlite").write_text("x")
    (folder / "engine.lock").write_text("")
    teller.started().worked("main/a").finished()

    held = {
        unquote(i): entity for i, entity in crate().items() if entity["@type"] == "File"
    }  # fmt: skip
    assert set(held) == {
        "protocol.yaml", "lab.yaml", "run.json", "journal.jsonl", "report.html",
        "spectra/Li Å 1.csv",
    }  # fmt: skip
    for path, entity in held.items():
        data = (folder / path).read_bytes()
        assert entity["sha256"] == sha256(data).hexdigest(), path
        assert entity["contentSize"] == str(len(data)), path
    assert held["spectra/Li Å 1.csv"]["encodingFormat"] == "text/csv"


def test_every_reference_leads_to_an_entity_and_every_file_hangs_on_the_root(folder, teller, crate):
    (folder / "contracts").mkdir()
    (folder / "contracts" / "libs_analyzer-1.yaml").write_text("type: libs_analyzer@1\n")
    (folder / "element_maps.png").write_bytes(b"")
    teller.started(roles={"libs": "libs"}, params={"n": 3}).worked("main/a").finished()

    entities = crate()
    for entity in entities.values():
        for key, value in entity.items():
            outside = key == "conformsTo" and entity["@id"] == "ro-crate-metadata.json"
            assert outside or all(i in entities for i in references(value)), (entity["@id"], key)
    parts = references(entities["./"]["hasPart"])
    parts += [p for part in parts for p in references(entities[part].get("hasPart", []))]
    assert {i for i, e in entities.items() if e["@type"] == "File"} <= set(parts)
    assert entities["#device-libs"]["subjectOf"] == {"@id": "contracts/libs_analyzer-1.yaml"}


def test_the_root_conforms_to_the_profile_and_states_that_no_licence_is_known(
    folder, teller, crate
):
    teller.started().finished()

    entities = crate()
    root = entities["./"]
    assert root["conformsTo"] == {"@id": PROFILE}
    assert entities[PROFILE]["version"] == "0.5"
    assert entities["ro-crate-metadata.json"]["about"] == {"@id": "./"}
    assert "servers/" in root["description"]
    assert entities[root["license"]["@id"]]["name"] == "No licence stated"
    assert root["datePublished"].startswith("2026-11-21T08:00:00")


def test_a_run_that_succeeded_is_a_completed_action_with_times_instrument_and_parameters(
    folder, teller, crate
):
    teller.started(params={"pitch": {"$quantity": [2, "mm"]}, "sample": "core"}).finished()

    entities = crate()
    run = entities["#run"]
    assert run["actionStatus"] == "http://schema.org/CompletedActionStatus"
    assert "error" not in run
    assert run["startTime"] == "2026-11-21T08:00:00+00:00"
    assert run["endTime"] == "2026-11-21T08:00:00.020+00:00"
    program = entities[run["instrument"]["@id"]]
    assert (program["@type"], program["softwareVersion"]) == ("SoftwareApplication", "0.1.0")
    pitch = entities["#param-pitch"]
    assert (pitch["value"], pitch["unitText"]) == (2, "mm")
    assert entities["#param-sample"]["value"] == "core"
    assert {"protocol.yaml", "lab.yaml", "#param-pitch"} <= set(references(run["object"]))
    assert "journal.jsonl" in references(run["result"])


@pytest.mark.parametrize("fate", ["failed", "aborted", None])
def test_a_run_that_did_not_succeed_is_a_failed_action_with_its_reason(folder, teller, crate, fate):
    teller.started().sent("main/a")
    if fate is not None:
        teller.finished(fate, reason="out of argon")

    run = crate()["#run"]
    assert run["actionStatus"] == "http://schema.org/FailedActionStatus"
    assert ("out of argon" if fate else "was interrupted") in run["error"]


def test_a_run_of_several_engines_names_each_version_once(folder, teller, crate):
    teller.started().after(60).tell(j.Resumed(count=1, labrun="0.9.9"))
    teller.after(60).tell(j.Resumed(count=2, labrun="0.9.9")).finished()

    entities = crate()
    assert references(entities["#run"]["instrument"]) == ["#labrun-0.1.0", "#labrun-0.9.9"]
    assert "3 engine sessions" in entities["#run"]["description"]


def test_a_file_that_was_changed_says_so_beside_the_hash_that_it_has_now(folder, teller, crate):
    (folder / "a.csv").write_text("edited")
    teller.started().sent("main/a").ended("main/a", files={"a.csv": "0" * 64}).finished()

    told = crate()["a.csv"]["description"]
    assert told.startswith("Delivered by libs.measure")
    assert "the sha256 in the journal is 000000" in told


def test_what_the_lab_keeps_secret_stays_out(folder, teller, crate):
    teller.started(roles={"libs": "libs"}).finished()
    crate()

    assert "hush-hush" not in (folder / "ro-crate-metadata.json").read_text()
    assert "hush-hush" not in (folder / "report.html").read_text()
