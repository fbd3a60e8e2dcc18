"""A run's report: one HTML page that needs no server, made from the run's folder."""

import csv
import html
from base64 import b64encode
from dataclasses import dataclass, field
from pathlib import Path

from ..engine.journal import read_records
from ..schemas import journal as j

ROWS_SHOWN = 50
STYLE = """
body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#1b2330}
h1{font-size:1.6rem;margin:0}h2{font-size:1.15rem;margin:2rem 0 .5rem}
.fate{display:inline-block;padding:.1rem .6rem;border-radius:1rem;background:#e6eaf0}
.succeeded{background:#d6f0dc}.failed{background:#f8d9d6}.aborted{background:#fbeec8}
table{border-collapse:collapse;font-size:.9rem}td,th{padding:.2rem .7rem;text-align:left;
border-bottom:1px solid #d8dee8}img{max-width:100%}.scroll{overflow-x:auto}
@media(prefers-color-scheme:dark){body{background:#11161d;color:#dde4ee}td,th{border-color:#2c3644}
.fate{color:#1b2330}img{background:#fff}}
"""


@dataclass(slots=True)
class Story:
    """What a journal tells, gathered for a reader."""

    started: j.Started | None = None
    began: str = ""
    ended: str = ""
    finished: j.Finished | None = None
    lives: int = 1
    sent: dict[str, int] = field(default_factory=dict)
    failed: list[tuple[str, str, str]] = field(default_factory=list)
    notes: list[tuple[str, str, str]] = field(default_factory=list)


def make(folder: Path) -> list[Path]:
    """Write `report.html` into a run's folder."""
    story = read_story(folder)
    place = folder / "report.html"
    place.write_text(page(folder, story), encoding="utf-8")
    return [place]


def read_story(folder: Path) -> Story:
    """Go through the journal once."""
    story = Story()
    labels: dict[str, str] = {}
    for record in read_records(folder / "journal.jsonl"):
        story.began = story.began or record.at
        story.ended = record.at
        match record:
            case j.Started():
                story.started = record
            case j.Resumed():
                story.lives += 1
                story.notes.append((record.at, "resumed", f"engine {record.count + 1} took over"))
            case j.GoalSent():
                label = f"{record.device}.{record.action}"
                labels[record.id] = label
                story.sent[label] = story.sent.get(label, 0) + 1
            case j.GoalEnded():
                label = labels.pop(record.id, record.id)
                if record.error is not None:
                    story.failed.append(
                        (record.at, label, f"{record.error.name}: {record.error.message}")
                    )
            case j.IterationEnded() if record.fate != "succeeded":
                story.notes.append((record.at, f"hole at {record.key}", record.message))
            case j.Answered():
                story.notes.append((record.at, f"answered by {record.by}", record.choice))
            case j.Control():
                story.notes.append((record.at, record.verb, record.by))
            case j.SafeState() if not record.confirmed:
                story.notes.append((record.at, f"{record.device} did not confirm", record.message))
            case j.StepEnded() if record.message:
                story.notes.append((record.at, "log", record.message))
            case j.Finished():
                story.finished = record
            case _:
                pass
    return story


def page(folder: Path, story: Story) -> str:
    """The whole page."""
    fate = story.finished.fate if story.finished else "interrupted"
    name = story.started.protocol if story.started else folder.name
    reason = story.finished.reason if story.finished else ""
    parts = [
        f"<h1>{_text(name)}</h1><p>{_text(folder.name)} "
        f"<span class='fate {fate}'>{fate}</span> {_text(reason)}</p>",
        _facts(story),
        *(_figure(path) for path in sorted(folder.glob("*.png"))),
        _table("Actions", ["action", "sent"], [[k, str(v)] for k, v in story.sent.items()]),
        _table("What failed", ["when", "action", "why"], [list(row) for row in story.failed]),
        _table("What else happened", ["when", "what", "more"], [list(row) for row in story.notes]),
        *(_data(path) for path in sorted(folder.glob("data*.csv"))),
    ]
    return (
        "<!doctype html><html lang='en'><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width,initial-scale=1'>"
        f"<title>{_text(name)}</title><style>{STYLE}</style>{''.join(parts)}</html>\n"
    )


def _facts(story: Story) -> str:
    rows = [["began", story.began], ["ended", story.ended], ["engines", str(story.lives)]]
    if story.started is not None:
        rows.append(["labrun", f"{story.started.labrun}, Python {story.started.python}"])
        rows += [[f"-p {name}", _value(value)] for name, value in story.started.params.items()]
        rows += [[f"role {role}", device] for role, device in story.started.roles.items()]
    if story.finished is not None:
        rows += [[f"output {n}", _value(v)] for n, v in story.finished.outputs.items()]
    return _table("The run", ["", ""], rows)


def _value(value: object) -> str:
    if isinstance(value, dict) and "$quantity" in value:
        magnitude, unit = value["$quantity"]
        return f"{magnitude:g} {unit}"
    return str(value)


def _figure(path: Path) -> str:
    data = b64encode(path.read_bytes()).decode()
    words = path.stem.replace("_", " ")
    return f"<h2>{_text(words)}</h2><img alt='{_text(words)}' src='data:image/png;base64,{data}'>"


def _data(path: Path) -> str:
    with path.open(encoding="utf-8", newline="") as file:
        lines = list(csv.reader(file))
    if not lines:
        return ""
    more = f", the first {ROWS_SHOWN} of {len(lines) - 1}" if len(lines) - 1 > ROWS_SHOWN else ""
    return _table(f"{path.name}{more}", lines[0], lines[1 : ROWS_SHOWN + 1])


def _table(title: str, header: list[str], rows: list[list[str]]) -> str:
    if not rows:
        return ""
    head = "".join(f"<th>{_text(cell)}</th>" for cell in header) if any(header) else ""
    body = "".join(f"<tr>{''.join(f'<td>{_text(c)}</td>' for c in row)}</tr>" for row in rows)
    return (
        f"<h2>{_text(title)}</h2><div class='scroll'><table>"
        f"{f'<tr>{head}</tr>' if head else ''}{body}</table></div>"
    )


def _text(value: str) -> str:
    return html.escape(str(value), quote=True)
