"""Whose spectrum an export brought, by what is known of all others: list or selection, whole or not."""

import pytest

from labrun.drivers.analyser.export_arrival import Arrived
from labrun.drivers.analyser.identity import Unproved, spectrum_of
from labrun.drivers.analyser.shot_log import ShotLog


class Bench:
    """A program with a list of entries, and the log of the driver that exports from it."""

    def __init__(self, shot_log: ShotLog) -> None:
        self.shot_log = shot_log
        self.listed: list[str] = []

    def shoot(self):
        """One more entry in the list."""
        number = (self.shot_log.newest().number if self.shot_log.newest() else 0) + 1
        shot = self.shot_log.begin(f"g{number}", float(number), set(self.listed))
        self.listed.append(f"e{number}")
        self.shot_log.fired(shot, f"e{number}")
        return self.shot_log.shot(shot.name)

    def export(self, shot, *contents: str, visible: bool = True):
        """What is proved to be the shot's when these spectra come, numbered from 1."""
        came = [
            Arrived(f"t_{n}.csv", what.encode(), 500, what, n % 10 == 1)
            for n, what in enumerate(contents, 1)
        ]
        listed = frozenset(self.listed) if visible else None
        try:
            found = spectrum_of(shot, came, self.shot_log, listed)
            self.shot_log.exported(shot, found.keys[0])
        finally:
            self.shot_log.saw(shot, {key for one in came for key in one.keys}, listed)
        return found.numbers

    def list_export(self, shot, **more):
        return self.export(shot, *[f"s-{entry}" for entry in self.listed], **more)


@pytest.fixture
def bench(tmp_path):
    shot_log = ShotLog(tmp_path / "shots.sqlite")
    yield Bench(shot_log)
    shot_log.close()


def test_of_an_exported_list_the_one_that_was_never_seen_is_the_shots(bench):
    assert [bench.list_export(bench.shoot()) for _ in range(12)][-1] == "s-e12"


def test_a_shot_that_was_given_up_costs_the_next_one_and_no_more(bench):
    bench.shoot()
    second = bench.shoot()

    for _ in range(2):  # trying again proves nothing more
        with pytest.raises(Unproved, match=r"2 spectra .* shot-000001 \(e1\) may be among them"):
            bench.list_export(second)
    assert bench.list_export(bench.shoot()) == "s-e3"


def test_entries_of_other_people_in_an_exported_list_cost_the_first_point(bench):
    bench.listed = ["x", "y"]

    with pytest.raises(Unproved, match="3 spectra that were never seen before"):
        bench.list_export(bench.shoot())
    assert bench.list_export(bench.shoot()) == "s-e2"


@pytest.mark.parametrize("visible", [True, False])
def test_a_selected_entry_is_the_shots_whatever_else_is_listed(bench, visible):
    bench.listed = ["x"]
    first, second = bench.shoot(), None

    assert bench.export(first, "s-e1", visible=visible) == "s-e1"
    second = bench.shoot()
    assert bench.export(second, "s-e2", visible=visible) == "s-e2"


def test_files_that_come_beside_a_spectrum_are_chosen_by_their_name(bench):
    assert bench.export(bench.shoot(), "s-e1", "second of e1") == "s-e1"
    assert bench.export(bench.shoot(), "s-e2", "second of e2") == "s-e2"


def test_a_selection_that_stays_where_it_was_is_noticed(bench):
    bench.export(bench.shoot(), "s-e1")

    with pytest.raises(Unproved, match="wrote the spectrum of shot-000001 again"):
        bench.export(bench.shoot(), "s-e1")


@pytest.mark.parametrize("visible", [True, False])
def test_a_single_spectrum_may_be_the_earlier_shots_that_was_never_exported(bench, visible):
    bench.shoot()

    with pytest.raises(Unproved, match=r"shot-000001.* was never exported"):
        bench.export(bench.shoot(), "s-e1", visible=visible)
    assert bench.export(bench.shoot(), "s-e3", visible=visible) == "s-e3"


def test_an_incomplete_list_that_lacks_a_shot_never_seen_proves_nothing(bench):
    bench.export(bench.shoot(), "s-e1")
    bench.shoot()

    with pytest.raises(Unproved, match="shot-000002"):
        bench.export(bench.shoot(), "s-e1", "s-e2")
