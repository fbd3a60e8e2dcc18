"""A device's history: by the minute, within its limit, there again after a restart."""

import pytest

from labrun.web.devices.history import Histories
from labrun.web.models.devices import DeviceState, Reach

START_S = 1_800_000_000


class Bench:
    """A furnace that reports each ten seconds, by a clock of its own."""

    def __init__(self, path, **more):
        self.now_s = START_S
        self.last = None
        self.histories = Histories(path, clock=lambda: self.now_s, **more)

    def report(self, *, reach: Reach = "online", word="heating", reason="", **status):
        self.now_s += 10
        self.last = str(self.now_s) if reach == "online" else self.last
        self.histories.note(DeviceState(
            name="furnace", contract="furnace@1", driver="x", url=None, reach=reach, word=word,
            reason=reason, status=status, status_at=self.last, changed_at="",
        ))  # fmt: skip


@pytest.fixture
def bench(tmp_path):
    bench = Bench(tmp_path / "history.sqlite")
    yield bench
    bench.histories.close()


def test_a_number_has_its_first_last_lowest_and_highest_and_a_course(bench):
    for i in range(60):
        word = "up" if i < 45 else "down"
        bench.report(temperature=20.0 + (i if i < 50 else -i), shots=i, door=True, word=word)
        bench.histories.read("furnace", START_S)  # looking changes nothing
    told = bench.histories.read("furnace", START_S, "temperature")
    values = {one.name: one for one in told.values}

    assert set(values) == {"temperature", "shots"}
    assert (values["temperature"].low, values["temperature"].high) == (-39, 69)
    assert values["shots"].last - values["shots"].first == 59 - 4  # of the first minute, its last
    assert told.words == {"up": 0.75, "down": 0.25}
    assert told.series is not None and told.series.part_s == 60
    assert len(told.series.at_s) == 11 and max(told.series.high) == 69
    assert bench.histories.read("furnace", bench.now_s + 60).values == []


def test_trouble_is_told_once_and_so_is_its_end(bench):
    bench.report(reach="lost", reason="no status yet")
    bench.report(temperature=20.0)
    for _ in range(3):
        bench.report(reach="lost", reason="the connection broke")
    bench.report(temperature=20.0, fault="too hot")
    bench.report(temperature=20.0)
    told = bench.histories.read("furnace", START_S)

    assert [one.text for one in told.troubles] == [
        "well again", "too hot", "lost: the connection broke",
    ]  # fmt: skip
    assert sum(told.words.values()) == 1


def test_a_damaged_file_is_put_aside(tmp_path):
    path = tmp_path / "history.sqlite"
    path.write_bytes(b"not a database" * 100)
    Histories(path).close()

    assert path.with_suffix(".damaged").read_bytes().startswith(b"not a")


def test_it_stays_within_its_limit_and_is_there_after_a_restart(tmp_path):
    path, limit = tmp_path / "history.sqlite", 200_000
    bench = Bench(path, largest_bytes=limit)
    for i in range(2_000):
        bench.now_s += 50  # with the ten of a report: each is a minute of its own
        bench.report(temperature=float(i), pressure=1.0)
    bench.histories.close()
    again = Histories(path, largest_bytes=limit)
    told = again.read("furnace", START_S, "temperature")
    again.close()

    assert told.bytes <= limit < 10 * told.bytes
    assert told.values[1].last == 1999 and told.values[1].first > 0
    assert path.stat().st_size < 2 * limit
