"""Do what the first steps say, in temporary folders, and keep the pictures.

`python docs/first-steps/run.py [PAGE...]` does it for these, such as `chemist`, or for all of them.

A code block whose first line is `# NAME` is that file; the blocks of `sh` are one script, which has to
end well. A picture that a page shows from beside itself is copied from where the script left it.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.S | re.M)
PICTURE = re.compile(r"!\[[^\]]*\]\(([\w.]+)\)")
LIMIT_S = 600.0


def files(text: str) -> dict[str, str]:
    """The files that a page shows."""
    named = ((re.match(r"# (\S+\.\w+)\n", body), body) for _, body in BLOCK.findall(text))
    return {name[1]: body for name, body in named if name}


def script(text: str) -> str:
    """What a page tells its reader to type."""
    return "".join(body for kind, body in BLOCK.findall(text) if kind == "sh")


def run(page: Path) -> None:
    """Do what a page says; raises CalledProcessError where that does not end well."""
    text = page.read_text("utf-8")
    with tempfile.TemporaryDirectory(prefix=f"labrun-{page.stem}-") as folder:
        for name, body in files(text).items():
            Path(folder, name).write_text(body, encoding="utf-8")
        path = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
        subprocess.run(
            ["bash", "-euc", f"trap 'kill $(jobs -p) 2>/dev/null || true' EXIT\n{script(text)}"],
            cwd=folder, env={**os.environ, "PATH": path, "MPLBACKEND": "agg"}, check=True,
            timeout=LIMIT_S,
        )  # fmt: skip
        for name in PICTURE.findall(text):
            shutil.copyfile(next(Path(folder).rglob(name)), HERE / name)


if __name__ == "__main__":
    for page in [HERE / f"{name}.md" for name in sys.argv[1:]] or sorted(HERE.glob("*.md")):
        began = time.monotonic()
        run(page)
        print(f"== {page.stem}: all of it ended well, in {time.monotonic() - began:.0f} s")
