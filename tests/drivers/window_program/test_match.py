"""Buttons are found at any size, none where there is none, and nothing is guessed."""

import random
from dataclasses import replace

import cv2
import numpy as np
import pytest

from labrun.drivers.window_program.match import Template, differs, look_for, unfit

WANTED, OF = 49, 50
MAIN = ("measure", "export", "sync", "delete", "sample_name")


def templates(seen_at, look):
    picture, places = seen_at(look, 1.0)
    cut = {n: picture[y : y + h, x : x + w] for n, (x, y, w, h) in places.items()}
    return [Template(name, cut[name]) for name in MAIN]


def right(sight, place) -> bool:
    x, y, w, h = place
    hit = sight.sure
    centre = (x + w / 2, y + h / 2)
    return hit is not None and all(
        abs(a - b) < s / 4 for a, b, s in zip(hit.centre, centre, (w, h), strict=True)
    )


LOOKS = [
    "grey",
    pytest.param("dark", marks=pytest.mark.soak),
    pytest.param("paper", marks=pytest.mark.soak),
]


@pytest.mark.slow
@pytest.mark.parametrize("scale", [0.5, 1.3, pytest.param(2.0, marks=pytest.mark.soak)])
def test_every_button_is_found_at_half_and_at_double_size(seen_at, scale):
    picture, places = seen_at("grey", scale)
    sights = look_for(picture, templates(seen_at, "grey"))

    assert [s.words() for name, s in sights.items() if not right(s, places[name])] == []


@pytest.mark.soak
@pytest.mark.timeout(600)
@pytest.mark.parametrize("look", ["grey", "dark", "paper"])
def test_buttons_are_found_49_of_50_times_from_half_to_double_size(seen_at, look):
    recorded = templates(seen_at, look)
    draw = random.Random(f"sizes {look}")
    scales = [0.5, 2.0, *(0.5 * 4 ** draw.random() for _ in range(8))]
    missed = []
    for scale in scales:
        picture, places = seen_at(look, scale)
        for name, sight in look_for(picture, recorded).items():
            if not right(sight, places[name]):
                missed.append((round(scale, 2), sight.words()))

    assert OF - len(missed) >= WANTED, missed


@pytest.mark.slow
def test_a_button_that_is_not_there_is_not_found(seen_at):
    picture, _ = seen_at("grey", 1.2, without=["measure"])
    sights = look_for(picture, templates(seen_at, "grey"))

    assert [name for name, sight in sights.items() if not sight.hits] == ["measure"]


@pytest.mark.slow
def test_a_picture_that_was_seen_before_is_answered_as_before_and_any_other_anew(seen_at):
    picture, places = seen_at("grey", 1.0)
    recorded = templates(seen_at, "grey")[:2]
    covered = picture.copy()
    x, y, w, h = places["measure"]
    covered[y : y + h, x : x + w] = picture[0, 0]

    first = look_for(picture, recorded, 1.0)
    gone = look_for(covered, recorded, 1.0)
    stricter = look_for(picture, [replace(t, threshold=1.0) for t in recorded], 1.0)

    assert right(first["measure"], places["measure"])
    assert not gone["measure"].hits and gone["export"] == first["export"]
    assert not stricter["measure"].hits
    assert look_for(picture.copy(), recorded, 1.0) == first


@pytest.mark.soak
@pytest.mark.timeout(600)
def test_no_button_is_found_where_there_is_none(seen_at):
    recorded = templates(seen_at, "grey")
    draw = random.Random("none")
    found = []
    for name in MAIN:
        picture, _ = seen_at("grey", 0.5 * 4 ** draw.random(), without=[name])
        found += look_for(picture, recorded)[name].hits
    for look in ("dark", "paper"):
        picture, _ = seen_at(look, 0.5 * 4 ** draw.random(), without=["sample_name"])
        found += [hit for sight in look_for(picture, recorded).values() for hit in sight.hits]

    assert found == []


def button(text: str, ink=(20, 20, 20), back=(225, 225, 225)) -> np.ndarray:
    picture = np.full((40, 120, 3), back, np.uint8)
    cv2.rectangle(picture, (1, 1), (118, 38), (120, 120, 120), 1)
    cv2.putText(picture, text, (10, 27), cv2.FONT_HERSHEY_SIMPLEX, 0.7, ink, 2, cv2.LINE_AA)
    return picture


def window(*placed) -> np.ndarray:
    picture = np.full((300, 500, 3), 245, np.uint8)
    for (x, y), part in placed:
        picture[y : y + part.shape[0], x : x + part.shape[1]] = part
    return picture


FIRE = Template("measure", button("Fire"))


def test_the_same_button_twice_is_refused():
    sight = look_for(window(((30, 40), FIRE.picture), ((300, 200), FIRE.picture)), [FIRE])[
        "measure"
    ]

    assert sight.sure is None
    assert sight.words().startswith("measure is there 2 times, at ")


def test_a_greyed_out_button_is_known_as_such():
    faint = button("Fire", ink=(190, 190, 190))
    sight = look_for(window(((30, 40), faint)), [FIRE], 1.0)["measure"]

    assert sight.sure is not None and sight.sure.grey
    assert "greyed out" in sight.words()


@pytest.mark.slow
@pytest.mark.parametrize("look", LOOKS)
def test_a_program_that_is_busy_is_seen_to_be(seen_at, look):
    recorded = templates(seen_at, look)
    picture, _ = seen_at(look, 1.2, busy=True)
    sights = look_for(picture, recorded)

    assert sights["sample_name"].sure is not None
    assert look_for(picture, recorded, 1.2)["measure"].sure.grey


def test_the_same_letters_in_another_colour_are_another_button():
    red = button("Fire", back=(225, 90, 90))
    sight = look_for(window(((30, 40), red)), [FIRE])["measure"]

    assert sight.hits == ()
    assert "another colour" in sight.words()


def test_a_place_that_another_button_fits_better_is_that_button():
    alike, rival = button("Fine"), Template("fine", button("Fine"))
    picture = window(((30, 40), alike))

    assert look_for(picture, [FIRE], 1.0)["measure"].hits
    assert look_for(picture, [FIRE], 1.0, rivals=[rival])["measure"].hits == ()


def test_rows_that_stand_close_to_one_another_do_not_hide_one_another():
    names = ("First row", "Second row", "Third row")
    rows = [Template(name, button(name)[8:32]) for name in names]
    picture = window(*((((30, 40 + 26 * n)), row.picture) for n, row in enumerate(rows)))

    for row in rows:
        assert look_for(picture, [row], 1.0, rivals=rows)[row.name].sure is not None


def label(text: str) -> np.ndarray:
    picture = np.full((26, 14 * len(text), 3), 245, np.uint8)
    cv2.putText(picture, text, (4, 19), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (20,) * 3, 1, cv2.LINE_AA)
    return picture


def test_the_last_word_of_a_longer_label_is_not_a_shorter_one():
    short, longer = (
        Template("name", label("name:")),
        Template("sample_name", label("The sample's own name:")),
    )
    picture = window(((30, 40), longer.picture))

    assert look_for(picture, [short], 1.0)["name"].hits
    assert look_for(picture, [short], 1.0, rivals=[longer])["name"].hits == ()
    assert look_for(picture, [longer], 1.0, rivals=[short])["sample_name"].sure is not None


def test_a_rival_in_another_colour_takes_nothing_away():
    blurred = cv2.GaussianBlur(FIRE.picture, (0, 0), 1.0)
    red = Template("red", blurred // np.array([1, 2, 2], np.uint8))

    assert look_for(window(((30, 40), blurred)), [FIRE], 1.0, [red])["measure"].sure is not None


@pytest.mark.parametrize(
    ("picture", "words"),
    [
        (np.zeros((8, 90, 3), np.uint8), "90 x 8 pixels are too few"),
        (np.full((30, 90, 3), 200, np.uint8), "it is a single colour"),
    ],
)
def test_a_template_that_would_fit_anywhere_is_refused(picture, words):
    assert words in unfit(picture)
    assert unfit(FIRE.picture) is None


def test_a_blinking_cursor_is_no_change():
    before = window()
    blink, dialog = before.copy(), before.copy()
    blink[50:70, 40:42] = 0
    dialog[50:120, 40:200] = 200

    assert not differs(before, blink)
    assert differs(before, dialog)
