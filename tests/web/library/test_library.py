"""The folder of protocols, where the system refuses what a person asks for."""

import errno
from pathlib import Path

import pytest

from labrun.web.library.library import Library
from labrun.web.local.refusal import Refusal


def test_what_cannot_be_deleted_is_not_in_the_trash_either(tmp_path, monkeypatch):
    (tmp_path / "hello.yaml").write_text("labrun: 1\n")
    library = Library(tmp_path, tmp_path / ".labrun", tmp_path / "runs")

    def unlink(_self, **_how):
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(Path, "unlink", unlink)
    with pytest.raises(Refusal, match=r"hello\.yaml cannot be deleted: Read-only file system"):
        library.throw_away("hello.yaml")

    assert library.trash() == []
