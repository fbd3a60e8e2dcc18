"""Contracts as ROS interfaces: text, names, values there and back."""

import json
import re
import sys
from types import SimpleNamespace
from typing import ClassVar

import pytest

from labrun.schemas.contracts import shipped_contracts
from labrun.web.ros.aliases.kinds import GANTRY_STATUS
from labrun.web.ros.interfaces.fault import RosFault
from labrun.web.ros.interfaces.from_schema import message_of
from labrun.web.ros.interfaces.names import TOPIC, constant_name, field_name, topic_token, type_name
from labrun.web.ros.interfaces.of_contract import kinds_of
from labrun.web.ros.interfaces.render import file_text, message_text
from labrun.web.ros.interfaces.values import ValueFault, from_ros, to_ros
from labrun.web.ros.node.types import built

from .served import command

FIELD = re.compile(r"^[a-z](_?[a-z0-9]+)*$")
TYPE = re.compile(r"^[A-Z][A-Za-z0-9]*$")
CONSTANT = re.compile(r"^[A-Z](_?[A-Z0-9]+)*$")


def text(**properties):
    required = [name for name in properties if not name.startswith("may")]
    schema = {"type": "object", "properties": properties, "required": required}
    message = message_of(schema, "p", "M", sent=True)
    return message_text(message).splitlines()


@pytest.mark.parametrize(
    ("schema", "line"),
    [
        ({"type": "boolean"}, "bool v"),
        ({"type": "integer"}, "int64 v"),
        ({"type": "number"}, "float64 v"),
        ({"type": "string"}, "string v"),
        ({"type": "string", "maxLength": 9}, "string<=9 v"),
        ({"type": "array", "items": {"type": "number"}}, "float64[] v"),
        (
            {"type": "array", "items": {"type": "string", "maxLength": 3}, "maxItems": 4},
            "string<=3[<=4] v",
        ),
        (
            {"type": "array", "items": {"type": "integer"}, "minItems": 2, "maxItems": 2},
            "int64[2] v",
        ),
        ({"type": ["number", "null"]}, "float64[<=1] v"),
        ({"type": "object", "properties": {"a": {"type": "number"}}}, "MV v"),
        ({"type": "array", "items": {"type": "object", "properties": {"a": {}}}}, "MV[] v"),
        ({"type": "object", "additionalProperties": {"type": "number"}}, "string v_json"),
        ({"type": "array", "items": {"type": "array"}}, "string v_json"),
        ({"anyOf": [{"type": "number"}, {"type": "string"}]}, "string v_json"),
        ({"type": ["number", "string"]}, "string v_json"),
        ({}, "string v_json"),
        (True, "string v_json"),
        ({"enum": [1, 2]}, "int64 v"),
        ({"const": "a"}, "string v"),
        ({"type": "number", "default": 2}, "float64 v 2.0"),
        ({"type": "string", "default": 'say "hi"'}, 'string v "say \\"hi\\""'),
    ],
)
def test_a_schema_is_a_field(schema, line):
    assert text(v=schema)[-1] == line


def test_units_and_ranges_are_comments_and_words_are_constants():
    assert text(v={"type": "number", "unit": "mm", "minimum": 0, "exclusiveMaximum": 5}) == [
        "# in mm; >= 0, < 5",
        "float64 v",
    ]
    assert text(v={"enum": ["a b", "a-b", "", "1"]}) == [
        'string V_A_B="a b"', 'string V_A_B_2="a-b"', 'string V_EMPTY=""', 'string V_1="1"', "string v",
    ]  # fmt: skip


def test_what_may_be_left_out_is_a_list_of_at_most_one():
    assert text(may={"type": "number"}) == ["# may be left out", "float64[<=1] may"]


@pytest.mark.parametrize(
    "contract", shipped_contracts().values(), ids=lambda contract: contract.type
)
def test_every_name_of_a_shipped_contract_is_valid_in_ros(contract):
    kinds = kinds_of(contract, "labrun_interfaces")
    messages = [kinds.status, *kinds.status.nested()]
    for kind in (*kinds.actions.values(), *kinds.services.values()):
        assert file_text(kind).count("\n---\n") == len(kind.parts()) - 1
        for part in kind.parts():
            messages += [part, *part.nested()]

    for message in messages:
        assert TYPE.match(message.name)
        names = [field.name for field in message.fields]
        assert len(set(names)) == len(names) and all(FIELD.match(name) for name in names)
        assert all(CONSTANT.match(name) for field in message.fields for name, _ in field.constants)


@pytest.mark.parametrize(
    "name", ["x", "xY", "X-Y", "class", "for", "2nd", "__a__b__", "µm", "type", "ROI"]
)
def test_any_name_becomes_a_valid_one(name):
    assert FIELD.match(field_name(name))
    assert TYPE.match(type_name(name))
    assert TOPIC.match(f"/{topic_token(name)}")
    assert CONSTANT.match(constant_name("v", name))


def test_names_that_would_be_the_same_are_told_apart():
    assert field_name("x-y", ["x_y"]) == "x_y_2"
    assert topic_token("a__b", ["a_b", "a_b_2"]) == "a_b_3"
    assert type_name("gantry@1", "move_to") == "GantryMoveTo"
    assert type_name("gantry@2", "move_to") == "Gantry2MoveTo"


def test_values_go_there_and_back():
    schema = {
        "type": "object",
        "required": ["n", "place"],
        "properties": {
            "n": {"type": "integer"},
            "size": {"type": "number"},
            "place": {
                "type": "object",
                "required": ["x", "class"],
                "properties": {"x": {"type": "number"}, "class": {"type": "string"}},
            },
            "many": {
                "type": "array",
                "items": {
                    "type": "object",
                    "required": ["a"],
                    "properties": {"a": {"type": "boolean"}},
                },
            },
            "free": {},
        },
    }
    message = message_of(schema, "p", "M", sent=True)
    data = {
        "n": 3,
        "size": 1.5,
        "place": {"x": 1.0, "class": "A"},
        "many": [{"a": True}],
        "free": {"k": [None]},
    }
    values = to_ros(message, data)

    assert values["size"] == [1.5] and values["place"]["value_class"] == "A"
    assert json.loads(values["free_json"]) == {"k": [None]}
    assert from_ros(message, values) == data
    assert from_ros(message, {**values, "size": [], "many": [], "free_json": ""}) == {
        "n": 3, "place": {"x": 1.0, "class": "A"},
    }  # fmt: skip
    assert from_ros(message, {"n": 1, "size": 2}) == {"n": 1, "size": 2}


def test_a_value_of_another_type_names_its_place():
    message = message_of(
        {
            "type": "object",
            "properties": {"p": {"type": "object", "properties": {"x": {"type": "number"}}}},
        },
        "p",
        "M",
    )
    with pytest.raises(ValueFault, match=r"p\.x is a string but must be a float64"):
        from_ros(message, {"p": {"x": "1"}})
    with pytest.raises(ValueFault, match=r"p\.y is not a field of MP; its fields are x"):
        from_ros(message, {"p": {"y": 1}})


SAMPLES = ["BoundingBox[] boxes", "int32[] ids", "GantryLocation[] gantry_locs"]
PAPER = {
    "msg/GantryStatus": ["string work", "float32 x", "float32 y", "float32 z"],
    "srv/MoveGantry": ["string cmd", "---", "string response"],
    "srv/IsRdy": ["---", "bool ready"],
    "srv/SetZero": ["string axis", "---"],
    "srv/LaunchRequest": [
        "string cmd", "string package", "string file_name", "string args", "---",
        "string message", "bool is_launched", "string file_name",
    ],
    "action/MoveGantry": ["string cmd", "---", "string msg", "---", "string msg"],
    "action/TakeMeasurement": ["---", "---", "string feedback"],
    "action/ExportSpectrum": ["---", "---", "string feedback"],
    "action/AnalyzeSpectrum": [
        "---", "string[] peak_range", "float32[] peak_area", "---", "string feedback",
    ],
    "msg/BoundingBox": ["float32 x", "float32 y", "float32 w", "float32 h"],
    "msg/GantryLocation": ["float32 x_g", "float32 y_g", "float32 z_g"],
    "msg/SampleDetectionRes": SAMPLES,
    "action/DetectSamples": ["---", *SAMPLES, "---", "string feedback"],
}  # fmt: skip
"""src/custom_interfaces, without comments: Living-Minerals-Lab/mini_platform at 5cbf1ce, and what
ever53339/AECP_ROS2 at 349c5d0 has beyond that."""


def test_the_papers_package_is_field_for_field_that_of_its_repository(tmp_path):
    (tmp_path / "lab.yaml").write_text(
        "name: paper\ndevices: {gantry: {contract: gantry@1, driver: sim_gantry}}\n"
        "ros: {aliases: {/move_gantry: gantry}}\n"
    )
    done = command(tmp_path, "--lab", "lab.yaml", "--interfaces", "ws")
    package = tmp_path / "ws" / "custom_interfaces"
    written = {
        str(path.relative_to(package).with_suffix("")): [
            line for line in path.read_text().splitlines() if line and not line.startswith("#")
        ]
        for kind in ("msg", "srv", "action")
        for path in (package / kind).iterdir()
    }

    assert done.returncode == 0, done.stderr
    assert written == PAPER


def test_the_installed_type_has_to_have_the_fields_in_the_same_order(monkeypatch):
    """The order is the wire format: with another, a speed would be read where a place is."""

    class Status:
        fields: ClassVar[dict[str, str]] = {
            "work": "string", "x": "float", "y": "float", "z": "float",
        }  # fmt: skip

        @classmethod
        def get_fields_and_field_types(cls):
            return cls.fields

    msg = SimpleNamespace(GantryStatus=Status)
    monkeypatch.setitem(sys.modules, "custom_interfaces", SimpleNamespace(msg=msg))
    monkeypatch.setitem(sys.modules, "custom_interfaces.msg", msg)
    assert built(GANTRY_STATUS) is Status
    Status.fields = {"x": "float", "y": "float", "z": "float", "work": "string"}
    with pytest.raises(RosFault, match="in the order x, y, z, work, here work, x, y, z"):
        built(GANTRY_STATUS)


def test_the_package_of_a_lab_is_written_and_what_is_gone_is_removed(lab, tmp_path):
    stale = tmp_path / "ws" / "labrun_interfaces" / "msg" / "FurnaceStatus.msg"
    stale.parent.mkdir(parents=True)
    stale.write_text("float64 celsius\n")
    done = command(tmp_path, "--lab", str(lab), "--interfaces", "ws")

    package = tmp_path / "ws" / "labrun_interfaces"
    assert (
        done.returncode == 0 and "colcon build --packages-select labrun_interfaces" in done.stdout
    )
    assert not stale.exists()
    listed = re.findall(r'^  "(.+)"$', (package / "CMakeLists.txt").read_text(), re.M)
    files = [
        str(path.relative_to(package))
        for path in package.rglob("*")
        if path.parent != package and path.is_file()
    ]
    assert sorted(listed) == sorted(files)
    assert "<name>labrun_interfaces</name>" in (package / "package.xml").read_text()
    assert (package / "srv" / "LampAge.srv").read_text().splitlines()[:5] == [
        "# lamp@1 age", "# effect: pure", "# cannot be cancelled", "# errors: Unknown", "# may be left out",
    ]  # fmt: skip


def test_a_folder_that_cannot_be_written_is_a_sentence(lab, tmp_path):
    (tmp_path / "file").write_text("")
    done = command(tmp_path, "--lab", str(lab), "--interfaces", "file")

    assert done.returncode == 4
    assert "cannot be written" in done.stderr and "Traceback" not in done.stderr
