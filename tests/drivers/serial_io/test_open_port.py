"""A port on a pseudo-terminal, read and written by the event loop, or by threads where it cannot watch it."""

import asyncio
import contextlib
import os
import pty
import tty

import pytest

from labrun.drivers.serial_io.open_port import OpenPort, open_exclusively

LONG = bytes(range(1, 200)) * 2000


@contextlib.asynccontextmanager
async def opened(by, monkeypatch):
    """The open port, its other end, what it has heard, and why it was lost."""
    if by == "threads":

        def add_reader(*_):
            raise NotImplementedError

        monkeypatch.setattr(asyncio.get_running_loop(), "add_reader", add_reader)
    far, near = pty.openpty()
    tty.setraw(near)
    name = os.ttyname(near)
    heard, lost = asyncio.Queue(), asyncio.Queue()
    port = OpenPort(name, lambda: open_exclusively(name), heard.put_nowait, lost.put_nowait)
    await port.open()
    os.close(near)
    yield port, far, heard, lost
    await port.close()


pytestmark = pytest.mark.posix("a pseudo-terminal")
both = pytest.mark.parametrize("by", ["loop", "threads"])


async def read(far, count):
    """So many bytes from the other end."""
    data = b""
    while len(data) < count:
        data += await asyncio.to_thread(os.read, far, count - len(data))
    return data


@both
def test_what_finds_no_room_is_sent_before_what_is_written_next(by, monkeypatch):
    async def use():
        async with opened(by, monkeypatch) as (port, far, heard, _):
            port.write(LONG)
            port.write(b"a")
            sent = asyncio.create_task(port.send(b"b"))
            data = await read(far, len(LONG) + 2)
            await sent
            port.write(b"c")
            data += await read(far, 1)
            os.write(far, b"k")
            answer = await heard.get()
            os.close(far)
            return data, answer

    data, answer = asyncio.run(use())

    assert data == LONG + b"abc"
    assert answer == b"k"


@both
def test_a_port_that_is_gone_is_told_once_and_takes_nothing_more(by, monkeypatch):
    async def use():
        async with opened(by, monkeypatch) as (port, far, _, lost):
            os.close(far)
            fault = await lost.get()
            port.write(b"?")
            with pytest.raises(OSError, match=r".+"):
                await port.send(b"?")
            await port.close()
            return fault, lost.empty(), port.is_open

    fault, told_once, is_open = asyncio.run(use())

    assert isinstance(fault, OSError)
    assert told_once
    assert not is_open


@both
def test_who_writes_while_a_port_is_closed_finds_it_closed(by, monkeypatch):
    async def use():
        async with opened(by, monkeypatch) as (port, far, _, lost):
            port.write(LONG)
            closing = asyncio.create_task(port.close())
            await asyncio.sleep(0)
            port.write(b"?")
            with pytest.raises(OSError, match="not open"):
                await port.send(b"?")
            data = await read(far, len(LONG))
            await closing
            return data, lost.empty()

    data, nothing_lost = asyncio.run(use())

    assert data == LONG
    assert nothing_lost
