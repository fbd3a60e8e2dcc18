"""What each extra costs: a clean environment for the base and for every extra, one after another.

Each is made with pip from a wheel, measured and deleted; an extra goes into a copy of the base. Size is
what site-packages takes on the disk, with the bytecode that pip compiles, in MB of 1,048,576 bytes;
packages are counted without pip, with labrun. The starts are those of `start.py`, as multiples of bare
Python in the same environment. Run:
python benchmarks/extras.py dist/labrun-0.1.0-py3-none-any.whl [EXTRA ...]
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
import zipfile
from email.parser import BytesParser
from pathlib import Path

START = Path(__file__).with_name("start.py")
BASE = "(base)"
WIDTH = 14


def extras_of(wheel: Path) -> list[str]:
    """Its extras as pyproject.toml names them, but for what only the tests need."""
    with zipfile.ZipFile(wheel) as archive:
        (metadata,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        provided = BytesParser().parsebytes(archive.read(metadata)).get_all("Provides-Extra", [])
    return sorted(name for name in provided if name != "test")


def environment(folder: Path) -> Path:
    """A new environment without pip in this folder; returns it."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
    return folder


def install(wanted: str, environment: Path) -> None:
    """By the pip of the Python that runs this."""
    python = environment / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", str(python)]
    subprocess.run([*pip, "install", "--quiet", wanted], check=True)


def size_and_packages(folder: Path) -> tuple[float, int]:
    """What the environment's site-packages take, in MB, and how many packages these are."""
    (site,) = folder.glob("lib/python*/site-packages")
    blocks = sum(path.lstat().st_blocks for path in (site, *site.rglob("*")))
    return blocks * 512 / 2**20, len(list(site.glob("*.dist-info")))


def starts(environment: Path, times: int) -> list[str]:
    """The ratios that `start.py` prints there, as it prints them."""
    command = [str(environment / "bin" / "python"), str(START), "--times", str(times)]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [line.split()[-2] for line in printed.splitlines()[2:]]


def main() -> None:
    """Print a line for each, as it is measured."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("wheel", type=Path)
    parser.add_argument("extras", nargs="*", help="by default the base and every extra")
    parser.add_argument("--times", type=int, default=5)
    given = parser.parse_args()
    wheel = given.wheel.resolve()
    headings = ("MB", "packages", "--version", "check", "server")
    print(f"{'':<{WIDTH}}" + "".join(f"{heading:>11}" for heading in headings))
    with tempfile.TemporaryDirectory() as place:
        base, copy = environment(Path(place) / "base"), Path(place) / "copy"
        install(str(wheel), base)
        for extra in given.extras or [BASE, *extras_of(wheel)]:
            shutil.copytree(base, copy, symlinks=True)
            try:
                if extra != BASE:
                    install(f"{wheel}[{extra}]", copy)
                mb, packages = size_and_packages(copy)
                cells = [f"{mb:.0f}", str(packages), *starts(copy, given.times)]
            except subprocess.CalledProcessError as fault:
                cells = [f"  not measured: {fault}"]
            shutil.rmtree(copy)
            print(f"{extra:<{WIDTH}}" + "".join(f"{cell:>11}" for cell in cells), flush=True)


if __name__ == "__main__":
    main()
