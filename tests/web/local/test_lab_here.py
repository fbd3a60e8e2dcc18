"""A lab with ports: the same devices, drivers found from anywhere, nothing left that is relative."""

import json
import os

from labrun.engine.dispatch.served_lab import serve_home
from labrun.engine.lab.lab import load_lab
from labrun.web.local.lab_here import lab_here

LAB = """
name: "on"
summary: "1:30"
contracts: [./lamp.yaml]
devices:
  gantry: {contract: gantry@1, driver: sim_gantry, config: {clock: fast}}
  lamp: {contract: lamp@1, driver: "./lamp.py:Lamp", token: secret}
  scale: {contract: balance@1, url: "http://10.0.0.7:4101"}
ros: {launch: {map: ./map.yaml}}
"""
LAMP = "type: lamp@1\nstatus: {type: object}\nactions: {flash: {effect: once}}\n"


def written(folder):
    (folder / "lab.yaml").write_text(LAB)
    (folder / "lamp.yaml").write_text(LAMP)
    (folder / "lamp.py").write_text("")
    lab, problems = load_lab(folder / "lab.yaml")
    assert lab is not None, problems
    return lab


def test_every_device_with_a_driver_has_a_port_and_keeps_it(tmp_path):
    lab = written(tmp_path)
    here = lab_here(lab, tmp_path / "state").lab.devices
    again = lab_here(lab, tmp_path / "state").lab.devices

    assert here["gantry"].port != here["lamp"].port and None not in (
        here["gantry"].port,
        here["lamp"].port,
    )
    assert here["scale"].port is None and here["scale"].url == "http://10.0.0.7:4101"
    assert {name: device.port for name, device in again.items()} == {
        name: device.port for name, device in here.items()
    }


def test_it_means_the_same_from_its_own_folder(tmp_path):
    here = lab_here(written(tmp_path), tmp_path / "state")

    assert (here.lab.name, here.lab.summary) == ("on", "1:30")
    assert here.lab.devices["lamp"].driver == f"{tmp_path / 'lamp.py'}:Lamp"
    assert here.contracts["lamp@1"].actions["flash"].effect == "once"
    assert here.lab.ros is None


def test_nobody_else_may_read_its_tokens(tmp_path):
    lab_here(written(tmp_path), tmp_path / "state")

    assert (tmp_path / "state" / "lab.yaml").stat().st_mode & 0o077 == 0


def test_a_device_that_another_shell_serves_is_used_at_its_port(tmp_path):
    lab = written(tmp_path)
    before = lab_here(lab, tmp_path / "state").lab.devices["gantry"].port
    file = serve_home(lab) / "gantry" / "server.json"
    file.parent.mkdir(parents=True)
    told = {"pid": os.getpid(), "url": "http://127.0.0.1:4107", "devices": ["gantry"]}
    file.write_text(json.dumps(told))

    here = lab_here(lab, tmp_path / "state").lab.devices

    assert before != 4107 == here["gantry"].port != here["lamp"].port
