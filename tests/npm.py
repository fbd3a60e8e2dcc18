"""What npm has locked for a folder of the project, kept from one session of tests to the next."""

import hashlib
import shutil
import subprocess
import tempfile
from pathlib import Path


def installed(locked: Path, name: str) -> Path:
    """A folder with the `node_modules` of a lock file; made once for each of its versions."""
    lock = (locked / "package-lock.json").read_bytes()
    folder = Path(tempfile.gettempdir()) / f"labrun-{name}-{hashlib.sha256(lock).hexdigest()[:12]}"
    if not folder.exists():
        half = Path(tempfile.mkdtemp(prefix=f"labrun-{name}-"))
        for file in ("package.json", "package-lock.json"):
            shutil.copy(locked / file, half)
        subprocess.run(
            ["npm", "ci", "--no-audit", "--no-fund"], cwd=half, check=True, capture_output=True
        )
        try:
            half.rename(folder)
        except OSError:  # another worker was faster
            shutil.rmtree(half)
    return folder
