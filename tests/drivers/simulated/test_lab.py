"""The simulated lab that ships opens as it is written, and its twins act on each other."""

import asyncio
from importlib.resources import files
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from ruamel.yaml import YAML

from labrun.drivers.driver import Driver, GoalContext, Place
from labrun.drivers.find import check_driver, find_driver
from labrun.schemas.contracts import shipped_contracts
from labrun.schemas.lab import Lab


def simulated_lab() -> Lab:
    text = files("labrun.protocols.labs").joinpath("simulated.yaml").read_text(encoding="utf-8")
    return Lab.model_validate(YAML(typ="safe").load(text))


def drivers(world: Path) -> dict[str, Driver]:
    made = {}
    for name, device in simulated_lab().devices.items():
        kind = find_driver(device.driver or "", world)
        check_driver(kind, shipped_contracts()[device.contract])
        made[name] = kind(Place(name, dict(device.config), {}, world / name, world))
    return made


def played(world: Path, story):
    async def play():
        lab = drivers(world)
        for driver in lab.values():
            await driver.open()
        try:
            return await story(lab)
        finally:
            for driver in lab.values():
                await driver.close()

    return asyncio.run(play())


def test_it_is_simulated_and_has_a_device_for_every_role_of_the_shipped_protocols():
    lab = simulated_lab()

    assert lab.simulated
    assert list(lab.devices) == [
        "gantry", "libs", "reduce", "optimizer", "balance", "pipette", "dispenser", "colour_camera", "pump",
        "electrode", "furnace", "floor", "reader", "microscope", "camera", "overview", "gantry_b", "libs_b",
    ]  # fmt: skip


def test_every_device_says_its_status_as_its_contract_wants(tmp_path):
    async def story(lab):
        return {name: await driver.status() for name, driver in lab.items()}

    for name, status in played(tmp_path, story).items():
        contract = shipped_contracts()[simulated_lab().devices[name].contract]
        Draft202012Validator(contract.status).validate(status)

        assert set(status) == set(contract.status.get("properties", {}))


def test_a_point_of_the_map_goes_from_the_gantry_to_areas_of_elements(tmp_path):
    async def story(lab):
        await lab["gantry"].move_to(GoalContext("1"), x=1.0, y=5.6, z=0)  # spodumene
        shot = await lab["libs"].measure(GoalContext("2"))
        export = GoalContext("3")
        result = await lab["libs"].export(export, shot=shot["shot_id"], file="spectra/a.csv")
        reduce = GoalContext("4", files={"spectrum": export.files["file"]})
        return await lab["reduce"].reduce(reduce, spectrum=result["file"], elements=["Li", "K"])

    areas = played(tmp_path, story)["areas"]

    assert areas["Li"] > 500
    assert areas["K"] < 20


def test_what_the_pipette_drops_the_balance_weighs(tmp_path):
    async def story(lab):
        await lab["balance"].tare(GoalContext("1"))
        await lab["pipette"].pick_up_tip(GoalContext("2"))
        await lab["pipette"].aspirate(GoalContext("3"), volume=500)
        await lab["pipette"].dispense(GoalContext("4"), volume=500)
        return await lab["balance"].weigh(GoalContext("5"))

    reading = played(tmp_path, story)

    assert reading["stable"]
    assert reading["mass"] == pytest.approx(0.5, abs=0.012)
