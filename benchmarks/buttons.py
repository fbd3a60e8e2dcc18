"""How well recorded buttons are found: five buttons at ten sizes, in three looks, against the published way.

Needs Xvfb and a Python with tkinter: `python benchmarks/buttons.py`.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from labrun.drivers.window_program.match import Template, look_for

PROGRAM = Path(__file__).parents[1] / "tests" / "drivers" / "window_program" / "analyser_program.py"
MAIN = ("measure", "export", "sync", "delete", "sample_name")
LOOKS = ("grey", "dark", "paper")
LEFT, TOP = 60, 40


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--looks", nargs="*", default=LOOKS, choices=LOOKS)
    options.add_argument("--sizes", type=int, default=10, help="from half to double")
    given = options.parse_args()
    sizes = np.geomspace(0.5, 2.0, given.sizes)
    with screen(), TemporaryDirectory() as folder:
        print(
            f"{'look':<8}{'found':>9}{'wrong':>7}{'absent, found':>15}{'published way':>15}{'s a screen':>12}"
        )
        for look in given.looks:
            print(row(look, sizes, Path(folder)))


def row(look: str, sizes: np.ndarray, folder: Path) -> str:
    window, places = seen(folder, look, 1.0)
    recorded = [
        Template(n, window[y : y + h, x : x + w]) for n in MAIN for x, y, w, h in [places[n]]
    ]
    found = wrong = published = absent = 0
    seconds = []
    for scale in sizes:
        picture, places = seen(folder, look, float(scale))
        began = time.perf_counter()
        sights = look_for(picture, recorded)
        seconds.append(time.perf_counter() - began)
        for template in recorded:
            hit = sights[template.name].sure
            right = hit is not None and near(hit.centre, places[template.name])
            found, wrong = found + right, wrong + (hit is not None and not right)
            published += near(published_way(picture, template.picture), places[template.name])
    for n, scale in enumerate(sizes):
        name = MAIN[n % len(MAIN)]
        picture, _ = seen(folder, look, float(scale), without=[name])
        absent += len(look_for(picture, recorded)[name].hits)
    of = len(sizes) * len(MAIN)
    return (
        f"{look:<8}{f'{found}/{of}':>9}{wrong:>7}{f'{absent}/{len(sizes)}':>15}"
        f"{f'{published}/{of}':>15}{float(np.median(seconds)):>12.2f}"
    )


def near(centre: tuple[float, float], place: tuple[int, int, int, int]) -> bool:
    x, y, w, h = place
    return abs(centre[0] - x - w / 2) < w / 4 and abs(centre[1] - y - h / 2) < h / 4


def published_way(picture: np.ndarray, template: np.ndarray) -> tuple[float, float]:
    """Edges of the screen, resized in ten steps from 2 to 0.2, TM_CCOEFF not normalised, no threshold."""
    grey, shape = (cv2.cvtColor(p, cv2.COLOR_RGB2GRAY) for p in (picture, template))
    edges = cv2.Canny(shape, 50, 200)
    best, centre = -np.inf, (-1.0, -1.0)
    for scale in np.linspace(0.2, 2.0, 10)[::-1]:
        resized = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        if resized.shape[0] < edges.shape[0] or resized.shape[1] < edges.shape[1]:
            break
        fits = cv2.matchTemplate(cv2.Canny(resized, 50, 200), edges, cv2.TM_CCOEFF)
        _, score, _, (x, y) = cv2.minMaxLoc(fits)
        if score > best:
            best = score
            centre = (x + edges.shape[1] / 2) / scale, (y + edges.shape[0] / 2) / scale
    return centre


def seen(folder: Path, look: str, scale: float, **more) -> tuple[np.ndarray, dict]:
    """The program's window at a size, and where its buttons are in it."""
    from PIL import ImageGrab

    given = json.dumps(
        {"folder": str(folder), "look": look, "scale": scale, "at": [LEFT, TOP], **more}
    )
    with subprocess.Popen(
        [python_with_tk(), str(PROGRAM), given],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as program:
        assert program.stdin is not None and program.stdout is not None
        program.stdout.readline()
        program.stdin.write("places\n")
        program.stdin.flush()
        told = json.loads(program.stdout.readline().removeprefix("done "))
        picture = np.asarray(ImageGrab.grab(xdisplay=os.environ["DISPLAY"]).convert("RGB"))
        program.stdin.close()
    places = {name: (x - LEFT, y - TOP, w, h) for name, (x, y, w, h) in told.items()}
    return picture[TOP : TOP + round(340 * scale), LEFT : LEFT + round(620 * scale)], places


def python_with_tk() -> str:
    for name in (sys.executable, "/usr/bin/python3", "python3"):
        path = shutil.which(name)
        if (
            path
            and not subprocess.run([path, "-c", "import tkinter"], capture_output=True).returncode
        ):
            return path
    sys.exit("no Python here has tkinter; install it: apt-get install python3-tk")


class screen:  # noqa: N801 - read as a word: `with screen():`
    """A virtual X server."""

    def __enter__(self) -> None:
        if shutil.which("Xvfb") is None:
            sys.exit("Xvfb is not installed: apt-get install xvfb")
        read, write = os.pipe()
        arguments = ["Xvfb", "-displayfd", str(write), "-screen", "0", "1920x1200x24"]
        self.server = subprocess.Popen(arguments, pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as told:
            os.environ["DISPLAY"] = f":{told.readline().strip()}"

    def __exit__(self, *_) -> None:
        self.server.terminate()
        self.server.wait(10)


if __name__ == "__main__":
    main()
