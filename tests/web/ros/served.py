"""`labrun ros` as a process of its own, and what tests ask of it."""

import os
import re
import select
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

START_S = 500


@dataclass
class Served:
    """A running `labrun ros` in a folder of its own."""

    process: subprocess.Popen
    url: str
    folder: Path
    said: str
    """What stood on the terminal until it served."""

    @property
    def bare(self) -> str:
        """Its address without the token."""
        return self.url.partition("/?")[0]

    @property
    def path(self) -> str:
        """What a client asks this address for."""
        return self.url.removeprefix(self.bare) or "/"

    def end(self) -> int:
        """Ctrl-C, and its exit status."""
        self.process.send_signal(signal.SIGINT)
        with self.process.stdout:
            return self.process.wait()


def serve(folder: Path, *options: str, lab: Path | None = None) -> Served:
    """Start it; returns once it listens."""
    command = [sys.executable, "-P", "-m", "labrun.engine", "ros", "--port", "0"]
    command += ["--lab", str(lab)] if lab is not None else []
    log = (folder / "ros.log").open("ab")
    process = subprocess.Popen(
        [*command, *options], cwd=folder, stdout=subprocess.PIPE, stderr=log, stdin=subprocess.DEVNULL,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )  # fmt: skip
    log.close()
    return Served(process, *_address(process, folder))


def _address(process: subprocess.Popen, folder: Path) -> tuple[str, Path, str]:
    until, said = time.monotonic() + START_S, b""
    assert process.stdout is not None
    while time.monotonic() < until and process.poll() is None:
        if select.select([process.stdout], [], [], 0.5)[0]:
            said += os.read(process.stdout.fileno(), 4096)
        found = re.search(rb"labrun ros at (\S+)\n", said)
        if found and b"Ctrl-C ends it" in said:
            return found[1].decode(), folder, said.decode()
    process.kill()
    process.communicate()
    raise AssertionError(f"it did not start: {said.decode()} {(folder / 'ros.log').read_text()}")


def command(folder: Path, *options: str) -> subprocess.CompletedProcess:
    """`labrun ros` where it ends by itself."""
    return subprocess.run(
        [sys.executable, "-P", "-m", "labrun.engine", "ros", *options],
        cwd=folder, capture_output=True, text=True, stdin=subprocess.DEVNULL,
    )  # fmt: skip
