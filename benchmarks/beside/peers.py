"""Time another library: its script in this folder, run by an interpreter that has it."""

import json
import subprocess
from pathlib import Path
from typing import Any

LIMIT_S = 60
HERE = Path(__file__).parent


def ask_peer(python: str, script: str, *words: object) -> dict[str, Any]:
    """The script's results; `missing` or `failed`, as text, if it could not run."""
    command = [python, str(HERE / script), *map(str, words)]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=LIMIT_S, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired:
        return {"failed": f"{script} did not end within {LIMIT_S} s"}
    except OSError as fault:
        return {"failed": f"{python} cannot be run: {fault.strerror}"}
    if done.returncode:
        return {"failed": (done.stderr.splitlines() or [f"{script} printed nothing"])[-1]}
    return json.loads(done.stdout.splitlines()[-1])
