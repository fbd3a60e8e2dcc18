"""Machines of PyLabRobot with the backends that print what they are told, where it is installed."""

import warnings

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext
from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device.entry import entry_text
from labrun.engine.new.device.sources import described

pytestmark = [
    pytest.mark.needs("pylabrobot"),
    pytest.mark.filterwarnings("default"),  # what PyLabRobot warns of is its own matter
]
TIPS = {"tip_spots": ["tips.A1:B1"]}
WELLS = {"resources": ["plate.A1:B1"], "vols": [20.0, 30.0]}


def written(folder, source):
    """The config that is written for a machine."""
    entry = entry_text("handler", described(source))
    (folder / "lab.yaml").write_text(f"devices:\n{entry}", "utf-8")
    lab, problems = load_lab(folder / "lab.yaml")

    assert problems == []
    return lab.lab.devices["handler"].config


@pytest.fixture
def handler(tmp_path):
    """The config of a liquid handler with tips and a plate on its deck."""
    warnings.simplefilter("ignore")
    from pylabrobot.resources import (
        PLT_CAR_L5AC_A00,
        TIP_CAR_480_A00,
        cor_96_wellplate_360uL_Fb,
        hamilton_96_tiprack_1000uL_filter,
    )
    from pylabrobot.resources.hamilton import STARLetDeck

    deck, tips, plates = STARLetDeck(), TIP_CAR_480_A00(name="a"), PLT_CAR_L5AC_A00(name="b")
    tips[0] = hamilton_96_tiprack_1000uL_filter(name="tips")
    plates[0] = cor_96_wellplate_360uL_Fb(name="plate")
    deck.assign_child_resource(tips, rails=3)
    deck.assign_child_resource(plates, rails=15)
    deck.save(str(tmp_path / "deck.json"))
    config = written(tmp_path, "pylabrobot:liquid_handling.LiquidHandler")
    return {**config, "deck": str(tmp_path / "deck.json")}


def test_a_heater_shaker_is_told_what_its_contract_says(tmp_path, once):
    config = written(tmp_path, "pylabrobot:heating_shaking.HeaterShaker")
    shake = config["actions"]["shake"]

    assert shake["effect"] == "once"
    assert shake["params"]["speed"]["unit"] == "rpm"
    assert config["actions"]["get_temperature"]["returns"]["temperature"]["unit"] == "degC"
    assert once("pylabrobot", config, "shake", speed=300, duration=0.01) == {}


def test_liquid_is_moved_by_names_on_the_deck(handler, ask, capfd):
    async def story(made):
        await made.method("pick_up_tips")(GoalContext("run/1"), **TIPS)
        await made.method("aspirate")(GoalContext("run/2"), **WELLS)
        with pytest.raises(ActionFailed, match=r"there is no plate\.Z1"):
            await made.method("dispense")(GoalContext("run/3"), resources=["plate.Z1"], vols=[1.0])
        await made.method("dispense")(GoalContext("run/4"), **WELLS)

    ask("pylabrobot", handler, story)
    printed = capfd.readouterr().out

    assert "plate_well_B1" in printed and "30.0" in printed


def test_tips_on_its_channels_are_known_after_a_restart(handler, once):
    once("pylabrobot", handler, "pick_up_tips", **TIPS)
    with pytest.raises(ActionFailed, match="HasTipError"):
        once("pylabrobot", handler, "pick_up_tips", **TIPS)

    assert once("pylabrobot", handler, "aspirate", **WELLS) == {}
