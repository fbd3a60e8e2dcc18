"""An agent reads, writes, checks, rehearses, and starts only what a person has released: over stdio."""

import asyncio
import contextlib
import json
import os
import pty
import select
import subprocess
import sys

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.needs("mcp"), pytest.mark.filterwarnings("ignore")]

SCAN = """labrun: 1
name: scan
params: {pitch: {type: quantity, unit: mm, default: 2 mm}}
devices: {gantry: gantry@1}
steps:
  - id: scan
    foreach: {point: "${{ grid(x=span(0, 4 mm, params.pitch), y=span(0, 2 mm, params.pitch)) }}"}
    steps:
      - {id: go, do: gantry.move_to, with: {x: "${{ point.x }}", y: "${{ point.y }}"}}
    collect: {x: "${{ steps.go.x }}"}
"""
LABRUN = [sys.executable, "-m", "labrun.engine"]


def release(folder, *more, says=b"release\n"):
    """What a person does, in a terminal: the status and what was shown."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [*LABRUN, "release", "scan.yaml", *more], cwd=folder, stdin=theirs, stdout=theirs,
        stderr=theirs,
    )  # fmt: skip
    os.close(theirs)
    os.write(ours, says)
    shown = b""
    with contextlib.suppress(OSError):  # the end of a pseudo-terminal
        while select.select([ours], [], [], 100)[0] and (some := os.read(ours, 4096)):
            shown += some
    os.close(ours)
    return process.wait(), shown.decode()


def talk(folder, story):
    """Let a story use the SDK's own client against `labrun mcp`."""
    from mcp import Client, StdioServerParameters
    from mcp.client.stdio import stdio_client

    async def told():
        arguments = [*LABRUN[1:], "mcp", str(folder)]
        env = {**os.environ}
        with (folder / "errors.txt").open("w+") as errors:
            parameters = StdioServerParameters(command=LABRUN[0], args=arguments, env=env)
            async with Client(stdio_client(parameters, errlog=errors)) as client:

                async def call(tool, **arguments):
                    answer = await client.call_tool(tool, arguments)
                    return answer.is_error, answer.content[0].text if answer.content else ""

                await story(client, call)
            errors.seek(0)
            assert "Traceback" not in errors.read()

    asyncio.run(told())


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "secret.csv").write_text("x\n1\n")
    (tmp_path / "mine" / "bench.yaml").write_text("devices: {}\n")
    return tmp_path / "mine"


def test_an_agent_writes_checks_and_rehearses_and_starts_what_a_person_has_released(folder):
    async def story(client, call):
        tools = {tool.name for tool in (await client.list_tools()).tools}
        assert {"write_protocol", "rehearse", "launch"} <= tools
        assert not {name for name in tools if "release" in name} - {"releases"}
        assert "move_to" in (await call("contracts"))[1]
        said = await call("write_protocol", name="scan.yaml", text=SCAN.replace("move_to", "mvoe"))
        assert "has no action mvoe" in said[1] and "scan.yaml:9" in said[1]
        revision = said[1].split()[1]
        assert "give the revision" in (await call("write_protocol", name="scan.yaml", text=SCAN))[1]
        assert (await call("releases"))[1] == "there are none"
        assert (
            "no problems"
            in (await call("write_protocol", name="scan.yaml", text=SCAN, revision=revision))[1]
        )
        assert (await call("rehearse", name="scan.yaml", params={"pitch": "1 mm"}))[1].startswith(
            "succ"
        )
        assert (await call("launch", release="0000"))[0]

        status, shown = await asyncio.to_thread(release, folder, "-p", "pitch=2 mm")
        assert status == 0, shown
        (known,) = map(json.loads, (await call("releases"))[1].splitlines())
        assert known["params"] == {"pitch": "2 mm"} and known["roles"] == {"gantry": "gantry"}
        # What is written afterwards is not what a person has read.
        worse = SCAN.replace("span(0, 4 mm", "span(0, 400 mm")
        revision = (await call("check", name="scan.yaml"))[1].split()[1]
        assert not (await call("write_protocol", name="scan.yaml", text=worse, revision=revision))[
            0
        ]
        failed, words = await call("launch", release=known["id"])
        assert not failed, words
        name = words.split()[1]
        again = await call("launch", release=known["id"])
        assert again[0] and "nobody has released" in again[1]
        while '"fate": "running"' in (await call("run", name=name))[1]:  # noqa: ASYNC110
            await asyncio.sleep(0.1)
        assert '"fate": "succeeded"' in (await call("run", name=name))[1]
        assert len((await call("table", name=name))[1].splitlines()) == 1 + 3 * 2
        assert name in (await call("runs"))[1]

    talk(folder, story)
    log = [json.loads(line) for line in (folder / ".labrun" / "agents.jsonl").open()]
    launches = [line["is"] for line in log if line["tool"] == "launch"]

    assert launches == ["asked", "refused", "asked", "done", "asked", "refused"]


def test_what_an_agent_must_not_do_is_refused_in_a_sentence(folder):
    async def story(client, call):
        refused = [
            ("write_protocol", {"name": "../out.yaml", "text": SCAN}, "not a valid protocol name"),
            ("write_protocol", {"name": ".released/a/release.json", "text": SCAN}, "a dot"),
            (
                "write_protocol",
                {"name": "runs/x/protocol.yaml", "text": SCAN},
                "folder of the runs",
            ),
            ("write_protocol", {"name": "lab.yaml", "text": "devices: {}"}, "a lab's name"),
            ("write_protocol", {"name": "bench.yaml", "text": SCAN}, "choose another name"),
            ("write_protocol", {"name": "own.py", "text": "import os"}, "must end with .yaml"),
            ("write_protocol", {"name": "scan.yaml"}, "text: "),
            ("read_protocol", {"name": "../secret.csv"}, "not a valid protocol name"),
            ("read_protocol", {"name": "none.yaml"}, "there is no protocol"),
            ("run", {"name": str(folder.parent)}, "there is no run"),
            ("run", {"name": ".."}, "there is no run"),
            ("run", {"name": "last"}, "no run"),
            ("launch", {"release": "../.."}, "nobody has released"),
            ("launch", {"release": 7}, "release: "),
            ("rehearse", {"name": "scan.yaml", "fail": ["x"]}, "there is no protocol"),
            ("problem", {"code": "E999"}, "there is no problem"),
            ("runs", {"find": "since:soon"}, "since"),
            ("release", {"name": "scan.yaml"}, "release"),
        ]
        for tool, arguments, words in refused:
            failed, said = await call(tool, **arguments)
            assert failed and words in said and "Traceback" not in said, (tool, arguments, said)
        text = SCAN.replace("params:", "functions: {f: ../own.py:f}\nparams:")
        text = text.replace(
            "steps:\n  - id", "steps:\n  - set: {t: \"${{ csv('../secret.csv') }}\"}\n  - id"
        )
        said = (await call("write_protocol", name="scan.yaml", text=text))[1]
        assert said.count("outside the protocol's folder") == 2, said

    talk(folder, story)

    assert sorted(path.name for path in folder.parent.iterdir()) == ["mine", "secret.csv"]
    assert (folder / "bench.yaml").read_text() == "devices: {}\n"


def test_only_a_person_in_a_terminal_releases(folder):
    (folder / "scan.yaml").write_text(SCAN)
    piped = subprocess.run(
        [*LABRUN, "release", "scan.yaml"],
        cwd=folder,
        input="release\n",
        capture_output=True,
        text=True,
    )
    status, shown = release(folder, says=b"yes\n")

    assert piped.returncode == 2 and "a person's word" in piped.stderr
    assert status == 2 and "not released" in shown and "pitch = 2 mm" in shown
    assert [*(folder / "runs").rglob("*.yaml")] == []
