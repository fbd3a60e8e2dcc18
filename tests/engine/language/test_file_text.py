"""A file that is not text is reported in one sentence that says what it is."""

import os

import pytest

from labrun.engine.language.file_text import LARGEST, Unread, file_text


def why(path) -> Unread:
    found = file_text(path)
    assert isinstance(found, Unread)
    return found


def test_a_folder_names_a_protocol_in_it(tmp_path):
    (tmp_path / "scan.yaml").write_text("a: 1")

    assert why(tmp_path).message == "this is a folder, not a file"
    assert "scan.yaml" in why(tmp_path).hint

    (tmp_path / "journal.jsonl").touch()

    assert why(tmp_path).hint == f"it is a run's: `labrun resume {tmp_path}` goes on with it"


@pytest.mark.parametrize(
    ("asked", "there"),
    [("their.yaml", "there.yaml"), ("there.yml", "there.yaml"), ("There.YAML", "there.yaml")],
)
def test_a_file_that_is_not_there_is_guessed(asked, there, tmp_path):
    (tmp_path / "there.yaml").write_text("a: 1")
    if (tmp_path / asked).exists():
        pytest.skip("this disk does not tell capitals apart")

    assert why(tmp_path / asked).hint == f"did you mean {tmp_path / there}?"


def test_a_file_is_not_guessed_for_its_ending_alone_but_what_there_is_is_told(tmp_path):
    asked = tmp_path / "bench.yaml"

    assert why(asked).hint.endswith("has no .yaml file; `labrun new bench` writes a protocol")
    for name in ("bad", "core", "dose", "weigh"):
        (tmp_path / f"{name}.yaml").write_text("a: 1")
    assert why(asked).hint == f"{tmp_path} has bad.yaml, core.yaml, dose.yaml and 1 more"


def test_a_folder_that_is_not_there_is_told(tmp_path):
    assert why(tmp_path / "none" / "scan.yaml").hint.startswith("there is no folder")
    assert why(tmp_path / "null\0.yaml").code == "E100"


@pytest.mark.posix("a link needs a right there")
def test_a_link_that_leads_nowhere_is_told(tmp_path):
    (tmp_path / "round.yaml").symlink_to("round.yaml")

    assert why(tmp_path / "round.yaml").message.startswith("this is a link to round.yaml")


def test_a_large_file_is_told_without_reading_it(tmp_path):
    large = tmp_path / "large.yaml"
    with large.open("wb") as file:
        file.truncate(50_000_000 if LARGEST < 50_000_000 else LARGEST + 1)

    assert why(large).code == "E108"
    assert "50,000,000 bytes; the limit is 10,000,000" in why(large).message


@pytest.mark.posix("rights of this kind do not bind there")
@pytest.mark.skipif(getattr(os, "geteuid", int)() == 0, reason="rights do not bind here")
def test_a_file_without_the_right_to_read_is_told(tmp_path):
    closed = tmp_path / "closed.yaml"
    closed.write_text("a: 1")
    closed.chmod(0)

    assert why(closed).message == "the file cannot be read: permission denied"


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ("labrun: 1".encode("utf-16"), "UTF-16"),
        ("labrun: 1".encode("utf-16-le"), "UTF-16"),
        ("labrun: 1".encode("utf-16-be"), "UTF-16"),
        ("labrun: 1".encode("utf-32"), "UTF-32"),
        (b"PK\x03\x04\x14\x00", "a ZIP file, such as Word"),
        (b"%PDF-1.7", "a PDF"),
        (b"a: \xff\x00\x01", "not a text file"),
        (b"a: \x81", "byte 0x81"),
    ],
)
def test_what_is_no_utf8_is_named(data, said, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_bytes(data)

    assert said in why(path).message
    assert "UTF-8" in why(path).hint


def test_latin_1_is_told_at_its_first_letter_with_an_accent(tmp_path):
    path = tmp_path / "latin.yaml"
    path.write_bytes(b"a: 1\r\nname: caf\xe9\r\n")
    found = why(path)

    assert (found.line, found.column) == (2, 10)
    assert "Latin-1" in found.message and "0xE9 is é" in found.message
