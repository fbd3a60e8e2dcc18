"""Instruments in processes of their own, which outlive whoever talks to them."""

import json
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

PEERS = Path(__file__).parent / "peers"


class Peer:
    """A running instrument: where it is, and what it has really done."""

    def __init__(self, folder, process):
        self.folder, self.process = folder, process

    @property
    def where(self):
        return (self.folder / "where").read_text("utf-8")

    def done(self, what=None):
        lines = (self.folder / "done.jsonl").read_text("utf-8").splitlines()
        told = [json.loads(line) for line in lines]
        return [one for one in told if what in (None, one["done"])]

    def soon(self, what):
        """The same, where nothing but time says that a command has been carried out."""
        until = time.monotonic() + 500
        while not (told := self.done(what)) and time.monotonic() < until:
            time.sleep(0.02)
        return told


@contextmanager
def running_peer(folder, program="line_peer.py", **habits):
    """Start one; it ends with the block, and not with who talks to it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "where").unlink(missing_ok=True)
    (folder / "habits.json").write_text(json.dumps(habits), "utf-8")
    with (folder / "peer.log").open("ab") as log:
        words = [sys.executable, str(PEERS / program), str(folder), str(folder / "habits.json")]
        process = subprocess.Popen(words, stdout=log, stderr=log)
    try:
        until = time.monotonic() + 500
        while not (folder / "where").exists():
            assert process.poll() is None, (folder / "peer.log").read_text("utf-8")
            assert time.monotonic() < until, "the peer did not start"
            time.sleep(0.02)
        yield Peer(folder, process)
    finally:
        process.kill()
        process.wait()
