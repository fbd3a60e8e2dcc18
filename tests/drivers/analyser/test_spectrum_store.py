"""Kept spectra are whole or not there, and a disk without room is told by its name."""

import pytest

from labrun.drivers.analyser.exporting import failed_to_keep
from labrun.drivers.analyser.spectrum_store import SpectrumStore


def test_what_was_kept_is_read_again(tmp_path):
    kept = SpectrumStore(tmp_path)
    digest = kept.keep("shot-000001", b"spectrum")

    assert kept.read("shot-000001", digest) == b"spectrum"
    assert kept.read("shot-000001", "another digest") is None
    assert kept.read("shot-000002", digest) is None


@pytest.mark.posix("the limit is one of POSIX")
def test_a_spectrum_for_which_there_is_no_room_leaves_nothing_half(tmp_path):
    import resource

    kept = SpectrumStore(tmp_path)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError) as caught:
            kept.keep("shot-000001", b"x" * 5000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    failure = failed_to_keep("libs", "shot-000001", str(tmp_path), caught.value)

    assert list(tmp_path.iterdir()) == []
    assert failure.name == "DiskFull"
    assert "libs: the spectrum of shot-000001 cannot be stored in" in failure.message
