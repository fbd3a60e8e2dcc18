import pytest

from labrun.reduction import Unreadable
from labrun.reduction.spectrum.source import bytes_of


def test_a_file_is_read_whole(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"200,1\n")

    assert bytes_of(tmp_path / "a.csv") == b"200,1\n"
    assert bytes_of(b"x") == b"x"


def test_a_folder_is_refused(tmp_path):
    with pytest.raises(Unreadable, match="is a folder"):
        bytes_of(tmp_path)


def test_a_file_that_grows_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "growing.csv"
    path.write_bytes(b"200,1\n201,1")
    whole = type(path).read_bytes

    def grow(self):
        raw = whole(self)
        with self.open("ab") as file:
            file.write(b"234\n")
        return raw

    monkeypatch.setattr(type(path), "read_bytes", grow)
    with pytest.raises(Unreadable, match="still being written"):
        bytes_of(path)
