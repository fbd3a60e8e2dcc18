"""The contracts that ship say enough for a person, a checker and a run after a crash."""

import pytest

from labrun.schemas import contracts
from labrun.schemas.contract import Action, Contract
from labrun.schemas.contracts import shipped_contracts
from labrun.schemas.quantity import seconds, unit_of

TYPES = (
    "balance@1",
    "colour_camera@1",
    "depth_camera@1",
    "dispenser@1",
    "furnace@1",
    "gantry@1",
    "gantry@2",
    "leak_sensor@1",
    "libs_analyzer@1",
    "messenger@1",
    "microscope@1",
    "optimizer@1",
    "ph_probe@1",
    "pipette@1",
    "plate_reader@1",
    "pump@1",
    "spectrum_reducer@1",
)
ACTIONS = [
    pytest.param(contract, name, action, id=f"{contract.type}.{name}")
    for contract in shipped_contracts().values()
    for name, action in contract.actions.items()
]


def _schemas(schema: dict) -> list[dict]:
    children = [*schema.get("properties", {}).values()]
    if isinstance(schema.get("items"), dict):
        children.append(schema["items"])
    return [schema, *(found for child in children for found in _schemas(child))]


def test_these_contracts_ship():
    assert tuple(sorted(shipped_contracts())) == TYPES


@pytest.mark.parametrize("contract", shipped_contracts().values(), ids=lambda c: c.type)
def test_every_contract_says_what_it_is_and_which_of_its_actions_are_safe(contract: Contract):
    assert contract.summary
    assert set(contract.safe_state) <= set(contract.actions)


@pytest.mark.parametrize(("contract", "name", "action"), ACTIONS)
def test_every_action_says_what_it_does_and_how_long_it_takes(contract, name, action: Action):
    assert action.summary
    assert action.duration is not None
    assert seconds(action.duration) > 0


@pytest.mark.parametrize(("contract", "name", "action"), ACTIONS)
def test_an_action_that_must_not_be_repeated_can_be_asked_for(contract, name, action: Action):
    if action.effect != "once":
        return
    assert action.probe is not None
    probe = contract.actions[action.probe]

    assert probe.effect == "pure"
    assert "goal_id" in probe.returns["properties"]
    assert set(action.returns.get("properties", {})) <= set(probe.returns["properties"])


@pytest.mark.parametrize(("contract", "name", "action"), ACTIONS)
def test_every_unit_is_one_that_pint_knows(contract, name, action: Action):
    units = [
        s["unit"] for s in (*_schemas(action.params), *_schemas(action.returns)) if "unit" in s
    ]

    assert all(unit_of(unit) is not None for unit in units)


@pytest.mark.parametrize(("contract", "name", "action"), ACTIONS)
def test_parameters_that_the_contract_does_not_name_are_refused(contract, name, action: Action):
    assert not action.params or action.params["additionalProperties"] is False


def test_a_shot_is_never_repeated_and_its_spectrum_may_be_written_again():
    libs = shipped_contracts()["libs_analyzer@1"]

    assert libs.actions["measure"].effect == "once"
    assert libs.actions["measure"].happened("ButtonNotFound") == "no"
    assert libs.actions["measure"].happened("NoSignal") == "yes"
    assert libs.actions["measure"].happened("DialogOpen") == "unknown"
    assert libs.actions["export"].happened("UnknownShot") == "no"
    assert libs.actions["export"].path_params() == ([], ["file"])
    assert libs.safe_state == ["disarm"]


def test_the_gantry_speaks_bench_coordinates():
    move_to = shipped_contracts()["gantry@1"].actions["move_to"].param_schemas()
    ranges = {axis: (move_to[axis]["minimum"], move_to[axis]["maximum"]) for axis in "xyz"}

    assert ranges == {"x": (0, 730), "y": (0, 810), "z": (0, 100)}


def test_the_pipette_measures_out_1_to_1000_microlitres():
    for name in ("aspirate", "dispense"):
        volume = shipped_contracts()["pipette@1"].actions[name].param_schemas()["volume"]

        assert (volume["unit"], volume["minimum"], volume["maximum"]) == ("uL", 1, 1000)


def test_the_camera_writes_the_pictures_that_it_is_asked_for():
    capture = shipped_contracts()["depth_camera@1"].actions["capture"]

    assert capture.path_params() == ([], ["image", "depth"])
    assert {"CameraLost", "NoDepth"} <= set(capture.errors)


def test_a_contract_that_was_edited_is_read_from_its_yaml(tmp_path, monkeypatch):
    for entry in contracts.FOLDER.iterdir():
        if entry.is_file():
            (tmp_path / entry.name).write_bytes(entry.read_bytes())
    edited = tmp_path / "balance.yaml"
    text = edited.read_text(encoding="utf-8")
    edited.write_text(text.replace("summary:", "summary: Edited,", 1), encoding="utf-8")
    monkeypatch.setattr(contracts, "FOLDER", tmp_path)

    assert shipped_contracts.__wrapped__()["balance@1"].summary.startswith("Edited,")


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"effect": "once"}, "idempotent"),
        ({"danger": "motion"}, "no motion"),
        ({"sets": "channel {m}"}, "there is no parameter m"),
        ({"params": {"properties": {"n": {"type": "integer"}}}}, "n may be left out"),
    ],
)
def test_what_cannot_be_set_again_or_has_no_one_name_is_refused(more, words):
    params = {"required": ["n"], "properties": {"n": {"type": "integer"}}}
    fine = {"effect": "idempotent", "sets": "channel {n}", "params": params}

    assert Action.model_validate(fine).setting({"n": 2}) == "channel 2"
    with pytest.raises(ValueError, match=words):
        Action.model_validate({**fine, **more})


def test_a_parameter_that_is_left_out_names_its_default():
    params = {"properties": {"n": {"type": "integer", "default": 1}}}
    action = Action.model_validate({"effect": "idempotent", "sets": "{n}", "params": params})

    assert action.setting({}) == "1"
    assert Action().setting({"n": 3}) == ""
