"""Write the golden journals of this version: `python tests/engine/golden/make.py VERSION`.

Each is what a run left when it was struck down. Those of a version that was released stay as they
are for ever; a new format gets new ones beside them.
"""

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
from contextlib import closing
from pathlib import Path

HERE = Path(__file__).parent
CASES = {
    "in-mid-shot-with-its-server": {"flush": 24, "form": "after", "servers": "own"},
    "torn-record": {"flush": 33, "form": "torn", "servers": None},
    "before-a-write": {"flush": 46, "form": "before", "servers": None},
}
LEFT_OUT = ("engine.lock", "control.json", "journal.reserve", "server.json", "server.log",
            "server_settings.json", "report.html", "ro-crate-metadata.json")  # fmt: skip


def make(name: str, doom: dict, place: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        ended = subprocess.run(
            [sys.executable, "-m", "labrun.engine.torture.victim", json.dumps(doom),
             "run", str(HERE / "protocol.yaml"), "--lab", str(HERE / "lab.yaml"), "--yes",
             "--answer", "side=left", "--runs", folder],
            capture_output=True, text=True,
        )  # fmt: skip
        (run,) = Path(folder).iterdir()
        assert ended.returncode == -signal.SIGKILL, (name, ended.returncode, ended.stdout)
        for path in run.glob("servers/*/server.json"):
            os.kill(json.loads(path.read_text())["pid"], signal.SIGKILL)
        for ledger in run.glob("servers/*/ledger.sqlite"):
            with closing(sqlite3.connect(ledger)) as disk:
                disk.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        shutil.copytree(run, place / name, ignore=shutil.ignore_patterns(*LEFT_OUT))
    print(name, (place / name / "journal.jsonl").read_text().count("\n"), "records")


if __name__ == "__main__":
    version = HERE / sys.argv[1]
    shutil.rmtree(version, ignore_errors=True)
    for name, doom in CASES.items():
        make(name, doom, version)
