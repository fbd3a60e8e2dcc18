"""Files of an export are awaited until they are whole; those of others are left alone."""

import asyncio

import pytest

from labrun.drivers.analyser.export_arrival import NotArrived, Wanted, arrived, has_name
from labrun.drivers.analyser.exporting import Exporting
from labrun.drivers.analyser.folder import SharedFolder
from labrun.drivers.analyser.shot_log import ShotLog
from labrun.drivers.analyser.spectrum_store import SpectrumStore

WHOLE = "".join(f"{190 + k / 10:.4f},{k % 7}.5\n" for k in range(500)).encode()


def come(folder, **wanted):
    """What has arrived of an export that was typed `mine`."""
    asked = Wanted(
        frozenset(), "*1.csv", ours=lambda name: has_name(name, ["mine-1"]), settle_s=0.0, **wanted
    )
    return asyncio.run(arrived(SharedFolder(str(folder)), asked, 1.0))


def test_a_name_is_known_again_whatever_became_of_its_punctuation(tmp_path):
    (tmp_path / "Mine_1").mkdir()
    (tmp_path / "Mine_1" / "x_1.csv").write_bytes(WHOLE)
    (tmp_path / "other_1.csv").write_bytes(WHOLE)

    assert [one.path for one in come(tmp_path)] == ["Mine_1/x_1.csv"]


def test_what_others_wrote_is_told(tmp_path):
    (tmp_path / "other_1.csv").write_bytes(WHOLE)

    with pytest.raises(NotArrived, match=r"other_1\.csv came meanwhile, and is not of it"):
        come(tmp_path)


@pytest.mark.parametrize(("data", "channels"), [(WHOLE[:-1], 500), (WHOLE, 0)])
def test_an_export_that_may_be_broken_off_is_whole_by_its_line_end_or_its_count(
    tmp_path, data, channels
):
    (tmp_path / "mine-1_1.csv").write_bytes(data)

    assert come(tmp_path, breaks_off=True, channels=channels)[0].channels == 500


def test_an_export_that_may_be_broken_off_behind_a_number_is_not_taken(tmp_path):
    (tmp_path / "mine-1_1.csv").write_bytes(WHOLE[: 13 * 300 - 1])

    with pytest.raises(
        NotArrived, match=r"after \d+ channels, so it may be cut off; if that is all"
    ):
        come(tmp_path, breaks_off=True)


def test_as_long_as_its_channels_cannot_be_counted_a_file_has_to_stand_still_for_longer(tmp_path):
    log = ShotLog(tmp_path / "shots.sqlite")
    try:
        exporting = Exporting("libs", log, SpectrumStore(tmp_path / "spectra"), None)
        unknown = exporting.settle_s(1.0)
        log.learn("channels", "500")
        known = exporting.settle_s(1.0)
    finally:
        log.close()

    assert (unknown, known) == (5.0, 1.0)


def test_a_table_beside_the_spectrum_is_ignored_and_half_a_spectrum_waited_for(tmp_path):
    (tmp_path / "mine-1_1.csv").write_bytes(WHOLE)
    (tmp_path / "mine-1_peaks.csv").write_text("peak,area\n670.8,3\n")

    assert [one.path for one in come(tmp_path)] == ["mine-1_1.csv"]

    (tmp_path / "mine-1_2.csv").write_bytes(WHOLE[:3330])

    with pytest.raises(NotArrived, match=r"mine-1_2.csv \(3330 bytes\): it ends within line"):
        come(tmp_path)
