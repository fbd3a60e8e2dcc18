"""The page on optimizers: its protocol checks clean, and its lab names a driver that there is."""

import re
from pathlib import Path

from labrun.drivers.find import find_driver
from labrun.engine.check import check_file

PAGE = (Path(__file__).parents[2] / "docs/how-to/optimize.md").read_text("utf-8")
PROTOCOL, LAB = re.findall(r"```yaml\n(.*?)```", PAGE, re.S)


def test_the_protocol_checks_clean_and_every_driver_is_there(tmp_path):
    path = tmp_path / "page.yaml"
    path.write_text(PROTOCOL, encoding="utf-8")

    assert [str(problem) for problem in check_file(path, needed=True).problems] == []
    for name in re.findall(r"^\| `(\w+)` \|", PAGE, re.M):
        assert find_driver(name, tmp_path).contract == "optimizer@1"
    assert "driver: gp" in LAB
