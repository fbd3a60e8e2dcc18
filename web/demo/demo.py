"""The demonstration: shipped protocols and the simulated lab, in a folder that is deleted with it."""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path

from ruamel.yaml import YAML

from ...engine.lab.lab import load_lab

SHOWN = (".yaml", ".json", ".csv", ".py", ".calibration")
TWINS = {
    "sim_gantry": "Gantry", "sim_libs": "Libs", "sim_balance": "Balance", "sim_pipette": "Pipette",
    "sim_depth_camera": "DepthCamera", "sim_dispenser": "Dispenser",
    "sim_colour_camera": "ColourCamera",
    "sim_pump": "Pump",
    "sim_ph_probe": "PhProbe", "sim_furnace": "Furnace", "sim_leak_sensor": "LeakSensor",
    "sim_microscope": "Microscope", "sim_plate_reader": "PlateReader",
}  # fmt: skip
"""Driver of the simulated lab -> the same one with injected faults, in `twins.py`."""


@contextmanager
def demonstration(speed: float) -> Iterator[tuple[Path, Path]]:
    """The folder of protocols and the lab file; both are deleted afterwards."""
    folder = Path(tempfile.mkdtemp(prefix="labrun-demo-"))
    try:
        protocols = folder / "protocols"
        protocols.mkdir()
        for entry in files("labrun.protocols").iterdir():
            if entry.name.endswith(SHOWN) and not entry.name.startswith("_"):
                (protocols / entry.name).write_bytes(entry.read_bytes())
        lab = folder / "lab.yaml"
        lab.write_text(demo_lab(speed), encoding="utf-8")
        yield protocols, lab
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def demo_lab(speed: float) -> str:
    """The simulated lab at this speed, as YAML; at 0 time is only counted, without waiting."""
    import io

    loaded, _ = load_lab(None)
    assert loaded is not None
    data = loaded.lab.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
    data["name"], data["summary"] = "demo", "A simulated bench: nothing here is real"
    twins = Path(__file__).parent / "twins.py"
    for device in data["devices"].values():
        twin = TWINS.get(device["driver"])
        if twin is not None:
            device["driver"] = f"{twins}:{twin}"
            device["config"] = {**device.get("config", {}), "clock": speed or "fast"}
    out = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.sort_base_mapping_type_on_output = False  # pyright: ignore[reportAttributeAccessIssue]
    yaml.dump(data, out)
    return out.getvalue()
