import os
import threading
import time

import pytest

from labrun.reduction.batch.finished_file import wait_until_finished
from labrun.reduction.batch.work import load


def test_an_old_file_is_not_waited_for(tmp_path):
    path = tmp_path / "s.csv"
    path.write_text("200,5\n")
    os.utime(path, (time.time() - 60, time.time() - 60))

    assert wait_until_finished(path, longest_s=0.0)


def test_a_file_from_the_future_is_not_waited_for(tmp_path):
    path = tmp_path / "s.csv"
    path.write_text("200,5\n")
    os.utime(path, (time.time() + 600, time.time() + 600))

    assert wait_until_finished(path, longest_s=0.0)


def growing(path, stop):
    with path.open("a") as file:
        while not stop.is_set():
            file.write("200,5\n")
            file.flush()
            time.sleep(0.01)


@pytest.fixture
def written(tmp_path):
    """A file that grows until its event is set."""
    path, stop = tmp_path / "s.csv", threading.Event()
    path.write_text("wavelength,intensity\n")
    thread = threading.Thread(target=growing, args=(path, stop))
    thread.start()
    yield path, stop
    stop.set()
    thread.join()


def test_a_file_that_never_stops_growing_is_given_up(written):
    path, _ = written

    assert not wait_until_finished(path, longest_s=0.5)


def test_a_file_that_stops_growing_is_read_whole(written):
    path, stop = written
    threading.Timer(0.5, stop.set).start()
    raw = load(path)

    assert isinstance(raw, bytes)
    assert len(raw) == path.stat().st_size


def test_what_cannot_be_read_is_a_sentence(tmp_path):
    assert load(tmp_path / "none.csv") == "none.csv cannot be opened: No such file or directory"
    assert "not a file" in load(tmp_path)
