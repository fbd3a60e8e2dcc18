"""A messenger tells each of its receivers, over a real webhook, and knows what it has told."""

import asyncio
import json
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from threading import Thread

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.messenger import messenger, sending
from labrun.drivers.messenger.messenger import Messenger
from labrun.drivers.simulated.messenger import SimMessenger
from labrun.schemas.messages import FileContent

from ..played import played

pytestmark = pytest.mark.filterwarnings("ignore:'imghdr' is deprecated:DeprecationWarning")
GOOD = {"send": {"text": "the map is done", "to": ["ada"]}, "last_send": {}}


@pytest.mark.slow
class TestMessenger(KeepsContract):
    case = Case(
        driver=f"{Path(__file__).with_name('patient.py')}:PatientMessenger",
        slow={"pause": 2.5},
        good=GOOD,
        files={"picture": b"\x89PNG"},
        lasting="send",
    )

    def happened(self, folder, goal_id):
        return any(goal_id in told.read_text().splitlines() for told in folder.rglob("told"))


@pytest.mark.slow
class TestSimMessenger(KeepsContract):
    case = Case(
        driver="sim_messenger", config={"clock": "fast", "to": {"ada": ""}}, slow={"clock": 0.3},
        good=GOOD, files={"picture": b"\x89PNG"}, lasting="send",
    )  # fmt: skip


@pytest.fixture
def webhook():
    """The address of a service, and what it was told; /no refuses."""
    told = []

    class Hook(BaseHTTPRequestHandler):
        def do_POST(self):
            said = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            told.append(said)
            self.send_response(404 if self.path == "/no" else 200)
            self.end_headers()

        def log_message(self, *args):
            pass

    server = HTTPServer(("127.0.0.1", 0), Hook)
    thread = Thread(target=server.serve_forever)
    thread.start()
    yield f"json://127.0.0.1:{server.server_port}", told
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    async def deliver(*what, **how):
        return await sending.deliver(*what, **how, again_s=(0.0, 0.0))

    monkeypatch.setattr(messenger, "deliver", deliver)


def test_who_is_told_who_is_not_and_what_the_probe_knows(tmp_path, webhook):
    url, told = webhook
    to = {"ada": f"{url}/ada", "ben": f"{url}/no", "night": f"{url}/ada"}
    driver = Messenger(Place("people", {"to": to}, {}, tmp_path, tmp_path))

    async def story(driver):
        said = [await driver.last_send(GoalContext("r/probe/1"))]
        for number, wanted in enumerate((["ada", "night"], ["ada", "ben"], ["ben"], ["eve"])):
            try:
                goal = GoalContext(f"r/main/{number}/1")
                said.append(await driver.send(goal, text=f"{number}", to=wanted))
            except ActionFailed as fault:
                said.append(fault.name)
            said.append((await driver.last_send(GoalContext("r/probe/2")))["goal_id"])
        return said

    assert played(driver, story) == [
        {"goal_id": ""},
        {"told": ["ada", "night"]}, "r/main/0/1",
        "PartlyDelivered", "r/main/1/1",
        "NotDelivered", "r/main/2/1",
        "NobodyOfThatName", "r/main/2/1",
    ]  # fmt: skip
    assert [(one["title"], one["message"]) for one in told] == [
        ("r", "0"), ("r", "1"), ("r", "1"), ("r", "1"), ("r", "2"), ("r", "2"),
    ]  # fmt: skip


def test_a_picture_goes_with_it_and_does_not_stay(tmp_path, webhook):
    url, told = webhook
    driver = Messenger(Place("people", {"to": {"ada": url}}, {}, tmp_path, tmp_path))
    picture = FileContent(path="out/map.png", sha256="", data=b"\x89PNG")
    goal = GoalContext("r/main/a/1", files={"picture": picture})

    played(driver, lambda driver: driver.send(goal, text="done", picture="out/map.png"))

    assert [one["filename"] for one in told[0]["attachments"]] == ["map.png"]
    assert not list(tmp_path.rglob("map.png"))


def test_a_message_that_a_crash_cut_proves_nothing(tmp_path):
    driver = Messenger(Place("people", {"to": {"ada": "json://x"}}, {}, tmp_path, tmp_path))
    driver._keep("r/main/a/1", None)

    assert asyncio.run(driver.last_send(GoalContext("r/probe/1"))) == {"goal_id": None}


@pytest.mark.parametrize("config", [{}, {"to": {}}, {"to": {"ada": 3}}, {"too": {}}])
def test_a_config_without_receivers_is_refused_with_an_example(config, tmp_path):
    with pytest.raises(ValueError, match="config"):
        Messenger(Place("people", config, {}, tmp_path, tmp_path))


def test_a_rehearsal_lets_anybody_be_told(tmp_path):
    driver = SimMessenger(Place("people", {"clock": "fast"}, {}, tmp_path, tmp_path))

    told = played(driver, lambda driver: driver.send(GoalContext("r/a/1"), text="x", to=["eve"]))

    assert told == {"told": ["eve"]}
