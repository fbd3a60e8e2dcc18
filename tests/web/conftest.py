"""Runs' folders made by hand: a journal told record by record, with the times that a test wants."""

from datetime import UTC, datetime, timedelta
from html.parser import HTMLParser

import pytest

from labrun.engine.journal.journal import chain
from labrun.schemas import journal as j
from labrun.schemas.messages import GoalError

BEGAN = datetime(2026, 11, 21, 8, 0, 0, tzinfo=UTC)
RUN = "2026-11-21_test_0001"
VOID = {"meta", "br", "img"}


class Teller:
    """Writes a journal; `after` lets time pass before the next record."""

    def __init__(self, folder):
        self.folder = folder
        self.path = folder / "journal.jsonl"
        self.at = BEGAN
        self.n = 0
        self.hash = ""

    def after(self, seconds):
        self.at += timedelta(seconds=seconds)
        return self

    def tell(self, *records):
        with self.path.open("a", encoding="utf-8") as file:
            for record in records:
                file.write(self._line(record))
                self.at += timedelta(milliseconds=10)
        return self

    def _line(self, record):
        self.n += 1
        at = self.at.isoformat(timespec="milliseconds").replace("+00:00", "Z")
        rest = record.model_dump_json(exclude={"n", "at", "hash"}, exclude_none=True)
        body = f'{{"n":{self.n},"at":"{at}",{rest[1:-1]}'
        self.hash = chain(self.hash, body)
        return f'{body},"hash":"{self.hash}"}}\n'

    def started(self, **more):
        told = {"run": RUN, "protocol": "test", "labrun": "0.1.0", "python": "3.12.1"} | more
        return self.tell(j.Started(**told), j.Phase(phase="main"))

    def sent(
        self, path, action="libs.measure", attempt=1, effect="once", timeout_s=None, boot="b1"
    ):
        device, _, name = action.partition(".")
        return self.tell(
            j.GoalSent(
                id=f"{RUN}/{path}/{attempt}", device=device, action=name, effect=effect, boot=boot,
                ledger="l1", epoch=1, means="m", timeout_s=timeout_s,
            )
        )  # fmt: skip

    def ended(self, path, attempt=1, error="", happened="no", message="no such luck", **more):
        told = {"state": "ABORTED" if error else "SUCCEEDED"} | more
        if error:
            told["error"] = GoalError(name=error, message=message, happened=happened)
        return self.tell(j.GoalEnded(id=f"{RUN}/{path}/{attempt}", **told))

    def failed(self, path, error="ButtonNotFound", **more):
        action = more.pop("action", "libs.measure")
        effect = more.pop("effect", "once")
        self.sent(path, action=action, effect=effect, attempt=more.get("attempt", 1))
        return self.ended(path, error=error, **more)

    def worked(self, path, action="libs.measure", attempt=1, effect="once", **more):
        return self.sent(path, action, attempt, effect).ended(path, attempt=attempt, **more)

    def iteration(self, key, fate="succeeded", loop="main/scan", **more):
        return self.tell(j.IterationEnded(loop=loop, index=0, key=key, fate=fate, **more))

    def finished(self, fate="succeeded", **more):
        return self.tell(j.Finished(fate=fate, **more))


@pytest.fixture
def folder(tmp_path):
    """A run's folder with its inputs, and no journal yet."""
    made = tmp_path / RUN
    made.mkdir()
    (made / "protocol.yaml").write_text(
        "labrun: 1\nname: test\nsummary: A <b>test</b> & more\nparams:\n"
        "  pitch: {type: quantity, unit: mm, default: 1 mm, summary: how <far> apart}\n"
        "devices: {libs: libs_analyzer@1}\nsteps: [{do: libs.measure}]\n"
    )
    (made / "lab.yaml").write_text(
        "simulated: true\ndevices:\n  libs: {contract: libs_analyzer@1, driver: sim_libs, "
        "token: hush-hush}\n"
    )
    (made / "run.json").write_text(
        '{"file": "test.yaml", "params": {"pitch": "2 mm"}, "roles": {}}'
    )
    return made


@pytest.fixture
def teller(folder):
    """Tells the journal of the folder."""
    return Teller(folder)


class Outline(HTMLParser):
    """What is in a page: elements that are closed in order, ids, links, headings, tables, images."""

    def __init__(self, page):
        super().__init__()
        self.open, self.ids, self.links, self.headings = [], [], [], []
        self.tables, self.captions, self.images, self.outside = 0, 0, [], []
        self.words = []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        if tag not in VOID:
            self.open.append(tag)
        if "id" in given:
            self.ids.append(given["id"])
        if tag == "a":
            self.links.append(given["href"])
        if tag in ("h1", "h2", "h3"):
            self.headings.append(tag)
        self.tables += tag == "table"
        self.captions += tag == "caption"
        if tag == "img":
            self.images.append(given)
        self.outside += [
            v for k, v in attrs if k in ("src", "href") and v.startswith(("http", "//"))
        ]
        assert tag not in ("script", "iframe", "link", "object"), tag

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, f"{tag} is closed out of order"

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


@pytest.fixture
def outline():
    """Reads a page and refuses one whose elements are not closed in order."""
    return Outline
