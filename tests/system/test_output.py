"""What is printed reaches its reader in order, and holds nobody up who prints it."""

import os
import sys

import pytest

from labrun.system.output import Unhurried, unhurried_stdout

MORE_THAN_A_PIPE_HOLDS = [f"line {n} of what nobody reads yet: µ°C\n" for n in range(20_000)]


@pytest.fixture
def pipe():
    reads, writes = os.pipe()
    with (
        os.fdopen(reads, encoding="utf-8") as source,
        os.fdopen(writes, "w", encoding="utf-8") as sink,
    ):
        yield source, sink


def test_nobody_waits_for_a_reader_and_all_of_it_arrives_in_order(pipe, monkeypatch):
    source, sink = pipe
    monkeypatch.setattr(sys, "stdout", sink)

    with unhurried_stdout():
        for line in MORE_THAN_A_PIPE_HOLDS:
            print(line, end="", flush=True)
        read = [source.readline() for _ in MORE_THAN_A_PIPE_HOLDS]

    assert read == MORE_THAN_A_PIPE_HOLDS
    assert sys.stdout is sink


def test_a_reader_who_has_gone_is_told_as_ever():
    reads, writes = os.pipe()
    sink = os.fdopen(writes, "w", encoding="utf-8")
    out = Unhurried(sink)
    os.close(reads)

    with pytest.raises(OSError):  # BrokenPipeError; on Windows EINVAL
        while True:
            out.write("gone?\n")
    out.finish()
    with pytest.raises(OSError):
        sink.close()


def test_it_takes_texts_and_is_otherwise_what_it_stands_for(pipe):
    _, sink = pipe
    out = Unhurried(sink)

    assert (out.isatty(), out.fileno(), out.encoding) == (False, sink.fileno(), "utf-8")
    with pytest.raises(TypeError, match="not bytes"):
        out.write(b"")
    out.finish()
