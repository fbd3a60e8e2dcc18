"""What the tools see to themselves, without a client: the lab is the one that a person has seen."""

import asyncio

import pytest

from labrun.engine.check import check_file
from labrun.engine.commands.release import copied, record_of
from labrun.engine.run.folder import FolderFault
from labrun.engine.run.released import RECORD, releases
from labrun.web.agents.tools import Tools
from labrun.web.local.refusal import Refusal

PROTOCOL = "labrun: 1\nname: go\ndevices: {gantry: gantry@1}\nsteps: [{do: gantry.home}]\n"
LAB = (
    "devices: {gantry: {contract: gantry@1, driver: sim_gantry, limits: {x: {maximum: 100 mm}},"
    " config: {homed: true, clock: fast}}}\n"
)


@pytest.mark.parametrize(
    ("seen", "now"),
    [("100 mm", "900 mm"), ("homed: true, clock: fast", "clock: fast, homed: true")],
)
def test_a_release_is_for_the_lab_that_a_person_has_seen(tmp_path, seen, now):
    protocol, lab, runs = tmp_path / "go.yaml", tmp_path / "lab.yaml", tmp_path / "runs"
    protocol.write_text(PROTOCOL)
    lab.write_text(LAB)
    checked = check_file(protocol, lab=lab)
    folder = copied(checked, runs, {})
    record = record_of(folder, checked, protocol, {}, "Ada")
    (folder / RECORD).write_text(record.model_dump_json())
    (known,) = releases(runs)
    lab.write_text(LAB.replace(seen, now))  # registers are written in the order of their keys

    with pytest.raises(FolderFault, match="the lab has changed"):
        asyncio.run(Tools(tmp_path, runs, lab).launch(known.id))
    assert releases(runs) == [known]
    assert [path.name for path in runs.iterdir()] == [".released"]


def test_an_agent_sees_protocols_alone_and_writes_none_by_the_name_of_a_lab(tmp_path):
    (tmp_path / "bench.yaml").write_text(
        LAB.replace("driver: sim_gantry", "token: a-secret-of-16-x")
    )
    (tmp_path / "torn.yaml").write_text(PROTOCOL + "steps: [\n")
    tools = Tools(tmp_path, tmp_path / "runs", None)

    assert tools.protocols() == "torn.yaml"
    assert tools.read_protocol("torn.yaml").endswith("steps: [\n")
    with pytest.raises(Refusal, match=r"bench\.yaml is no protocol"):
        tools.read_protocol("bench.yaml")
    with pytest.raises(Refusal, match=r"no protocol 'none\.yaml' here") as told:
        tools.read_protocol("none.yaml")
    assert told.value.fault.hint == "see the list of protocols"  # no address of the page's API
    for name in ("lab.yaml", "more/Lab.yaml"):
        with pytest.raises(Refusal, match="is a lab's name"):
            asyncio.run(tools.write_protocol(name, PROTOCOL))
    assert sorted(path.name for path in tmp_path.glob("*.yaml")) == ["bench.yaml", "torn.yaml"]
