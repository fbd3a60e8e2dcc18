"""A run as MCAP, read back by the format's own reader."""

import json

import pytest
from typer.testing import CliRunner

from labrun.engine.commands.export import export
from labrun.engine.export import formats
from labrun.engine.export.formats import ExportFault
from labrun.engine.export.mcap import _kept, _widened, write
from labrun.engine.journal.journal import Journal
from labrun.schemas import journal as j
from labrun.schemas.messages import GoalError


def goal(id, **params):
    return j.GoalSent(
        id=id, device="gantry", action="move_to", params=params, effect="idempotent", boot="b",
        ledger="l", epoch=1, means="m",
    )  # fmt: skip


@pytest.fixture
def run(tmp_path):
    folder = tmp_path / "runs" / "2026-01-01_map_12345678"
    folder.mkdir(parents=True)
    (folder / "protocol.yaml").write_text("labrun: 1\n")
    (folder / "run.json").write_text("{}")
    journal = Journal(folder / "journal.jsonl", sync=False)
    lost = GoalError(name="Alarm", message="hard limit", happened="unknown")
    for record in (
        j.Started(run=folder.name, protocol="map", labrun="0", python="3"),
        goal("a", x=12.5), j.GoalEnded(id="a", state="SUCCEEDED", result={"x": 12.501}),
        goal("b", x=999), j.GoalEnded(id="b", state="ABORTED", error=lost),
        j.IterationEnded(
            loop="main/scan", index=0, key="0,0", fate="succeeded",
            row={"x": {"$quantity": [12.5, "mm"]}, "Li": 1966.5},
        ),
        j.Finished(fate="failed", reason="the gantry is in alarm"),
    ):  # fmt: skip
        journal.append(record)
    journal.flush()
    journal.close()
    return folder


def read(path):
    from mcap.reader import make_reader

    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        messages = [
            (channel.topic, schema.name, json.loads(message.data), message.log_time)
            for schema, channel, message in reader.iter_messages()
        ]
        attached = {one.name: one.data for one in reader.iter_attachments()}
    return messages, attached


def test_goals_results_rows_and_the_log_are_on_one_time(run, tmp_path):
    before = sorted(path.name for path in run.iterdir())
    write(run, tmp_path / "map.mcap")
    messages, attached = read(tmp_path / "map.mcap")
    of = {topic: [m for t, _, m, _ in messages if t == topic] for topic, *_ in messages}
    times = [time for *_, time in messages]

    assert of["/gantry/move_to"] == [{"id": "a", "x": 12.5}, {"id": "b", "x": 999}]
    done, failed = of["/gantry/move_to/result"]
    assert (done["state"], done["x"]) == ("SUCCEEDED", 12.501)
    assert failed["error"]["name"] == "Alarm"
    assert of["/rows/main/scan"] == [
        {"key": "0,0", "x": {"value": 12.5, "unit": "mm"}, "Li": 1966.5}
    ]
    assert [(one["level"], one["message"]) for one in of["/log"]] == [
        (4, "Alarm: hard limit"), (4, "failed: the gantry is in alarm"),
    ]  # fmt: skip
    assert len(of["/journal"]) == 7
    assert {schema for topic, schema, *_ in messages if topic == "/log"} == {"foxglove.Log"}
    assert times == sorted(times) and times[0] > 1_700_000_000 * 10**9
    assert attached["protocol.yaml"] == b"labrun: 1\n"
    assert sorted(path.name for path in run.iterdir()) == before


def test_each_topic_says_which_values_a_plot_can_take(run, tmp_path):
    from mcap.reader import make_reader

    write(run, tmp_path / "map.mcap")
    with (tmp_path / "map.mcap").open("rb") as file:
        found = make_reader(file).get_summary()
    schemas = {one.name: json.loads(one.data) for one in found.schemas.values()}

    number, text = {"type": "number"}, {"type": "string"}
    quantity = {"type": "object", "properties": {"value": number, "unit": text}}
    assert schemas["labrun.rows.main.scan"] == {
        "type": "object", "properties": {"key": text, "x": quantity, "Li": number},
    }  # fmt: skip
    assert schemas["labrun.gantry.move_to"]["properties"] == {"id": text, "x": number}
    assert len(schemas) == len(found.channels)


@pytest.mark.parametrize(
    ("messages", "properties"),
    [
        ([{"a": 1}, {"a": 2.5, "b": True}], {"a": {"type": "number"}, "b": {"type": "boolean"}}),
        ([{"a": 1}, {"a": "?"}, {"a": 1}, {"b": None}], {}),
        ([{"a": {}}, {"a": [1]}, {"a": 3}], {}),
        ([{"a": []}, {"a": [None, 1.5]}], {"a": {"type": "array", "items": {"type": "number"}}}),
        ([{"a": []}, {"b": [[1], [2]]}, {"c": [1, "?"]}], {}),
        ([{"a": [{"n": 1}, {"s": "?"}]}], {"a": {"type": "array", "items": {
            "type": "object", "properties": {"n": {"type": "number"}, "s": {"type": "string"}},
        }}}),
    ],
)  # fmt: skip
def test_a_schema_is_that_of_all_messages_of_its_topic(messages, properties):
    schema = None
    for message in messages:
        schema = _widened(schema, message)

    assert _kept(schema) == {"type": "object", "properties": properties}


def test_the_tokens_of_the_lab_are_not_passed_on(run, tmp_path):
    lab = {
        "name": "bench",
        "devices": {"gantry": {"url": "http://10.0.0.7:4101", "token": "secret"}},
    }
    (run / "lab.yaml").write_text(json.dumps(lab))
    write(run, tmp_path / "map.mcap")

    told = read(tmp_path / "map.mcap")[1]["lab.yaml"]

    assert b"10.0.0.7" in told
    assert b"token" not in told and b"secret" not in told


def test_a_journal_that_was_changed_is_refused_and_no_file_is_left(run, tmp_path):
    path = run / "journal.jsonl"
    path.write_text(path.read_text().replace("12.501", "12.601"))
    with pytest.raises(ExportFault, match="the chain breaks at record 3"):
        write(run, tmp_path / "map.mcap")

    assert not list(tmp_path.glob("*map.mcap*"))


@pytest.fixture
def command(run, tmp_path, monkeypatch):
    import typer

    monkeypatch.chdir(tmp_path)
    app = typer.Typer()
    app.command()(export)
    return lambda *words: CliRunner().invoke(app, [*words, "--runs", str(run.parent)])


def test_the_command_names_the_file_after_the_run(command, run, tmp_path):
    done = command("last", "--to", "mcap")

    assert done.exit_code == 0, done.output
    assert (tmp_path / f"{run.name}.mcap").read_bytes().startswith(b"\x89MCAP0")
    assert command("last", "--to", "nexus").exit_code == 0
    assert (tmp_path / f"{run.name}.nxs").read_bytes().startswith(b"\x89HDF")


def test_a_torn_journal_is_exported_to_its_last_whole_record_and_one_without_any_is_refused(
    command, run
):
    journal = run / "journal.jsonl"
    whole = journal.read_bytes()
    lines = whole.count(b"\n")
    journal.write_bytes(whole[:-5])
    torn = command("last", "--to", "mcap")

    assert torn.exit_code == 0
    assert f"exported are the {lines - 1} records before" in torn.output

    journal.write_bytes(b"")
    empty = command("last", "--to", "mcap", "--out", "empty.mcap")

    assert empty.exit_code == 2
    assert "has no whole record: there is nothing to export" in empty.output


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["last", "--to", "mcpa"], "there is no format mcpa; did you mean mcap?"),
        (["nope", "--to", "mcap"], "no run"),
        (["last", "--to", "mcap", "-o", "there/no/x.mcap"], "cannot be written"),
    ],
)
def test_what_cannot_be_exported_is_a_sentence(command, words, said):
    done = command(*words)

    assert done.exit_code in (1, 2)
    assert said in done.output


def test_a_plug_in_adds_a_format(monkeypatch):
    class Point:
        name = "vtk"

        def load(self):
            return write

    monkeypatch.setattr(formats, "entry_points", lambda group: [Point()])

    assert {*formats.formats()} == {"mcap", "nexus", "tiff", "vtk"}
    assert formats.formats()["vtk"]() is write
