"""The page on instruments in YAML: its labs are labs, and it names every key."""

import re
from pathlib import Path

from labrun.drivers.bridges.http_config import HttpAction, HttpConfig
from labrun.drivers.bridges.library import LibraryAction
from labrun.drivers.bridges.line_bridge import LineAction
from labrun.drivers.bridges.lines import LineConfig
from labrun.drivers.bridges.modbus_config import ModbusAction, ModbusConfig, Register
from labrun.drivers.bridges.ophyd import OphydConfig
from labrun.drivers.bridges.pylabrobot import PylabrobotConfig
from labrun.drivers.bridges.pymeasure import PymeasureConfig
from labrun.drivers.bridges.python import PythonConfig
from labrun.drivers.bridges.qcodes import QcodesConfig
from labrun.drivers.bridges.scpi import ScpiAction, ScpiConfig
from labrun.drivers.bridges.text import TextAction, TextConfig
from labrun.engine.lab.lab import load_lab

PAGE = (Path(__file__).parents[2] / "docs/how-to/instruments-in-yaml.md").read_text("utf-8")
BLOCKS = re.findall(r"```yaml\n(.*?)```", PAGE, re.S)


def test_every_instrument_on_the_page_is_one(tmp_path):
    lab = tmp_path / "lab.yaml"
    lab.write_text("".join(BLOCKS), "utf-8")
    loaded, problems = load_lab(lab)

    assert problems == []
    assert {"dmm", "stage", "stepper", "furnace", "shaker"} == set(loaded.lab.devices)
    assert set(loaded.contracts["dmm@1"].actions) == {"voltage", "set_range"}


def test_every_key_is_on_the_page():
    models = (
        *(LineAction, LineConfig, ScpiConfig, ScpiAction, TextConfig, TextAction),
        *(ModbusAction, ModbusConfig, Register, HttpAction, HttpConfig),
        *(LibraryAction, PymeasureConfig, QcodesConfig, OphydConfig, PylabrobotConfig),
        PythonConfig,
    )
    keys = {key for model in models for key in model.model_fields}

    assert [key for key in sorted(keys) if not re.search(rf"`?\b{key}\b[`:]", PAGE)] == []
