"""Device servers as child processes: started, found again, ended."""

import asyncio
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from labrun.drivers.client import launch
from labrun.drivers.client.launch import (
    ServerFailed,
    keep_running,
    start_patiently,
    start_server,
)
from labrun.drivers.server.ledger import Ledger


def test_a_server_is_started_apart_from_the_terminal_and_ended(bench):
    async def story():
        server = await start_server(bench.settings(), bench.folder)
        session = os.getsid(server.pid)
        await server.stop()
        return server, session

    server, session = asyncio.run(story())

    assert server.devices == ["arm"]
    assert session == server.pid != os.getsid(0)
    assert server.process.returncode == 0


def test_a_server_that_cannot_start_says_why(bench):
    with pytest.raises(ServerFailed, match="nothing answers on /dev/nowhere"):
        asyncio.run(start_server(bench.settings(config={"missing": True}), bench.folder))


def test_what_a_driver_prints_is_no_answer_and_fills_no_pipe(bench):
    async def story():
        server = await start_server(bench.settings(config={"prints": True}), bench.folder)
        async with bench.client(server.url) as client:
            outcome = await client.follow(bench.goal(client, "go", x=1))
        await server.stop()
        return outcome.state

    assert asyncio.run(story()) == "SUCCEEDED"
    assert "a library that talks" in (bench.folder / "server.log").read_text()


def test_a_dead_server_is_noticed_though_a_program_that_its_driver_started_lives_on(bench):
    async def story():
        server = await start_server(bench.settings(config={"helper": True}), bench.folder)
        os.kill(server.pid, signal.SIGKILL)
        async with asyncio.timeout(300):
            await server.ended()

    try:
        asyncio.run(story())
    finally:
        os.kill(int((bench.folder / "world" / "helper").read_text()), signal.SIGKILL)


def test_a_server_that_breaks_at_once_leaves_the_last_of_its_log(bench, monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")

    with pytest.raises(ServerFailed, match="it exited at once; the end of its log"):
        asyncio.run(start_server(bench.settings(), bench.folder))


def test_a_server_that_says_nothing_is_given_up_in_time(bench, monkeypatch, tmp_path):
    silent = tmp_path / "silent"
    silent.write_text("#!/bin/sh\nexec sleep 60\n")
    silent.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(silent))

    with pytest.raises(ServerFailed, match=r"did not report ready within 0\.3 s"):
        asyncio.run(start_server(bench.settings(), bench.folder, timeout_s=0.3))


def test_a_server_that_an_engine_left_behind_is_used_again(bench):
    async def story():
        first = await start_server(bench.settings(), bench.folder)
        async with bench.client(first.url) as client:
            goal = bench.goal(client, "hold", seconds=1.5)
            following = asyncio.create_task(client.follow(goal))
            await bench.until(f"hold {goal.id}")
            following.cancel()
        second = await start_server(bench.settings(), bench.folder)
        async with bench.client(second.url) as client:
            outcome = await client.follow(goal)
        await second.stop()
        return first, second, outcome, await first.process.wait()

    first, second, outcome, status = asyncio.run(story())

    assert (second.process, second.pid, second.url) == (None, first.pid, first.url)
    assert outcome.state == "SUCCEEDED"
    assert status == 0


def test_a_server_left_behind_with_other_settings_makes_room(bench):
    async def story():
        first = await start_server(bench.settings(), bench.folder)
        second = await start_server(bench.settings(limits={"x": [0, 5]}), bench.folder)
        await second.stop()
        return first.pid, second.pid, await first.process.wait()

    first, second, status = asyncio.run(story())

    assert (second != first, status) == (True, 0)


def test_a_server_whose_owner_lives_is_left_alone(bench):
    with subprocess.Popen(["sleep", "60"]) as owner:

        async def story():
            first = await start_server(bench.settings(owner_pid=owner.pid), bench.folder)
            with pytest.raises(ServerFailed) as told:
                await start_server(bench.settings(limits={"x": [0, 5]}), bench.folder)
            owner.kill()  # nobody asks after it: it waits for its parent, and is no owner any more
            await asyncio.to_thread(os.waitid, os.P_PID, owner.pid, os.WEXITED | os.WNOWAIT)
            second = await start_server(bench.settings(), bench.folder)
            await second.stop()
            await first.process.wait()
            return first, second, str(told.value)

        first, second, words = asyncio.run(story())

    assert second.pid == first.pid
    assert f"at {first.url} is already served from {bench.folder}" in words
    assert f"by process {owner.pid}; stop that process first" in words


def test_a_server_that_was_killed_is_not_mistaken_for_one_that_is_there(bench):
    async def story():
        first = await start_server(bench.settings(), bench.folder)
        os.kill(first.pid, signal.SIGKILL)
        await first.process.wait()
        second = await start_server(bench.settings(), bench.folder)
        await second.stop()
        return second.process.returncode

    assert asyncio.run(story()) == 0


def test_a_server_that_does_not_end_is_killed(bench):
    async def story():
        server = await start_server(bench.settings(config={"safe_s": 60}), bench.folder)
        await server.stop(timeout_s=0.5)
        return server.process.returncode

    assert asyncio.run(story()) == -signal.SIGKILL


def test_hardware_that_does_not_answer_yet_is_tried_again_and_that_is_said(bench, monkeypatch):
    monkeypatch.setattr(launch, "QUIET_S", 600)
    said = []

    async def story():
        settings = bench.settings(config={"silent_at": [1, 2]})
        server = await start_patiently(settings, bench.folder, say=said.append)
        await server.stop()

    asyncio.run(story())

    assert [line.partition("; ")[2] for line in said] == [
        "it is tried again in 0.5 s",
        "it is tried again in 1 s",
    ]
    assert "device arm cannot be opened: it does not answer yet" in said[0]


def test_a_server_that_is_still_ending_is_waited_for(bench, monkeypatch):
    monkeypatch.setattr(launch, "QUIET_S", 60.0)  # however slow its start, nothing is told of it
    settings = bench.settings()
    older = Ledger(Path(settings["folder"]) / "ledger.sqlite")
    said = []

    def say(line):
        said.append(line)
        older.close()  # the older server has ended

    async def story():
        server = await start_patiently(settings, bench.folder, say=say)
        await server.stop()

    asyncio.run(story())

    assert len(said) == 1 and "another device server is using" in said[0]


def test_what_cannot_be_served_at_all_is_not_tried_again(bench, monkeypatch):
    monkeypatch.setattr(launch, "QUIET_S", 60.0)
    said = []
    settings = bench.settings(limits={"y": [0, 1]})

    with pytest.raises(ServerFailed, match="no action of scripted@1 has such a parameter"):
        asyncio.run(start_patiently(settings, bench.folder, say=said.append))
    assert said == []


def test_a_slow_start_and_a_slow_end_are_told_and_waited_for(bench, monkeypatch):
    monkeypatch.setattr(launch, "QUIET_S", 0.2)
    said = []

    async def story():
        settings = bench.settings(config={"open_s": 1.0, "safe_s": 1.0}, stop_grace_s=30.0)
        server = await start_server(settings, bench.folder, timeout_s=40, say=said.append)
        await server.stop()
        return server.process.returncode

    assert asyncio.run(story()) == 0
    assert said == [
        "waiting for the server of arm to start, 40 s at most (`start_timeout`)",
        "waiting for arm to be safe, 75 s at most (`stop_grace`)",
    ]
    assert bench.deeds()[-1] == "arm close"


def test_a_device_may_take_as_long_to_be_safe_as_its_lab_says(bench):
    async def story():
        answers = []
        for grace_s in (0.3, 30.0):
            async with bench.connected(config={"safe_s": 1.0}, stop_grace_s=grace_s) as client:
                answers.append((await client.stop("arm"))["arm"])
        return answers

    assert asyncio.run(story()) == [
        (False, "arm did not confirm its safe state within 0.3 s"),
        (True, "arm is in its safe state"),
    ]


def test_a_server_that_dies_is_started_again_also_where_that_fails_at_first(bench, monkeypatch):
    monkeypatch.setattr(launch, "QUIET_S", 600)
    said = []

    async def story():
        settings = bench.settings(config={"silent_at": [2, 3]})
        server = await start_server(settings, bench.folder, say=said.append)
        keeping = asyncio.create_task(keep_running(server, settings, bench.folder))
        before = server.pid
        os.kill(server.pid, signal.SIGKILL)
        async with asyncio.timeout(500):
            while not said or not said[-1].endswith(" again"):  # noqa: ASYNC110 - it is only said
                await asyncio.sleep(0.05)
        async with bench.client(server.url) as client:
            outcome = await client.follow(bench.goal(client, "go", x=1))
        keeping.cancel()
        await server.stop()
        return before, server, outcome.state

    before, server, state = asyncio.run(story())

    assert (state, server.pid != before) == ("SUCCEEDED", True)
    assert said[0].startswith("the server of arm has died, see ")
    assert [line.partition("; it starts again in ")[2] for line in said[:3]] == [
        "0.5 s", "1 s", "2 s",
    ]  # fmt: skip
    assert "it does not answer yet" in said[1] and "it does not answer yet" in said[2]
    assert said[3] == f"arm at {server.url} again"


@pytest.mark.parametrize("fault", [OSError(22, "Invalid argument"), SystemError("no Ctrl-Break")])
def test_a_server_left_behind_that_hears_no_signal_is_killed(fault, monkeypatch):
    sent = []

    def kill(pid, number):
        sent.append(number)
        raise fault  # as Windows says of a process of another console

    monkeypatch.setattr(launch.os, "kill", kill)
    asyncio.run(launch.RunningServer(None, "http://127.0.0.1:1", ["gantry"], 1234567).stop())

    assert sent == [launch.PLEASE_END, launch.AT_ONCE]
