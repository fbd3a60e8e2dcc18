"""Many look through one camera at the rate of one, never while a run has it; a snapshot becomes a run's."""

import asyncio
import json
import shutil

import pytest

from labrun.engine.lab.lab import load_lab
from labrun.engine.run.snapshots import RECORD, read_snapshots
from labrun.web.devices.devices import DeviceLinks
from labrun.web.devices.looking import Looking
from labrun.web.library.timings import Timings
from labrun.web.local.lab_here import lab_here
from labrun.web.local.refusal import Refusal
from labrun.web.report.page import page
from labrun.web.report.report_data import gather
from labrun.web.runs.runs import Runs
from labrun.web.runs.snapshots import Snapshots
from labrun.web.updates.updates import Updates

FILES = {
    "lab.yaml": """\
name: small
simulated: true
contracts: [./eye.yaml]
devices:
  eye: {contract: eye@1, driver: "./eye.py:Eye"}
  gantry: {contract: gantry@1, driver: sim_gantry}
""",
    "eye.yaml": """\
type: eye@1
summary: An eye
actions:
  see:
    effect: pure
    params:
      type: object
      required: [to]
      properties: {to: {type: string, format: path, contentMediaType: image/jpeg}}
    returns: {type: object, properties: {to: {type: string, format: path}}}
""",
    "eye.py": """\
from labrun.drivers.driver import Driver
from labrun.schemas.messages import FileContent

class Eye(Driver):
    contract = "eye@1"
    looks = 0

    async def see(self, goal, *, to):
        self.looks += 1
        first = b"<svg>" if self.looks > 3 else b"\\xff\\xd8\\xff"
        goal.files["to"] = FileContent.of(to, first + str(self.looks).encode())
        return {"to": to}
""",
}


class Bench:
    """A camera served from here, and what uses it."""

    def __init__(self, folder):
        for name, text in FILES.items():
            (folder / name).write_text(text)
        self.run = None
        self.seen = asyncio.Event()
        lab = lab_here(load_lab(folder / "lab.yaml")[0], folder / "bench")
        self.links = DeviceLinks(
            lab, folder / "servers", lambda name: self.seen.set(), self.used_by, lambda name: None
        )
        self.every_s = 1000.0
        self.looking = Looking(self.links.device_link, self.used_by, lambda: self.every_s)

    def used_by(self, device):
        return self.run

    async def picture(self, **more):
        return (await self.looking.look("eye", **more))[0].file.data.removeprefix(b"\xff\xd8\xff")

    async def told(self, story):
        eye = self.links.links["eye"]
        eye.open()
        try:
            async with asyncio.timeout(500):
                while not eye.online:
                    self.seen.clear()
                    await self.seen.wait()
            return await story()
        finally:
            await self.links.close()


def test_a_snapshot_is_the_runs_and_who_looks_on_disturbs_nobody(folder, teller, tmp_path):
    teller.started().finished()
    place = tmp_path / "bench"
    place.mkdir()
    bench = Bench(place)
    runs = Runs(folder.parent, Timings(tmp_path / "timings.json"), Updates())
    snapshots = Snapshots(runs, bench.looking)

    async def story():
        both = await asyncio.gather(bench.picture(), bench.picture())
        told = await snapshots.take(folder.name, "eye", "Ada <b>")
        bench.run = "run-7"
        with pytest.raises(Refusal) as held:
            await bench.picture()
        bench.run, bench.every_s = None, 0.0
        await bench.picture()
        with pytest.raises(Refusal) as odd:
            await bench.picture()
        with pytest.raises(Refusal) as none:
            await bench.looking.look("gantry")
        with pytest.raises(Refusal, match="eye@1 has no `above`"):
            await bench.looking.look("eye", above=True)
        states = {one.name: one.camera for one in bench.links.states()}
        return both, told, [one.value for one in (held, odd, none)], states

    both, told, refused, states = asyncio.run(bench.told(story))
    held, odd, none = refused
    report = (folder / "report.html").read_text()

    assert both == [b"1", b"1"]
    assert (folder / told.file).read_bytes() == b"\xff\xd8\xff2"
    assert (told.device, told.by) == ("eye", "Ada <b>")
    assert (held.status, str(held)) == (409, "eye is not looked through while run-7 has it")
    assert str(odd) == "what eye gives is neither JPEG nor PNG"
    assert none.status == 404
    assert states == {"eye": True, "gantry": False}
    assert [one.file for one in snapshots.of(folder.name)] == [told.file]
    assert 'id="snapshots"' in report and "by Ada &lt;b&gt;" in report and told.file in report


def test_a_record_that_was_torn_keeps_the_others_and_a_picture_that_was_changed_is_named(
    folder, teller
):
    teller.started().finished()
    (folder / "snapshots").mkdir()
    line = {"device": "eye", "at": "2026-11-27T19:00:00+00:00", "sha256": "0" * 64}
    kept = [{**line, "file": "snapshots/a.jpg"}, {**line, "file": "snapshots/gone.jpg"}]
    text = "\n".join(json.dumps(one) for one in kept) + '\n{"file": "snap'
    (folder / RECORD).write_text(text)
    (folder / "snapshots" / "a.jpg").write_bytes(b"\xff\xd8\xff")

    assert [one.file for one in read_snapshots(folder)] == ["snapshots/a.jpg"]
    assert "changed since it was taken" in page(gather(folder))

    shutil.rmtree(folder / "snapshots")

    assert read_snapshots(folder) == []
