"""Processes of our own start apart from the terminal, and end within a time."""

import asyncio
import getpass
import os
import re
import signal
import subprocess
import sys

import pytest

from labrun.system.process import alive, start_python, stop, user_name

STUBBORN = "import signal, time\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\n"
AWAKE = "print('awake', flush=True)\ntime.sleep(600)\n"


@pytest.fixture
def modules(tmp_path):
    """Makes a module that `start_python` finds, and the environment in which it does."""

    def make(name, text):
        (tmp_path / f"{name}.py").write_text(text)
        return {"env": {**os.environ, "PYTHONPATH": str(tmp_path)}, "stdout": subprocess.PIPE}

    return make


def test_a_module_runs_with_this_python_without_input_in_a_session_of_its_own(modules):
    options = modules(
        "tells",
        "import os, sys\nsession = os.getsid(0) if hasattr(os, 'getsid') else os.getpid()\n"
        "print(sys.argv[1:], session, sys.stdin.read())",
    )

    async def story():
        process = await start_python("tells", "a", "b", **options)
        output, _ = await process.communicate()
        return process.pid, output.decode()

    pid, said = asyncio.run(story())

    assert said.splitlines() == [f"['a', 'b'] {pid} "]


def test_what_it_says_is_utf_8_whatever_the_code_page(modules, monkeypatch):
    monkeypatch.setenv("PYTHONIOENCODING", "cp1252")
    options = modules("says", "print('Gr\\u00f6\\u00dfe')")

    async def story():
        process = await start_python("says", **options)
        return (await process.communicate())[0]

    assert asyncio.run(story()).split() == ["Größe".encode()]


@pytest.mark.parametrize(
    ("text", "timeout_s", "status"),
    [
        ("import time\n" + AWAKE, 60, -signal.SIGTERM),
        (STUBBORN + AWAKE, 1.0, -signal.SIGKILL),
    ],
    ids=["asked", "killed"],
)
@pytest.mark.posix("Windows has no such exit statuses")
def test_it_is_asked_to_end_and_killed_when_it_does_not(modules, text, timeout_s, status):
    options = modules("sleeps", text)

    async def story():
        process = await start_python("sleeps", **options)
        assert await process.stdout.readline() == b"awake\n"
        return await stop(process, timeout_s), await stop(process, timeout_s)

    assert asyncio.run(story()) == (status, status)


@pytest.mark.parametrize("fault", [OSError, SystemError])
@pytest.mark.posix("Windows has no such exit statuses")
def test_it_is_killed_at_once_where_it_cannot_be_asked(modules, fault):
    """As by Windows where the two have no console in common; Python 3.11 has a SystemError for it."""
    options = modules("sleeps", "import time\n" + AWAKE)

    async def story():
        process = await start_python("sleeps", **options)
        assert await process.stdout.readline() == b"awake\n"
        send = process.send_signal

        def refuse(number):
            if number == signal.SIGTERM:
                raise fault
            send(number)

        process.send_signal = refuse
        return await stop(process, 600)

    assert asyncio.run(story()) == -signal.SIGKILL


@pytest.mark.posix("Windows cannot be asked")
def test_a_process_lives_until_it_ends_reaped_or_not():
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as process:
        assert alive(process.pid)
        assert process.stdin is not None
        process.stdin.close()
        os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        assert not alive(process.pid)
    assert not alive(process.pid)
    assert not alive(None)


def test_a_user_without_a_name_has_a_number(monkeypatch):
    """As in a container that was started for a number of its own; a stop is no place to fail for that."""

    def nobody():
        raise KeyError("getpwuid(): uid not found: 54321")

    monkeypatch.setattr(getpass, "getuser", nobody)

    assert re.fullmatch(r"user \d+|somebody", user_name())
