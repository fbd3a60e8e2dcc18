"""One engine holds a run's folder; a check whether there is one never gets in its way."""

import threading

import pytest

from labrun.engine.run.folder import FolderFault, FolderLock, is_live


def test_a_folder_is_live_as_long_as_its_engine_holds_it(tmp_path):
    engine = FolderLock(tmp_path)
    before = is_live(tmp_path)
    engine.take()
    held = is_live(tmp_path)
    engine.release()

    assert (before, held, is_live(tmp_path)) == (False, True, False)


def test_a_second_engine_is_told_that_there_is_one(tmp_path):
    first = FolderLock(tmp_path)
    first.take()

    with pytest.raises(FolderFault, match=f"another engine is running {tmp_path.name}"):
        FolderLock(tmp_path).take()
    first.release()


def test_an_engine_gets_its_folder_although_others_look_at_it_all_the_time(tmp_path):
    (tmp_path / "engine.lock").touch()
    over = threading.Event()

    def look():
        while not over.is_set():
            is_live(tmp_path)

    lookers = [threading.Thread(target=look) for _ in range(3)]
    for looker in lookers:
        looker.start()
    try:
        for _ in range(50):
            engine = FolderLock(tmp_path)
            engine.take()
            engine.release()
    finally:
        over.set()
        for looker in lookers:
            looker.join()
