from pathlib import Path

from labrun.reduction.batch.source import natural, source


def test_names_start_from_the_folder_that_was_given():
    assert source(Path("/a/b/sub/c.csv"), Path("/a/b")).name == "sub/c.csv"
    assert source(Path("/elsewhere/c.csv"), Path("/a/b")).name == "/elsewhere/c.csv"


def test_names_sort_as_people_count():
    names = ["core_10_2.csv", "core_2_10.csv", "core_2_9.csv", "a10", "a9b", "9", "10", "a"]

    assert sorted(names, key=natural) == [
        "9", "10", "a", "a9b", "a10", "core_2_9.csv", "core_2_10.csv", "core_10_2.csv",
    ]  # fmt: skip


def test_digits_of_other_scripts_and_leading_zeros_are_no_reason_to_fail():
    names = ["a²", "a٣", "a01", "a1", "a0001"]

    backwards = names[::-1]

    assert sorted(names, key=natural) == sorted(backwards, key=natural)


def test_a_name_that_is_not_utf8_can_be_written_into_a_table():
    odd = source(Path("/a/odd\udcff.csv"), Path("/a"))

    assert odd.name == "odd\\xff.csv"
    assert odd.path == Path("/a/odd\udcff.csv")
