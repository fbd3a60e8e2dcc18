"""Runs are found again, compared and charted, in a shell and in Python, from what each says of itself."""

import json
import re
import sqlite3
from datetime import UTC, date, datetime, timedelta

import pytest
from typer.testing import CliRunner

import labrun
from labrun.engine.commands.compare import compare
from labrun.engine.commands.label import label
from labrun.engine.commands.runs import runs
from labrun.engine.index.index import FILE, find_runs
from labrun.engine.index.wanted import NotUnderstood, wanted
from labrun.engine.journal.journal import chain
from labrun.schemas import journal as j
from labrun.schemas.messages import GoalError

MM = "$quantity"


def a_run(folder, name, began, *, params, mass=None, fate="succeeded", failed=0, text="a: 1\n"):
    """A run's folder with a journal of one action for each failure, and one more that succeeds."""
    place = folder / name
    place.mkdir(parents=True)
    (place / "protocol.yaml").write_text(text)
    (place / "run.json").write_text('{"file": "map.yaml"}')
    told = [j.Started(run=name, protocol="map", labrun="0", python="3", began=began.isoformat(),
                      params=params, roles={"shooter": "libs"})]  # fmt: skip
    for n in range(failed + 1):
        goal = {"device": "libs", "action": "measure", "effect": "once", "boot": "b"}
        id = f"{name}/main/shoot/{n + 1}"
        told.append(j.GoalSent(id=id, ledger="l", epoch=1, means="m", **goal))
        error = GoalError(name="NoPlasma", message="dark", happened="no") if n < failed else None
        state = "ABORTED" if error else "SUCCEEDED"
        told.append(j.GoalEnded(id=id, state=state, error=error))
    outputs = {} if mass is None else {"mass": {MM: [mass, "mg"]}}
    reason = "" if fate == "succeeded" else "libs was lost"
    points = j.Points(plan=2, measured=2, failed=0, left=0)
    told.append(j.Finished(fate=fate, reason=reason, points=points, outputs=outputs))
    hash = ""
    with (place / "journal.jsonl").open("w", newline="\n") as file:
        for n, record in enumerate(told, 1):
            at = (began + timedelta(seconds=n)).isoformat(timespec="milliseconds")
            rest = record.model_dump_json(exclude={"n", "at", "hash"}, exclude_none=True)
            body = f'{{"n":{n},"at":"{at.replace("+00:00", "Z")}",{rest[1:-1]}'
            hash = chain(hash, body)
            file.write(f'{body},"hash":"{hash}"}}\n')
    (place / "data.csv").write_text("key,sample,Li,fate\n1,K17,2.0,ok\n2,'=B,4.0,ok\n")
    return place


@pytest.fixture
def lab(tmp_path):
    """Three runs: an old one, one that failed yesterday, and one of today."""
    folder = tmp_path / "runs"
    now = datetime.now(UTC).replace(microsecond=0)
    a_run(folder, "old_1", datetime(2026, 1, 2, 12, tzinfo=UTC), mass=5.0,
          params={"pitch": {MM: [0.2, "mm"]}, "argon": True, "at": [{MM: [1, "mm"]}, 2]})  # fmt: skip
    a_run(folder, "lost_2", now - timedelta(days=1), fate="failed", failed=2,
          params={"pitch": {MM: [500, "um"]}, "argon": False}, text="a: 2\n")  # fmt: skip
    last = a_run(folder, "new_3", now, mass=6.0,
                 params={"pitch": {MM: [0.2, "mm"]}, "argon": True, "sample": "core 9"})  # fmt: skip
    (last / "launch.json").write_text('{"operator": "Ada", "note": "after cleaning"}')
    return folder


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("", "old_1 lost_2 new_3"),
        ("MAP", "old_1 lost_2 new_3"),
        ("ada cleaning", "new_3"),
        ('sample:"core 9"', "new_3"),
        ("sample:=b -person:", "old_1 lost_2"),
        ("pitch=200um", "old_1 new_3"),
        ("pitch>0.2mm", "lost_2"),
        ("argon=no", "lost_2"),
        ("mass>5.5mg", "new_3"),
        ("Li=3", "old_1 lost_2 new_3"),
        ("pitch>3kg", ""),
        ("outcome:failed device:libs lost", "lost_2"),
        ("on:yesterday", "lost_2"),
        ("since:2d -outcome:failed", "new_3"),
        ("until:2026-01-02", "old_1"),
        ("until:2026-01-01", ""),
    ],
)
def test_a_search_finds_what_it_says(lab, text, names):
    assert [entry.run for entry in find_runs(lab, text)] == names.split()


@pytest.mark.parametrize("text", ["colour:red", "on:someday", 'sample:"core', "since:99999999999d"])
def test_what_means_nothing_is_refused_in_a_sentence(text):
    with pytest.raises(NotUnderstood) as told:
        wanted(text, date(2026, 11, 21))

    assert text in str(told.value)


def test_the_index_is_never_the_truth(lab):
    first = find_runs(lab)
    (lab / FILE).write_bytes(b"no database" * 1000)
    damaged = find_runs(lab)
    (lab / "old_1" / "journal.jsonl").unlink()
    (lab / "new_3" / "journal.jsonl").write_text("nonsense\n")

    assert damaged == first
    assert [(one.run, one.fate) for one in find_runs(lab) if one.run != "lost_2"] == [
        ("new_3", "unreadable")
    ]


def test_in_a_shell_runs_are_labelled_found_charted_and_compared(lab, cli):
    done = cli(label, "old_1", "--sample", "K 7", "--tag", "good", "--tag", "bad", "--runs", lab)
    cli(label, "old_1", "--tag=-bad", "--note", "first light", "--runs", lab)
    found = json.loads(cli(runs, "--find", "tag:good K light", "--json", "--runs", lab).output)
    wrong = cli(label, "old_1", "--tag", "two words", "--runs", lab)
    chart = cli(runs, "--value", "mass", "--runs", lab).output
    none = cli(runs, "--value", "mas", "--runs", lab)
    own = cli(runs, "--value", "mass", "--high", "5.5 mg", "--runs", lab).output
    lone = cli(runs, "--high", "5.5 mg", "--runs", lab)
    unlike = cli(runs, "--value", "mass", "--low", "5 mm", "--runs", lab)
    told = cli(compare, "old_1", "lost_2", "new_3", "--runs", lab).output

    assert "tags good bad" in done.output
    assert [(one["run"], one["samples"], one["tags"]) for one in found] == [
        ("old_1", ["K 7", "K17", "=B"], ["good"])
    ]
    assert wrong.exit_code == 2 and "tags" in wrong.output
    assert "5 mg" in chart and "6 mg" in chart and "mean" not in chart  # two are too few for limits
    assert none.exit_code == 2 and "did you mean mass?" in none.output
    assert "new_3" in own.splitlines()[1] and own.splitlines()[1].endswith(
        "6 mg  outside of the limits"
    )
    assert own.splitlines()[2] == "high 5.5 mg: 1 of 2 outside"
    assert lone.exit_code == 2 and "name it" in lone.output
    assert unlike.exit_code == 2 and "--low 5 mm: mass is in mg" in unlike.output
    for words in ("500 um", "libs.measure NoPlasma", "-a: 1", "+a: 2", "(0 alike)"):
        assert words in told


def test_in_python_the_same_runs_are_found_and_compared(lab):
    made = labrun.compare("old_1", "lost_2", runs=lab)
    (last,) = labrun.runs(lab, find="person:Ada")
    last.label(tags=["keep"])

    assert (made.params["pitch"], made.params["at"], made.failures) == (
        ["0.2 mm", "500 um"], ["1 mm, 2", ""], {"libs.measure NoPlasma": [0, 2]},
    )  # fmt: skip
    assert made.values["mass"] == [5.0, None] and made.took_s[0] == 4.0
    assert [one.id for one in labrun.runs(lab, find="tag:keep")] == ["new_3"]
    with pytest.raises(labrun.Refused, match="there is no colour"):
        labrun.runs(lab, find="colour:red")


def test_limits_come_from_moving_ranges_and_tell_what_is_out(tmp_path):
    masses = [5.0, 5.1, 4.9, 5.0, 5.1, 9.0]
    for n, mass in enumerate(masses):
        a_run(tmp_path, f"r{n}", datetime(2026, 1, 1 + n, tzinfo=UTC), mass=mass, params={})
    made = labrun.values("mass", tmp_path)
    ranges = [abs(a - b) for a, b in zip(masses[1:], masses, strict=False)]

    assert made.high - made.mean == pytest.approx(2.66 * sum(ranges) / 5)
    assert [number for _, number in made.points if made.is_out(number)] == [9.0]
    assert made.unit == "mg"


@pytest.mark.parametrize(
    ("name", "limits", "out"),
    [
        ("mass", {"high": "5.5 mg"}, [6.0]),
        ("mass", {"low": 5.0, "high": "0.006 g"}, []),  # on the limit is not beyond it
        ("mass", {"low": "5.5"}, [5.0]),
        ("pitch", {"low": "300 um"}, [0.2, 0.2]),  # one run has it in µm
        ("pitch", {"high": 0.2}, [0.5]),
        ("data.Li", {"high": "3"}, []),
        ("data.off_mm", {"high": "500 um"}, [0.7]),
        ("mass", {"low": "5 mm"}, "low 5 mm: mass is in mg: write 3, or `3 mg`"),
        ("mass", {"high": "0,5 mg"}, "high 0,5 mg: mass is in mg"),
        ("data.Li", {"low": "1 mg"}, "low 1 mg: data.Li has no unit: write a number"),
        ("mass", {"low": "nan"}, "low nan"),
        ("mass", {"low": "6", "high": "5 mg"}, "low 6 is above high 5 mg"),
    ],
)
def test_limits_of_ones_own_tell_what_lies_beyond(lab, name, limits, out):
    (lab / "new_3" / "data.csv").write_text("key,off_mm,Li,fate\n1,0.7,3.0000000000000004,ok\n")
    if isinstance(out, str):
        with pytest.raises(labrun.Refused, match=re.escape(out)):
            labrun.values(name, lab, **limits)
        return
    made = labrun.values(name, lab, **limits)

    assert [number for _, number in made.points if made.is_out(number)] == out


@pytest.fixture
def cli():
    """Call a command as its command line does."""
    import typer

    def call(command, *words):
        app = typer.Typer()
        app.command()(command)
        return CliRunner().invoke(app, [str(word) for word in words])

    return call


def test_the_index_needs_no_place_to_write(lab, monkeypatch):
    def refused(*_, **__):
        raise sqlite3.OperationalError("attempt to write a readonly database")

    real = sqlite3.connect
    monkeypatch.setattr(
        sqlite3,
        "connect",
        lambda place, **more: real(place, **more) if place == ":memory:" else refused(),
    )

    assert len(find_runs(lab)) == 3
    assert not (lab / FILE).exists()
