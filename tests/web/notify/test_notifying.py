"""Word gets out, over a real webhook, of what no engine can tell; earlier settings are read."""

import asyncio
import base64
import json
from types import SimpleNamespace

import pytest
from aiohttp import web

from labrun.engine.lab.lab import load_lab
from labrun.schemas.lab import LabNotify, Receiver
from labrun.web.local.settings_file import SettingsFile
from labrun.web.models.settings import Settings
from labrun.web.notify.notifying import NotDelivered, Notifying

pytestmark = pytest.mark.filterwarnings("ignore:'imghdr' is deprecated:DeprecationWarning")
"""Apprise brings it, for Python before 3.13."""


def run(**now):
    told = {"id": "r1", "protocol": "map", "live": True, "fate": "running"}
    return SimpleNamespace(**(told | now))


class Lab:
    """A bench that a test changes, and what was said of it."""

    def __init__(self, folder, notify=None):
        self.notify, self.runs, self.devices, self.said = notify, [], [], []
        self.notifying = Notifying(
            lambda: self.notify, lambda: self.runs, lambda: self.devices, folder, self.said.append,
            lambda: "b2",
        )  # fmt: skip
        self.notifying.again_s = (0.0, 0.01, 0.01)

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
    return runner, f"127.0.0.1:{runner.addresses[0][1]}/hook"


def test_what_is_news_and_what_is_not(tmp_path):
    lab = Lab(tmp_path)
    lab.runs = [run(live=False, fate="interrupted"), run(id="r2"), run(id="r3")]
    lab.devices = [SimpleNamespace(name="libs", reach="starting")]
    first = lab.told()
    lab.devices[0].reach = "lost"
    before = lab.told()
    lab.devices = [SimpleNamespace(name="libs", reach="online")]
    lab.told()
    lab.devices = [SimpleNamespace(name="libs", reach="lost")]
    lab.runs = [
        run(id="r2", live=False, fate="failed"),
        run(id="r3", live=False, fate="interrupted"),
    ]
    (tmp_path / "r2").mkdir()
    kept = [{"event": "done", "text": "late"}, {"lost": "nobody was told 'begun': it is off"}]
    (tmp_path / "r2" / "messages.json").write_text(json.dumps(kept))
    ended = lab.told()

    assert first == before == []
    assert ended == [
        ("done", "late"), ("failed", "map: its engine is gone; `labrun resume`"),
        ("device_lost", "libs is lost"),
    ]  # fmt: skip
    assert lab.told() == []
    assert lab.said == ["r2: nobody was told 'begun': it is off"]
    assert not (tmp_path / "r2" / "messages.json").exists()


def test_who_wants_to_hear_is_told_after_quiet_hours(tmp_path):
    async def story():
        got = []

        async def take(request):
            got.append(await request.json())
            return web.Response()

        runner, address = await served(take)
        to = [Receiver(to=f"json://{address}", on=["device_lost"]), f"json://{address}?no"]
        lab = Lab(tmp_path, LabNotify(to=to, quiet_from="00:00", quiet_to="23:59"))
        lab.devices = [SimpleNamespace(name="libs", reach="online")]
        lab.told()
        lab.devices = [SimpleNamespace(name="libs", reach="lost")]
        lab.runs = [run()]
        messages = lab.notifying.events()
        (tmp_path / "r1").mkdir()
        (tmp_path / "r1" / "element_maps.png").write_bytes(b"a map")
        kept = [{"event": "device_lost", "text": "it ended", "picture": "element_maps.png"}]
        (tmp_path / "r1" / "messages.json").write_text(json.dumps(kept))
        lab.runs = [run(live=False, fate="failed")]
        for message in messages + lab.notifying.events():
            lab.notifying.say(message)
        lab.notifying._release()
        await lab.out()
        held = list(got)
        lab.notify = lab.notify.model_copy(update={"quiet_from": ""})
        lab.notifying._release()
        await lab.out()
        await runner.cleanup()
        return held, got, lab.said

    held, got, said = asyncio.run(story())

    assert held == [] and said == []
    told = {one["title"]: (one["message"], one["attachments"]) for one in got}
    assert told["b2"] == ("libs is lost", [])
    (picture,) = told["r1"][1]
    assert (told["r1"][0], base64.b64decode(picture["base64"])) == ("it ended", b"a map")


def test_what_nobody_took_is_said_after_three_tries(tmp_path):
    async def story():
        tries = []

        async def refuse(_):
            tries.append(1)
            return web.Response(status=503)

        runner, address = await served(refuse)
        lab = Lab(tmp_path, LabNotify(to=[f"json://user:secret@{address}"], on=["failed"]))
        lab.runs = [run()]
        lab.told()
        lab.runs = [run(live=False, fate="interrupted")]
        lab.notifying.say(lab.notifying.events()[0])
        await lab.out()
        with pytest.raises(NotDelivered, match="503"):
            await lab.notifying.test(f"json://{address}")
        for wrong, words in (
            ("https://lab.org/hook", "jsons://"),
            ("foo", "^'foo' is not an address"),
        ):
            with pytest.raises(NotDelivered, match=words):
                await lab.notifying.test(wrong)
        await runner.cleanup()
        return len(tries), lab.said

    tries, said = asyncio.run(story())

    assert tries == 4
    assert len(said) == 1 and "its engine is gone" in said[0] and "503" in said[0]
    assert "secret" not in said[0]


OLD = {
    "bench": "b2",
    "receivers": [
        {"kind": "mail", "to": "ada@lab.org", "events": ["done"]},
        {"kind": "chat", "to": "https://chat.org/hooks/1", "events": ["failed", "device_lost"]},
        {"kind": "webhook", "to": "http://h.org/x", "events": []},
    ],
    "mail": {"host": "smtp.org", "port": 587, "tls": True, "user": "ada", "sender": "bench@lab.org"},
    "quiet_from": "22:00", "quiet_to": "07:00",
}  # fmt: skip
LAB = """# ours
devices:
  libs: {contract: libs_analyzer@1, driver: virtual_libs}
%s
# at the end
folders: [shared]
"""


def test_settings_of_an_earlier_version_are_addresses_now(tmp_path):
    import apprise

    password = tmp_path / "password"
    password.write_text("p@ss\n")
    OLD["mail"]["password_file"] = str(password)
    (tmp_path / "settings.json").write_text(json.dumps(OLD))

    mail, chat, hook = SettingsFile(tmp_path / "settings.json").read().receivers

    assert mail == Receiver(
        to=f"mailtos://ada:{{{password}}}@smtp.org:587/?to=ada%40lab.org&from=bench%40lab.org",
        on=["done"],
    )
    assert (chat.on, hook.on) == (["failed", "device_lost"], [])
    assert hook.to == "json://h.org/x"
    letter = apprise.Apprise.instantiate(mail.to.replace(f"{{{password}}}", "p%40ss"))
    assert (letter.smtp_host, letter.port, letter.user, letter.password) == (
        "smtp.org", 587, "ada", "p@ss",
    )  # fmt: skip


def test_a_chat_of_an_earlier_version_still_gets_its_text_alone(tmp_path):
    async def story():
        got = []

        async def take(request):
            got.append(await request.json())
            return web.Response()

        runner, address = await served(take)
        old = {"receivers": [{"kind": "chat", "to": f"http://{address}", "events": ["done"]}]}
        await Lab(tmp_path).notifying.test(Settings.model_validate(old).receivers[0].to)
        await runner.cleanup()
        return got

    assert asyncio.run(story()) == [{"text": "This is a test: messages arrive."}]


@pytest.mark.parametrize("before", ["", "notify:\n  to: [$HOOK]   # mine\n  on: [done]"])
def test_the_page_edits_the_lab_and_nothing_else_in_it(tmp_path, before):
    lab, kept = tmp_path / "lab.yaml", tmp_path / "settings.json"
    lab.write_text(LAB % before)
    notify = LabNotify(to=["$HOOK"], on=["done"]) if before else None
    settings = SettingsFile(kept, lab=lab, notify=notify)
    settings.write(settings.read().model_copy(update={"bench": "b3"}))
    untouched = lab.read_text()
    new = [*settings.read().receivers, Receiver(to="ntfy://x", on=["question"])]
    settings.write(settings.read().model_copy(update={"receivers": new}))
    edited = lab.read_text()
    loaded, _ = load_lab(lab)
    settings.write(settings.read().model_copy(update={"receivers": []}))

    assert untouched == LAB % before
    assert loaded.lab.notify.receivers == new
    assert edited.startswith("# ours\ndevices:") and "# at the end\nfolders: [shared]\n" in edited
    assert "notify" not in lab.read_text()
    assert "ntfy" not in kept.read_text()


def test_a_lab_that_cannot_be_edited_is_left_alone(tmp_path):
    lab = tmp_path / "lab.yaml"
    lab.write_text(
        "devices: {libs: {contract: libs_analyzer@1, driver: virtual_libs}}\n'notify': {to: [a://b]}\n"
    )
    settings = SettingsFile(tmp_path / "settings.json", lab=lab)
    text = lab.read_text()

    with pytest.raises(ValueError, match="by hand"):
        settings.write(Settings(receivers=[Receiver(to="ntfy://x")]))

    assert lab.read_text() == text
