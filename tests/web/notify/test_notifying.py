"""Word gets out over real sockets: a webhook with the map, a mail, quiet hours, and what nobody took."""

import asyncio
import base64
from datetime import time
from types import SimpleNamespace

import pytest
from aiohttp import web
from pydantic import ValidationError

from labrun.web.models.settings import Receiver, Settings
from labrun.web.notify.deliver import NotDelivered
from labrun.web.notify.notifying import Notifying, is_quiet

ALL = ["question", "failed", "done", "device_lost"]


def run(**now):
    told = {
        "id": "r1",
        "protocol": "map",
        "live": True,
        "fate": "running",
        "word": "",
        "reason": "",
    }
    return SimpleNamespace(**(told | {"questions": 0, "now": ""} | now))


class Lab:
    """A bench that a test changes, and what was said of it."""

    def __init__(self, folder, settings):
        self.settings, self.runs, self.devices, self.said = settings, [], [], []
        self.notifying = Notifying(
            lambda: self.settings, lambda: self.runs, lambda: self.devices, folder, self.said.append
        )
        self.notifying.again_s = (0.01, 0.01)

    def told(self):
        return [(one.event, one.text) for one in self.notifying.events()]

    async def out(self):
        await asyncio.gather(*self.notifying._sending)


async def served(handler):
    app = web.Application()
    app.router.add_post("/hook", handler)
    runner = web.AppRunner(app)
    await runner.setup()
    site = web.TCPSite(runner, "127.0.0.1", 0)
    await site.start()
    return runner, f"http://127.0.0.1:{runner.addresses[0][1]}/hook"


def test_what_is_news_and_what_is_not(tmp_path):
    lab = Lab(tmp_path, Settings())
    lab.runs = [run(live=False, fate="failed"), run(id="r2")]
    lab.devices = [SimpleNamespace(name="libs", reach="starting")]
    first = lab.told()
    lab.devices[0].reach = "lost"
    before = lab.told()
    lab.devices = [SimpleNamespace(name="libs", reach="online")]
    lab.runs = [run(id="r2", questions=1, now="core in?")]
    asked = lab.told()
    lab.devices = [SimpleNamespace(name="libs", reach="lost")]
    lab.runs = [run(id="r2", live=False, fate="failed", word="failed", reason="no argon")]
    ended = lab.told()

    assert first == before == []
    assert asked == [("question", "map is waiting for you: core in?")]
    assert ended == [("failed", "map failed: no argon"), ("device_lost", "libs is lost")]
    assert lab.told() == []


def test_a_webhook_gets_the_map_and_a_chat_the_sentence(tmp_path):
    (tmp_path / "r1").mkdir()
    (tmp_path / "r1" / "element_maps.png").write_bytes(b"PNG")

    async def story():
        got = []

        async def take(request):
            got.append(await request.json())
            return web.Response()

        runner, address = await served(take)
        receivers = [Receiver(kind="webhook", to=address, events=ALL),
                     Receiver(kind="chat", to=address, events=["done"]),
                     Receiver(kind="chat", to=address, events=["failed"])]  # fmt: skip
        lab = Lab(tmp_path, Settings(bench="b2", receivers=receivers))
        lab.runs = [run()]
        lab.notifying.events()
        lab.runs = [run(live=False, fate="succeeded", word="succeeded")]
        for message in lab.notifying.events():
            lab.notifying.say(message)
        await lab.out()
        await runner.cleanup()
        return sorted(got, key=len), lab.said

    (chat, hook), said = asyncio.run(story())

    assert chat == {"text": "b2: map is done: succeeded"}
    assert (hook["event"], hook["run"], base64.b64decode(hook["map_png"])) == ("done", "r1", b"PNG")
    assert said == []


def test_what_nobody_took_is_said_after_three_tries(tmp_path):
    async def story():
        tries = []

        async def refuse(_):
            tries.append(1)
            return web.Response(status=503)

        runner, address = await served(refuse)
        receiver = Receiver(kind="chat", to=address, events=ALL)
        lab = Lab(tmp_path, Settings(receivers=[receiver]))
        lab.notifying.say(lab.notifying._message("failed", "map failed"))
        await lab.out()
        with pytest.raises(NotDelivered, match="503"):
            await lab.notifying.test(receiver, lab.settings)
        await runner.cleanup()
        return len(tries), lab.said

    tries, said = asyncio.run(story())

    assert tries == 4
    assert len(said) == 1 and "map failed" in said[0] and "answered 503" in said[0]


def test_a_mail_has_the_map_in_it(tmp_path):
    (tmp_path / "r1").mkdir()
    (tmp_path / "r1" / "line_scan.png").write_bytes(b"PNG")

    async def story():
        letter = []

        async def speak(reader, writer):
            writer.write(b"220 test\r\n")
            while line := await reader.readline():
                word = line[:4].upper()
                if word == b"DATA":
                    writer.write(b"354 go on\r\n")
                    while (text := await reader.readline()) != b".\r\n":
                        letter.append(text)
                    writer.write(b"250 taken\r\n")
                elif word == b"QUIT":
                    writer.write(b"221 bye\r\n")
                    break
                else:
                    writer.write(b"250 ok\r\n")
            writer.close()

        server = await asyncio.start_server(speak, "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]
        mail = {"host": "127.0.0.1", "port": port, "sender": "bench@lab.org"}
        receiver = Receiver(kind="mail", to="ada@lab.org", events=ALL)
        lab = Lab(tmp_path, Settings(bench="b2", receivers=[receiver], mail=mail))
        lab.notifying.say(lab.notifying._message("done", "map is done", run="r1"))
        await lab.out()
        server.close()
        return b"".join(letter), lab.said

    letter, said = asyncio.run(story())

    assert said == []
    assert b"Subject: b2: map is done" in letter and b"To: ada@lab.org" in letter
    assert b'filename="map.png"' in letter and base64.b64encode(b"PNG") in letter


def test_quiet_hours_hold_what_comes_until_they_are_over(tmp_path):
    async def story():
        got = []

        async def take(request):
            got.append((await request.json())["text"])
            return web.Response()

        runner, address = await served(take)
        receivers = [Receiver(kind="chat", to=address, events=ALL)]
        lab = Lab(tmp_path, Settings(receivers=receivers, quiet_from="00:00", quiet_to="23:59"))
        lab.notifying.say(lab.notifying._message("done", "map is done"))
        lab.notifying._release()
        await lab.out()
        held = list(got)
        lab.settings = lab.settings.model_copy(update={"quiet_from": "", "quiet_to": ""})
        lab.notifying._release()
        await lab.out()
        await runner.cleanup()
        return held, got

    held, got = asyncio.run(story())

    assert held == []
    assert got == ["bench: map is done"]


def test_quiet_hours_may_go_over_midnight():
    settings = Settings(quiet_from="22:00", quiet_to="07:00")

    assert [is_quiet(settings, time(hour)) for hour in (21, 22, 3, 7)] == [False, True, True, False]
    assert not is_quiet(Settings(), time(3))


@pytest.mark.parametrize(
    "wrong", [("mail", "ada"), ("chat", "ftp://x"), ("webhook", "file:///etc")]
)
def test_an_address_that_is_none_is_refused(wrong):
    with pytest.raises(ValidationError, match="address"):
        Receiver(kind=wrong[0], to=wrong[1], events=ALL)
