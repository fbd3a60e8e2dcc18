"""A screen of its own (Xvfb), the analyser's program on it, and the driver beside the test."""

import asyncio
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext, Place

from ...python_with_tk import python_with_tk

HERE = Path(__file__).parent
PROGRAM = HERE / "analyser_program.py"
SCREEN = "1920x1200x24"
QUICK = {
    "measure_s": 30, "hang_s": 10, "busy_s": 10, "dialog_s": 20, "export_s": 30, "settle_s": 0.4,
    "channels": 2000,
}  # fmt: skip
MAIN = ("measure", "export", "sync", "delete", "sample_name")


@pytest.fixture(scope="session")
def screen():
    """An X server for this session; pyautogui binds itself to it at its first import."""
    read, write = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", SCREEN, "-nolisten", "tcp"],
        pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(write)
    with os.fdopen(read) as told:
        number = told.readline().strip()
    before = os.environ.get("DISPLAY")
    os.environ["DISPLAY"] = f":{number}"
    yield os.environ["DISPLAY"]
    if before is None:
        del os.environ["DISPLAY"]
    else:
        os.environ["DISPLAY"] = before
    x11 = sys.modules.get("pyautogui._pyautogui_x11")
    if x11 is not None:
        x11._display.close()
    server.terminate()
    server.wait(10)


def grabbed():
    """The whole screen, rows x columns x 3."""
    import numpy as np
    from PIL import ImageGrab

    return np.asarray(ImageGrab.grab(xdisplay=os.environ["DISPLAY"]).convert("RGB"))


class Analyser:
    """The program in a process of its own, which takes orders to misbehave."""

    def __init__(self, folder: Path, **options) -> None:
        self.folder = folder
        self.options = {"folder": str(folder), **options}
        self.process: subprocess.Popen[str] | None = None

    def start(self) -> "Analyser":
        self.process = subprocess.Popen(
            [str(python_with_tk()), str(PROGRAM), json.dumps(self.options)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env={**os.environ},
        )  # fmt: skip
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"
        return self

    def order(self, line: str) -> str:
        """Give an order and wait until it was obeyed."""
        self.tell(line)
        assert self.process is not None and self.process.stdout is not None
        return self.process.stdout.readline().strip().removeprefix("done ")

    def tell(self, line: str) -> None:
        """Give an order and do not wait."""
        assert self.process is not None and self.process.stdin is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def places(self) -> dict[str, tuple[int, int, int, int]]:
        return {name: tuple(box) for name, box in json.loads(self.order("places")).items()}

    def end(self) -> None:
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
        if self.process is not None:
            self.process.communicate()

    def shots(self) -> int:
        log = self.folder / "shots.log"
        return len(log.read_text().splitlines()) if log.exists() else 0

    def entries(self) -> set[str]:
        return {path.name for path in (self.folder / "cache").iterdir()}


def record(folder: Path, look: str, work: Path) -> Path:
    """The buttons of a look, recorded at its natural size as a person would do it."""
    from labrun.drivers.window_program.hands import Hands
    from labrun.drivers.window_program.recording import Marked, cut, save

    Hands().move(1800, 1100)  # a button under the mouse looks otherwise
    analyser = Analyser(work, look=look).start()
    try:

        def take(*names: str, suffix: str = "", at: dict | None = None) -> None:
            places, picture = analyser.places(), grabbed()
            marked = Marked({f"{n}{suffix}": places[n] for n in names}, at or {})
            save(folder, cut(picture, marked), marked, "Profile Builder", picture)

        take(*MAIN, at={"sample_name": (110, 0)})
        analyser.order("open ask_all")
        take("folder", "separate_spectrum", "new_folder", "export_finish", "export_cancel",
             at={"folder": (90, 0)})  # fmt: skip
        analyser.end()
        analyser = Analyser(work, look=look, ticked=["separate_spectrum", "new_folder"]).start()
        analyser.order("open ask_all")
        take("separate_spectrum", "new_folder", suffix=".on")
        analyser.end()
        analyser = Analyser(work, look=look).start()
        analyser.order("error Interlock open")
        take("error", "error_close")
        analyser.end()
        (work / "cache" / "shot_1").mkdir(parents=True, exist_ok=True)
        analyser = Analyser(work, look=look).start()
        analyser.order("open ask_delete")
        take("delete_yes")
    finally:
        analyser.end()
    return folder


@pytest.fixture(scope="session")
def recorded(screen, tmp_path_factory):
    """look -> a folder of its recorded buttons, each made when it is first wanted."""
    made: dict[str, Path] = {}

    def buttons(look: str = "grey") -> Path:
        if look not in made:
            work = tmp_path_factory.mktemp(f"record-{look}")
            made[look] = record(work / "buttons", look, work / "program")
        return made[look]

    return buttons


class GuiBench:
    """The program, its folders, and drivers for it."""

    def __init__(self, folder: Path, recorded) -> None:
        self.folder = folder
        self.recorded = recorded
        self.analysers: list[Analyser] = []

    def start(self, **options) -> Analyser:
        self.recorded(options.get("look", "grey"))  # on an empty screen
        analyser = Analyser(self.folder / "program", **options).start()
        self.analysers.append(analyser)
        return analyser

    def config(self, look: str = "grey", **more) -> dict:
        program = self.folder / "program"
        for name in ("cache", "exports"):
            (program / name).mkdir(parents=True, exist_ok=True)
        return {
            "buttons": str(self.recorded(look)), "cache": str(program / "cache"),
            "exports": str(program / "exports"), **QUICK, **more,
        }  # fmt: skip

    def driver(self, look: str = "grey", **config):
        from labrun.drivers.sciaps_gui.driver import SciapsGui

        mine = self.folder / "mine"
        return SciapsGui(Place("libs", self.config(look, **config), {}, mine, self.folder))

    def play(self, story, look: str = "grey", **config):
        """Run a story with an open driver."""

        async def played():
            driver = self.driver(look, **config)
            await driver.open()
            try:
                return await story(driver)
            finally:
                await driver.close()

        return asyncio.run(played())

    def fails(self, story, look: str = "grey", **config) -> ActionFailed:
        """How a story fails."""
        with pytest.raises(ActionFailed) as caught:
            self.play(story, look, **config)
        return caught.value

    @staticmethod
    async def spectrum(driver, shot: str, goal: str = "export") -> bytes:
        context = GoalContext(goal)
        await driver.export(context, shot=shot, file="a.csv")
        return context.files["file"].data

    def end(self) -> None:
        for analyser in self.analysers:
            analyser.end()


@pytest.fixture
def seen_at(screen, tmp_path):
    """The program's window in a look and at a size, and name -> where its parts are in it."""

    def seen(look: str, scale: float, **options):
        left, top = 60, 40
        analyser = Analyser(tmp_path, look=look, scale=scale, at=[left, top], **options).start()
        try:
            places = {n: (x - left, y - top, w, h) for n, (x, y, w, h) in analyser.places().items()}
            screen = grabbed()
        finally:
            analyser.end()
        return screen[top : top + round(340 * scale), left : left + round(620 * scale)], places

    return seen


@pytest.fixture
def gui(screen, recorded, tmp_path):
    bench = GuiBench(tmp_path, recorded)
    yield bench
    bench.end()
