"""Real `labrun web` processes on loopback, with the clients that a page and a program would be."""

import asyncio
import contextlib
import json
import os
import secrets
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import httpx
import pytest
import socketio

from labrun.drivers.server import tokens

LAB = """\
name: small
simulated: true
devices:
  gantry:
    contract: gantry@1
    driver: sim_gantry
    config: {{clock: {clock}, homed: true}}
    limits: {{x: {{minimum: 0, maximum: 730}}, y: {{minimum: 0, maximum: 400}}}}
  libs:
    contract: libs_analyzer@1
    driver: sim_libs
    config: {{clock: {clock}, gantry: gantry, core: 3, seed: 1}}
"""
GRID = """\
# A small map
labrun: 1
name: grid
summary: A few points
params:
  sample: {type: string, default: core}
  pitch: {type: quantity, unit: mm, default: 1 mm, minimum: 0.1 mm}
devices: {gantry: gantry@1, libs: libs_analyzer@1}
defaults: {timeout: 60 s}
steps:
  - id: scan
    foreach:
      point: ${{ grid(x=span(0, 2 mm, params.pitch), y=span(0, 1 mm, params.pitch), order='snake') }}
    key: ${{ point.ix }},${{ point.iy }}
    keep_going: {max_failed: 3}
    steps:
      - {id: travel, do: gantry.move_to, with: {x: "${{ point.x }}", y: "${{ point.y }}", z: 0 mm}}
      - {id: shoot, do: libs.measure, retry: 2}
      - id: export
        do: libs.export
        with: {shot: "${{ steps.shoot.shot_id }}", file: "spectra/${{ point.ix }}_${{ point.iy }}.csv"}
    collect: {x: "${{ point.x }}", y: "${{ point.y }}", Li: "${{ point.index + 0.5 }}"}
finally:
  - {do: gantry.move_to, with: {z: 5 mm}}
"""
TALK = """\
labrun: 1
name: talk
devices: {gantry: gantry@1}
defaults: {timeout: 60 s}
steps:
  - {id: ready, confirm: "Is the bench clear?"}
  - {id: go, do: gantry.move_to, with: {x: 5 mm}}
"""
LONG = """\
labrun: 1
name: long
devices: {gantry: gantry@1}
defaults: {timeout: 60 s}
steps:
  - id: walk
    foreach: {i: "${{ range(12) }}"}
    steps:
      - {id: there, do: gantry.move_to, with: {x: "${{ 20 * i + 20 }}", feed: 2500}}
    collect: {i: "${{ i }}"}
"""
ASKS_MIDWAY = """\
labrun: 1
name: midway
devices: {gantry: gantry@1}
defaults: {timeout: 60 s}
steps:
  - id: out
    foreach: {i: "${{ range(4) }}"}
    steps: [{id: there, do: gantry.move_to, with: {x: "${{ 20 * i + 20 }}", feed: 200}}]
  - {id: ready, confirm: "Is the bench clear?"}
  - id: on
    foreach: {i: "${{ range(4) }}"}
    steps: [{id: farther, do: gantry.move_to, with: {x: "${{ 20 * i + 100 }}"}}]
"""
PROTOCOLS = {"grid.yaml": GRID, "talk.yaml": TALK, "long.yaml": LONG, "midway.yaml": ASKS_MIDWAY}
LASER_LIST = ["enclosure closed", "nobody in the beam path", "sample fixed"]


@dataclass
class House:
    """One server process in its folder; it can be killed and started again."""

    folder: Path
    arguments: list[str] = field(default_factory=list)
    url: str = ""
    token: str = ""
    """The one that the server has made, as this user's commands find it."""
    process: subprocess.Popen | None = None
    library: Path | None = None
    entry: str = ""
    clients: list = field(default_factory=list)

    def start(self, *, port=0):
        self.process = subprocess.Popen(
            [sys.executable, "-m", "labrun.engine", "web", *self.arguments, "--no-browser",
             "--port", str(port)],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=self.folder,
        )  # fmt: skip
        said = self.process.stdout.readline()
        assert said.startswith("labrun web at "), said + self.process.stdout.read()
        self.url = said.split()[-1].partition("/?token=")[0]
        self.token = tokens.found(self.url) or ""
        self.entry = tokens.with_token(self.url, self.token) if self.token else self.url
        self.library = Path(self.process.stdout.readline().split()[2].rstrip(","))
        return self

    def kill(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        said, _ = self.process.communicate()
        return said

    def client(self, **more):
        """A browser that is signed in, where no token was chosen."""
        client = Client(self.url, **more)
        if self.token:
            client.get(self.entry)
        else:
            client.get("/session")
        self.clients.append(client)
        return client

    @property
    def authorization(self):
        """What a program says that knows the token, where one is wanted."""
        token = self.token or dict(pairwise(self.arguments)).get("--token")
        return {"Authorization": f"Bearer {token}"} if token else {}

    @property
    def servers(self):
        return self.library / ".labrun" / "web" / "bench" / "servers"

    def truth(self, device):
        path = self.servers / "world" / "truth" / f"{device}.jsonl"
        return [json.loads(line) for line in path.read_text().splitlines()]

    def server_pid(self, device):
        return json.loads((self.servers / device / "server.json").read_text())["pid"]


class Client(httpx.Client):
    """A browser: its cookie, and its commands with all their headers."""

    def __init__(self, url, **more):
        super().__init__(base_url=f"{url}/api/v1", timeout=500, **more)
        self.lease = None

    def take(self, name="Ada", **more):
        answer = self.post("/control/take", json={"name": name, **more}, headers=self._leased())
        if answer.status_code == 200:
            self.lease = answer.json()["lease"]
        return answer

    def command(
        self, path, json=None, *, content=None, method="post", key=None, until=30.0, **headers
    ):
        told = {
            "Idempotency-Key": key or secrets.token_hex(8),
            "X-Deadline": str((time.time() + until) * 1000), **self._leased(), **headers,
        }  # fmt: skip
        if content is not None:
            told = {"Content-Type": "application/json", **told}
        return self.request(method, path, json=json, content=content, headers=told)

    def _leased(self):
        return {"X-Control-Lease": self.lease} if self.lease else {}

    def reach(self, *devices):
        """Wait until devices are online."""
        wait_for(
            lambda: all(self.get(f"/devices/{d}").json()["reach"] == "online" for d in devices),
            f"{devices} online",
        )
        return self

    def run_of(self, protocol, **more):
        """Start a protocol and wait for the name of its run."""
        asked = {"protocol": protocol, "checklist": LASER_LIST, **more}
        launch = self.command("/runs", asked)
        assert launch.status_code == 202, launch.text
        id = launch.json()["id"]
        wait_for(lambda: self.get(f"/launches/{id}").json()["run"], "a run")
        return self.get(f"/launches/{id}").json()["run"]

    def run(self, id):
        return self.get(f"/runs/{id}").json()

    def until(self, id, *fates):
        wait_for(lambda: self.run(id)["fate"] in fates, f"{id} {fates}")
        if set(fates) & {"succeeded", "failed", "aborted"}:  # its engine still writes the report
            wait_for(lambda: not self.run(id)["live"], f"{id} to be over")
        return self.run(id)


def wait_for(true, what, seconds=500):
    until, pause_s = time.monotonic() + seconds, 0.02
    while time.monotonic() < until:
        found = true()
        if found:
            return found
        time.sleep(pause_s)
        pause_s = min(1.3 * pause_s, 0.25)  # each look is a request, which costs both sides
    raise AssertionError(f"waited {seconds} s for {what}")


@pytest.fixture(name="wait_for")
def _wait_for():
    return wait_for


def make_house(folder, clock="fast", protocols=None, arguments=(), lab=LAB, beside=None):
    """Protocols and a lab in a folder, not served yet; `beside` are files beside the lab."""
    library = folder / "protocols"
    library.mkdir(parents=True)
    for name, text in (protocols or PROTOCOLS).items():
        (library / name).parent.mkdir(parents=True, exist_ok=True)
        (library / name).write_text(text)
    (folder / "lab.yaml").write_text(lab.format(clock=clock))
    for name, text in (beside or {}).items():
        (folder / name).write_text(text)
    return House(folder, [str(library), "--lab", str(folder / "lab.yaml"), *arguments])


def end(house):
    """Stop the server, the runs that it left, and the device servers that they used."""
    for client in house.clients:
        client.close()
    if house.process is not None and house.process.poll() is None:
        with contextlib.suppress(httpx.HTTPError):
            client = house.client(headers=house.authorization)
            client.post("/stop")
            wait_for(lambda: not any(r["live"] for r in client.get("/runs").json()), "no run", 500)
            client.close()
        house.stop()
    for path in house.servers.glob("*/server.json"):
        with contextlib.suppress(OSError, ValueError):
            os.kill(json.loads(path.read_text())["pid"], signal.SIGKILL)


def _lasting(tmp_path_factory):
    made = []

    def make(**more):
        made.append(make_house(tmp_path_factory.mktemp("lasting"), **more))
        return made[-1].start()

    yield make
    for one in made:
        end(one)


lasting = pytest.fixture(scope="module", name="lasting")(_lasting)
lasting_over_files = pytest.fixture(scope="session", name="lasting_over_files")(_lasting)


@pytest.fixture(scope="module")
def lasting_demo(tmp_path_factory):
    """The demonstration, twenty times faster than real."""
    house = House(tmp_path_factory.mktemp("demo"), ["--demo", "--speed", "20"]).start()
    yield house
    end(house)


@pytest.fixture(scope="session")
def shared(lasting_over_files):
    """A server that all tests share which leave it as it was, but for runs and protocols."""
    return lasting_over_files()


@pytest.fixture(scope="session")
def unhurried(lasting_over_files):
    """Another one, whose gantry takes as long as a real one."""
    return lasting_over_files(clock=1)


@pytest.fixture(scope="session")
def finished(shared):
    """The name of a run of six points on the shared server, done."""
    client = shared.client().reach("gantry", "libs")
    client.take("Ada", reason="a run to look at")
    run = client.run_of("grid.yaml", params={"sample": "core17"})
    client.until(run, "succeeded")
    client.post("/control/release", headers=client._leased())
    return run


@pytest.fixture
def house(tmp_path):
    """Makes servers of a test's own: `house(clock=1)`; all are ended after it."""
    made = []

    def make(**more):
        made.append(make_house(tmp_path / f"house{len(made)}", **more))
        return made[-1].start()

    yield make
    for one in made:
        end(one)


@pytest.fixture
def page(shared):
    """A browser with control of the shared server."""
    client = shared.client()
    client.take("Ada", reason="a test begins")
    yield client
    client.post("/control/release", headers=client._leased())
    client.close()


@pytest.fixture
def hand(unhurried):
    """A browser with control of the unhurried server; what it leaves moving is stopped."""
    client = unhurried.client()
    client.take("Ada", reason="a test begins")
    yield client.reach("gantry")
    client.post("/stop")
    wait_for(lambda: not any(run["live"] for run in client.get("/runs").json()), "no run")
    client.post("/control/release", headers=client._leased())
    client.close()


class Socket:
    """A page's socket, in a thread of its own: what it was told, in order."""

    def __init__(self, house, cookies, **headers):
        self.told = []
        self.loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=self.loop.run_forever)
        self.thread.start()
        self.sio = self.do(self._client())
        cookie = "; ".join(f"{name}={value}" for name, value in cookies.items())
        try:
            self.do(self._open(house.url, {"Cookie": cookie, **headers}))
        except BaseException:
            self.close()
            raise

    async def _client(self):
        sio = socketio.AsyncClient(reconnection=False, handle_sigint=False)
        for event in ("snapshot", "patch", "run_patch", "log", "notice"):
            sio.on(event, lambda data, e=event: self.told.append((e, data)), namespace="/ui")
        return sio

    async def _open(self, url, headers):
        await self.sio.connect(
            url, headers=headers, transports=["websocket"], namespaces=["/ui"], wait_timeout=500
        )

    def do(self, work):
        return asyncio.run_coroutine_threadsafe(work, self.loop).result(timeout=500)

    def all(self, event):
        return [data for kind, data in list(self.told) if kind == event]

    def call(self, event, data=None):
        return self.do(self.sio.call(event, data or {}, namespace="/ui", timeout=500))

    def emit(self, event, data):
        self.do(self.sio.emit(event, data, namespace="/ui"))

    def close(self):
        if self.loop.is_running():
            self.do(self._close())
            self.loop.call_soon_threadsafe(self.loop.stop)
            self.thread.join(timeout=500)
            self.loop.close()

    async def _close(self):
        await self.sio.disconnect()
        if self.sio.eio.http is not None:
            await self.sio.eio.http.close()
        rest = asyncio.all_tasks() - {asyncio.current_task()}
        for task in rest:
            task.cancel()
        await asyncio.gather(*rest, return_exceptions=True)


@pytest.fixture
def socket():
    """Opens sockets and closes them after the test."""
    opened = []

    def make(house, client, **headers):
        cookies = client if isinstance(client, dict) else dict(client.cookies)
        opened.append(Socket(house, cookies, **headers))
        return opened[-1]

    yield make
    for one in opened:
        one.close()
