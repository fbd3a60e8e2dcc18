"""The page is whole, escaped and readable for every kind of run, also for one that has no end."""

import re
import struct
import zlib

import pytest

from labrun.schemas import journal as j
from labrun.web.report.page import page
from labrun.web.report.report_data import gather


@pytest.fixture
def read(folder, outline):
    """The page of the folder, as an outline."""

    def read_page():
        return outline(page(gather(folder)))

    return read_page


def png():
    def part(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    head = struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0)
    data = zlib.compress(b"\0\0")
    return b"\x89PNG\r\n\x1a\n" + part(b"IHDR", head) + part(b"IDAT", data) + part(b"IEND", b"")


def test_a_run_that_succeeded_says_what_was_asked_and_that_nothing_failed(folder, teller, read):
    teller.started(params={"pitch": {"$quantity": [2, "mm"]}}, roles={"libs": "libs"})
    teller.worked("main/a").tell(j.SafeState(device="libs", confirmed=True, message="all off"))
    teller.finished(outputs={"points": 1})

    found = read()
    assert "The run succeeded, with no holes. 1 action was sent, none of them failed." in found.text
    assert "pitch 2 mm set for this run how <far> apart" in found.text
    assert "libs_analyzer@1 contracts/libs_analyzer-1.yaml sim_libs b1 ledger l1" in found.text
    assert "No action failed or was cancelled." in found.text
    assert "hush-hush" not in found.text


def test_a_device_that_lost_its_state_is_named_with_the_reason(folder, teller, read):
    teller.started().worked("main/a")
    teller.tell(j.Touched(device="libs", reason="its server was restarted")).finished()

    assert "libs its server was restarted" in read().text


def test_the_page_can_be_found_ones_way_in(folder, teller, read):
    teller.started(params={"a": 1}).failed("main/a").worked("main/a", attempt=2).finished()
    (folder / "element_maps.png").write_bytes(png())

    found = read()
    assert found.open == []
    assert found.headings[0] == "h1" and found.headings.count("h1") == 1
    assert len(found.ids) == len(set(found.ids))
    assert {link.removeprefix("#") for link in found.links} <= set(found.ids)
    assert found.tables == found.captions > 0
    assert all(image["alt"] for image in found.images) and len(found.images) == 1
    assert found.outside == []


def test_every_text_from_outside_is_escaped(folder, teller):
    evil = "<script>alert('x')</script>\"&"
    teller.started(protocol=evil, params={evil: evil}, roles={"libs": evil})
    teller.sent("main/a").ended("main/a", error=evil, message=evil)
    teller.tell(j.Asked(path="main/q", id="q", text=evil, choices=[evil]))
    teller.tell(j.Answered(path="main/q", choice=evil, by=evil), j.Control(verb="pause", by=evil))
    teller.tell(j.StepEnded(path="main/l", fate="succeeded", message=evil))
    teller.tell(j.SafeState(device=evil, confirmed=False, message=evil))
    teller.iteration(evil, "failed", message=evil, row={evil: evil}, file="data.csv")
    teller.finished("failed", reason=evil, outputs={"o": evil})
    (folder / "data.csv").write_text(f"key,{evil}\n1,{evil}\n")
    (folder / "<img src=x>.csv").write_text(evil)

    made = page(gather(folder))
    assert "<script" not in made
    assert "<img" not in made
    assert made.count("&lt;script&gt;") > 15


def test_a_run_that_was_killed_says_how_to_go_on(folder, teller, read):
    teller.started().sent("main/shoot")

    found = read()
    assert "The run was interrupted" in found.text
    assert "labrun resume 2026-11-21_test_0001" in found.text
    assert "ended without a last record (killed, or power lost)" in found.text
    assert "not resolved" in found.text


def test_a_run_that_was_resumed_shows_its_engines_and_the_time_between(folder, teller, read):
    teller.started().sent("main/a").after(245).tell(j.Resumed(count=1, labrun="0.2.0", torn=9))
    teller.ended("main/a").finished()

    found = read()
    assert "Interruptions 1, 4 min 05 s in all" in found.text
    assert "9 bytes were cut off" in found.text
    assert "labrun, engine 2 0.2.0" in found.text
    assert "1 action" in found.text
    assert "What each device did when" not in found.text  # nobody saw how long it took


def test_what_each_device_did_when_is_drawn_without_the_time_between_engines(folder, teller):
    teller.started().sent("main/a").after(30).ended("main/a").after(245)
    teller.tell(j.Resumed(count=1, labrun="0.2.0")).after(10).sent("main/b").after(20)
    text = page(gather(teller.ended("main/b").finished() and folder))
    drawn = [(int(x), int(w)) for x, w in re.findall(r'<rect x="(\d+)" width="(\d+)"', text)]

    assert "What each device did when, over 1 min 00 s, interruptions left out" in text
    wide = [(round(x, -1), round(w, -1)) for x, w in drawn if w > 1]
    assert wide == [(0, 120), (160, 80)]


def test_changed_and_lost_files_and_a_table_that_was_edited_are_said_at_the_top(
    folder, teller, read
):
    (folder / "spectra").mkdir()
    (folder / "spectra" / "a.csv").write_text("edited")
    (folder / "data.csv").write_text("key,x,fate\n0,2,succeeded\n")
    teller.started().sent("main/a").ended(
        "main/a", files={"spectra/a.csv": "0" * 64, "spectra/b.csv": "1" * 64}
    )
    teller.iteration("0", row={"x": 1}, file="data.csv").finished()

    found = read()
    top = found.text.partition("What was done")[0]
    assert "Changed since the run wrote it: spectra/a.csv." in top
    assert "Written by the run, now missing: spectra/b.csv." in top
    assert "Does not match the journal's rows: data.csv." in top
    assert "2 are changed or missing" in found.text


def test_an_unfinished_run_is_not_blamed_for_a_table_that_resume_writes_again(folder, teller, read):
    (folder / "data.csv").write_text("key,x,fate\n0,1,succeeded\n1,1,succeeded\n")
    teller.started().iteration("0", row={"x": 1}, file="data.csv")

    assert "Does not match" not in read().text


def test_a_device_that_did_not_confirm_its_safe_state_is_said_at_the_top(folder, teller, read):
    teller.started().tell(j.SafeState(device="libs", confirmed=True, message="off"))
    teller.tell(j.SafeState(device="libs", confirmed=False, message="no answer")).finished("failed")

    top = read().text.partition("What was done")[0]
    assert "Safe state not confirmed: libs (no answer). Go and check." in top


def test_a_damaged_journal_gives_a_page_that_says_so(folder, teller, read):
    teller.started().worked("main/a").finished()
    teller.path.write_text(teller.path.read_text().replace("SUCCEEDED", "CANCELED"))

    assert "this report is incomplete" in read().text


@pytest.mark.parametrize("left", ["nothing", "empty", "unreadable"])
def test_a_run_without_inputs_still_has_a_page(folder, teller, read, left):
    for name in ("protocol.yaml", "lab.yaml", "run.json"):
        (folder / name).unlink()
        if left != "nothing":
            (folder / name).write_text("" if left == "empty" else "{[: \x01")
    teller.path.touch()

    assert "The journal has no readable record." in read().text


def test_tables_with_no_row_and_no_line_are_said_in_words(folder, teller, read):
    teller.started().finished()
    (folder / "data.csv").write_text("key,x_mm,fate\n")
    (folder / "data_2.csv").write_text("")

    found = read()
    assert "data.csv has columns (key, x_mm, fate) but no rows." in found.text
    assert "data_2.csv is empty." in found.text


def test_only_the_head_of_a_long_table_is_shown(folder, teller, read):
    teller.started()
    for i in range(40):
        teller.iteration(str(i), row={"x": i}, file="data.csv")
    rows = "".join(f"{i},{i},succeeded\n" for i in range(40))
    (folder / "data.csv").write_text("key,x,fate\n" + rows)
    teller.finished()

    assert "data.csv: 40 rows, the first 12" in read().text


@pytest.mark.slow
def test_ten_thousand_failures_and_holes_stay_a_page_that_can_be_opened(folder, teller, outline):
    teller.started()
    for i in range(5000):
        path = f"main/scan/{i}/shoot"
        teller.failed(path, message=f"nothing at {i}").failed(path, attempt=2)
        message = f"{path}: libs.measure: X: nothing at {i} {'abc'[i % 3]}"
        teller.iteration(str(i), "failed", message=message)
    teller.finished("failed", reason="too many")

    made = page(gather(folder))
    found = outline(made)
    assert len(made) < 300_000
    assert "10,000 actions failed" in found.text
    assert "5,000 failed again" in found.text and "5,000 ended in a hole" in found.text


@pytest.mark.slow
def test_ten_thousand_failures_that_are_all_different_stay_a_page_too(folder, teller, outline):
    teller.started()
    for i in range(10_000):
        word = "".join(chr(97 + int(digit)) for digit in str(i))
        teller.failed(f"main/scan/{i}/shoot", message=word)
        teller.iteration(str(i), "failed", message=f"main/scan/{i}/shoot: {word}")
        teller.tell(j.StepEnded(path=f"main/scan/{i}/log", fate="succeeded", message=word))
    teller.finished()

    made = page(gather(folder))
    assert len(made) < 1_500_000
    assert "And 9,800 incidents of other kinds" in outline(made).text


def test_what_was_changed_on_the_way_is_told_with_its_values(folder, teller, read):
    teller.started().finished("failed").tell(j.Resumed(count=1, labrun="0.1.0"))
    teller.tell(
        j.Changed(folder="changed/1", params={"pitch": {"$quantity": [3, "mm"]}})
    ).finished()

    assert "changed/1 pitch = 3 mm 0" in read().text


def test_the_pictures_come_first_then_words_then_what_failed_then_data_then_provenance(
    folder, teller, read
):
    teller.started(roles={"libs": "libs"}).tell(j.Planned(loop="main/scan", total=3))
    teller.failed("main/scan/0/shoot").iteration(
        "0", "failed", message="main/scan/0/shoot: no light"
    )
    teller.worked("main/scan/1/shoot").iteration("1", row={"x": 1}, file="data.csv")
    teller.finished("aborted", reason="aborted by Ada", holes=1)
    (folder / "data.csv").write_text("key,x,fate\n1,1,succeeded\n")
    (folder / "element_maps.png").write_bytes(png())

    found = read()
    order = [
        found.text.index(words)
        for words in (
            "Element maps (",
            "What was done",
            "Failed and cancelled",
            "data.csv: 1 row",
            "ledger l1",
        )
        if words in found.text
    ]
    assert order == sorted(order) and len(order) >= 4
    assert "Points: 1 of 3 measured, 1 failed, 1 left." in found.text


def test_a_hole_that_was_measured_again_is_none_and_the_report_says_who_asked(folder, teller, read):
    teller.started().tell(j.Planned(loop="main/scan", total=2))
    teller.failed("main/scan/0/shoot").iteration(
        "0", "failed", message="main/scan/0/shoot: no light"
    )
    teller.worked("main/scan/1/shoot").iteration("1").tell(j.LoopEnded(
        loop="main/scan", fate="succeeded", total=2, succeeded=1, failed=1, skipped=0
    ))  # fmt: skip
    teller.finished(holes=1)
    teller.tell(j.Redo(by="Ada", pass_number=2, iterations=["main/scan/0"]))
    teller.tell(j.Resumed(count=1, labrun="0.1.0"))
    teller.worked("main/scan/0/pass:2/shoot").iteration("0").finished()

    found = read()
    assert "The run succeeded, with no holes. Points: 2 of 2 measured." in found.text
    assert "Ada had 1 hole measured again." in found.text
    assert "a hole, which was measured again" in found.text
