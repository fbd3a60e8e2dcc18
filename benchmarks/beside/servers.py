"""Device servers as child processes of the benchmark, while a block runs."""

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from dispatch import CONTRACT, DRIVER, LAB

from labrun.engine.dispatch.connect import server_config
from labrun.engine.lab.lab import load_lab

END_S = 5
SCRIPT = Path(__file__).with_name("nothing_server.py")


class Served(NamedTuple):
    """A device server's address and process."""

    url: str
    pid: int


@contextlib.contextmanager
def serving(folder: Path, *, synced: bool) -> Iterator[Served]:
    """A server of one device that does nothing; `folder/lab.yaml` then names it."""
    folder.mkdir()
    for name, text in (("nothing.yaml", CONTRACT), ("nothing.py", DRIVER), ("lab.yaml", LAB)):
        (folder / name).write_text(text, encoding="utf-8")
    lab, problems = load_lab(folder / "lab.yaml")
    assert lab is not None, problems
    settings = folder / "settings.json"
    config = server_config(lab.lab.devices, lab, folder / "server")
    settings.write_text(json.dumps({**config, "own_token": False}))
    flags = [] if synced else ["--unsynced"]
    command = [sys.executable, "-P", str(SCRIPT), str(settings), *flags]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            said = json.loads(process.stdout.readline() or "{}")
            if not said.get("ready"):
                raise SystemExit(f"the device server did not start: {said.get('error', said)}")
            url = said["url"]
            served = LAB.replace('driver: "./nothing.py:Nothing"', f'url: "{url}"')
            (folder / "lab.yaml").write_text(served, encoding="utf-8")
            yield Served(url, process.pid)
        finally:
            _end(process)


def _end(process: subprocess.Popen[str]) -> None:
    process.terminate()
    try:
        process.wait(END_S)
    except subprocess.TimeoutExpired:
        process.kill()
