"""The paper's analyser server as it was measured (HARDWARE, section 4), without its analyser.

`python analyser_server.py '{"port": 1234, "folder": "/tmp/x"}'` says `ready`. Every event goes as
usual unless `plans` lists something else for it, the first plan for the first call and so on. What
the laser really did stands in `shots.log`. Like the original it runs on eventlet, tells its status
twice a second, is blocked while it looks for buttons, and takes any change of the cache for a shot.
"""

import json
import os
import random
import sys
import time
from pathlib import Path

import eventlet
import eventlet.wsgi
import socketio

BUSY = "The analyzer is currently running. Please wait until it is done."
TOO_LONG = "The operation takes too long."
PLANS = {
    "measure": (
        "not_found",
        "too_long",
        "too_long_fired",
        "vanish",
        "die",
        "die_before",
        "mute",
        "late",
        "stray",
    ),
    "export": (
        "not_found",
        "too_long",
        "half",
        "die",
        "full",
        "twins",
        "same",
        "list",
        "stray",
        "stray_folder",
    ),
    "find_buttons": ("same_place", "crash"),
}


class AnalyserServer:
    def __init__(
        self,
        port,
        folder,
        plans=None,
        shot_s=0.3,
        write_s=0.5,
        find_s=0.5,
        timeout_s=1.5,
        channels=2000,
        clock_s=0.0,
        tell_s=0.5,
        drops=(),
    ):
        self.port = port
        self.folder = Path(folder)
        self.cache, self.exports = self.folder / "cache", self.folder / "exports"
        for path in (self.cache, self.exports):
            path.mkdir(parents=True, exist_ok=True)
        self.plans = {name: list(steps) for name, steps in (plans or {}).items()}
        self.shot_s, self.write_s, self.find_s = shot_s, write_s, find_s
        self.timeout_s, self.channels = timeout_s, channels
        self.clock_s = clock_s  # its clock is ahead
        self.tell_s = tell_s
        self.drops, self.joined, self.dropped = (
            drops,
            0,
            [],
        )  # connections that it ends after one status
        self.status = "IDLE"
        self.last_csv = ""
        self.sio = socketio.Server(cors_allowed_origins="*", async_mode="eventlet")
        self.app = socketio.WSGIApp(self.sio)
        self.sio.on("connect", self.connect)
        for name in ("measure", "export", "analyze", "find_buttons", "change_export_path"):
            self.sio.on(name, getattr(self, name))

    def connect(self, sid, environ):
        self.joined += 1
        if self.joined in self.drops:
            self.dropped.append(sid)

    def plan(self, event):
        left = self.plans.get(event) or []
        return left.pop(0) if left else "ok"

    def guarded(self, act):
        if self.status == "RUNNING":
            return BUSY
        self.status = "RUNNING"
        (self.folder / "running").touch()
        try:
            act()
        except Exception as fault:
            return str(fault)
        finally:
            self.status = "IDLE"
            (self.folder / "running").unlink()
        return "success"

    def measure(self, sid, data):
        plan = self.plan("measure")
        if plan == "die_before":
            os._exit(9)
        answer = self.guarded(lambda: self.shoot(plan))
        while plan == "mute":
            self.sio.sleep(1)
        return answer

    def shoot(self, plan):
        self.sio.sleep(0.05)
        if plan == "not_found":
            raise RuntimeError("The button measure was not found.")
        if plan == "too_long":
            self.sio.sleep(self.timeout_s)
            raise RuntimeError(TOO_LONG)
        if plan == "vanish":
            self.remove(sorted(self.cache.iterdir())[-1])
            return
        if plan == "stray":
            self.fire()
        self.sio.sleep(self.shot_s)
        self.fire()
        if plan == "late":
            self.sio.sleep(2.0)
        if plan == "die":
            os._exit(9)
        if plan == "too_long_fired":
            raise RuntimeError(TOO_LONG)

    def fire(self):
        with (self.folder / "shots.log").open("a") as log:
            log.write(f"{time.time():.3f}\n")
        entry = self.cache / f"shot_{time.time_ns()}"
        entry.mkdir()
        (entry / "raw.dat").write_text("raw")

    def remove(self, entry):
        (entry / "raw.dat").unlink()
        entry.rmdir()

    def export(self, sid, data):
        plan = self.plan("export")
        return self.guarded(lambda: self.write(plan))

    def write(self, plan):
        self.sio.sleep(0.1)
        if plan == "not_found":
            raise RuntimeError("The button export was not found.")
        entries = sorted(self.cache.iterdir())
        if plan == "full":
            raise OSError(28, "No space left on device", str(self.exports))
        if plan == "too_long":
            self.sio.sleep(self.timeout_s)
            raise RuntimeError(TOO_LONG)
        name = self.name()
        texts = [csv_text(entry.name, self.channels) for entry in entries] or [""]
        self.last_csv = self.last_csv if plan == "same" else texts[-1]
        files = {"1": self.last_csv, "2": csv_text(f"{self.last_csv} 2", self.channels)}
        if plan == "twins":
            files["11"] = files.pop("2")
        elif plan == "list":
            files = {f"{n}": text for n, text in enumerate(texts, 1)}
        if plan.startswith("stray"):
            stray = {"stray": "other_1.csv", "stray_folder": "2025_06_23_10_00_00/x_1.csv"}[plan]
            (self.exports / stray).parent.mkdir(exist_ok=True)
            (self.exports / stray).write_text(csv_text(stray, self.channels))
            self.sio.sleep(1.0)
        for entry in entries:  # half a second after it began, whether or not the export is whole
            self.remove(entry)
        into = self.exports / name
        into.mkdir()
        whole = 0.4 if plan == "half" else 1.0  # its own Delete breaks the export off
        growing = eventlet.spawn(
            self.grow, {into / f"{name}_{n}.csv": text for n, text in files.items()}, whole
        )
        if plan == "die":
            growing.wait()
            os._exit(9)

    def name(self):
        """The time to a second, as the original has it; two exports never share one."""
        while True:
            name = time.strftime("%Y_%m_%d_%H_%M_%S", time.localtime(time.time() + self.clock_s))
            if not (self.exports / name).exists():
                return name
            self.sio.sleep(0.1)

    def grow(self, texts, whole):
        """The answer does not wait for this."""
        pieces = 10
        for k in range(pieces):
            for path, text in texts.items():
                start, stop = (int(len(text) * whole) * n // pieces for n in (k, k + 1))
                with path.open("a", newline="") as file:
                    file.write(text[start:stop])
            eventlet.sleep(self.write_s / pieces)

    def analyze(self, sid, data):
        if not self.last_csv:
            return "[Errno 2] No such file or directory: ''", {"not_found": 0.0}
        return "success", {"669.0 - 673.0": 1234.5}

    def find_buttons(self, sid, data):
        plan = self.plan("find_buttons")
        time.sleep(self.find_s)  # the whole server stands still meanwhile
        if plan == "crash":
            raise TypeError("cannot unpack non-iterable NoneType object")
        places = [[100 + 60 * k, 80] for k in range(8)]
        return [places[0]] * 2 + places[2:] if plan == "same_place" else places

    def change_export_path(self, sid, path):
        if not Path(path).is_dir():
            return f"The path {path} does not exist."
        self.exports = Path(path)
        return "success"

    def tell(self):
        while True:
            self.sio.sleep(self.tell_s)
            self.sio.emit("status", self.status)
            self.sio.emit("export_path", str(self.exports))
            while self.dropped:
                self.sio.sleep(self.tell_s / 2)
                self.sio.disconnect(self.dropped.pop())

    def run(self):
        listener = eventlet.listen(("127.0.0.1", self.port))
        self.sio.start_background_task(self.tell)
        print(f"ready {listener.getsockname()[1]}", flush=True)
        eventlet.wsgi.server(listener, self.app, log_output=False)


def csv_text(entry, channels):
    drawn = random.Random(entry)
    rows = [f"{190 + 0.4 * k:.4f},{100 + drawn.random() * 20:.1f}" for k in range(channels)]
    return "\n".join(["wavelength,intensity", *rows]) + "\n"


if __name__ == "__main__":
    AnalyserServer(**json.loads(sys.argv[1])).run()
