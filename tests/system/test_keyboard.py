"""What is typed is told line by line, on systems where a loop can wait for a terminal and where not."""

import asyncio
import os

import pytest

from labrun.system.keyboard import Keyboard

POSIX = pytest.mark.posix("no loop can wait for a terminal there")


@pytest.fixture(params=[pytest.param("a loop can wait for it", marks=POSIX), "only a thread can"])
def way(request, monkeypatch):
    monkeypatch.setattr("labrun.system.keyboard.WINDOWS", "thread" in request.param)


@pytest.fixture
def terminal():
    reading, writing = os.pipe()
    yield reading, writing
    os.close(writing)
    os.close(reading)


def heard(keyboard_of, act):
    """The lines that were heard while `act` typed."""

    async def story():
        lines = asyncio.Queue()
        keyboard = keyboard_of(lines.put_nowait)
        keyboard.open()
        try:
            return await act(keyboard, lines)
        finally:
            keyboard.close()

    return asyncio.run(story())


def test_two_lines_typed_at_once_are_two_and_half_a_line_waits(way, terminal):
    reading, writing = terminal

    async def act(keyboard, lines):
        os.write(writing, b"perhaps\ny\nno")
        first = [await lines.get(), await lines.get()]
        os.write(writing, b"t\r\n")
        return [*first, await lines.get()]

    assert heard(lambda take: Keyboard(reading, take), act) == ["perhaps", "y", "not"]


def test_what_is_typed_while_nobody_listens_is_nobodys(terminal):
    reading, writing = terminal

    async def act(keyboard, lines):
        keyboard.close()
        keyboard.open()
        os.write(writing, b"now\n")
        return await lines.get()

    assert heard(lambda take: Keyboard(reading, take), act) == "now"


def test_a_terminal_that_is_gone_ends_the_listening(way):
    reading, writing = os.pipe()
    os.close(writing)

    async def act(keyboard, lines):
        while keyboard._is_open:  # noqa: ASYNC110 - it is not told to anybody
            await asyncio.sleep(0)
        return lines.empty()

    assert heard(lambda take: Keyboard(reading, take), act)
    os.close(reading)
