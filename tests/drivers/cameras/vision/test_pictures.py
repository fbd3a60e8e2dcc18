"""Pictures and depth maps from files, and sentences about what is none."""

import cv2
import numpy as np
import pytest

from labrun.drivers.cameras.vision.pictures import (
    PictureFault,
    read_depth,
    read_picture,
    same_picture_size,
)

COLOURS = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)
DEPTH = np.array([[5000, 0], [6000, 65535]], np.uint16)


def test_a_picture_has_three_colours_also_where_the_file_is_grey(tmp_path):
    cv2.imwrite(str(tmp_path / "a.png"), COLOURS)
    cv2.imwrite(str(tmp_path / "b.png"), COLOURS[..., 0])

    assert np.array_equal(read_picture(tmp_path / "a.png"), COLOURS)
    assert read_picture(tmp_path / "b.png").shape == (4, 6, 3)


def test_a_depth_map_of_16_bit_is_in_tenths_and_0_is_unknown(tmp_path):
    cv2.imwrite(str(tmp_path / "d.png"), DEPTH)
    depth = read_depth(tmp_path / "d.png")

    assert depth[0, 0] == 500 and depth[1, 1] == pytest.approx(6553.5)
    assert np.isnan(depth[0, 1])
    assert read_depth(tmp_path / "d.png", unit_mm=1)[1, 0] == 6000


def test_floating_depth_is_in_millimetres_and_what_cannot_be_is_unknown(tmp_path):
    depth = np.array([[500.5, np.nan], [np.inf, -3]], np.float32)
    np.save(tmp_path / "d.npy", depth)
    cv2.imwrite(str(tmp_path / "d.tiff"), depth)

    for name in ("d.npy", "d.tiff"):
        read = read_depth(tmp_path / name)

        assert read[0, 0] == 500.5
        assert np.isnan(read).sum() == 3


def test_what_is_no_picture_is_said(tmp_path):
    (tmp_path / "text.png").write_text("not a picture")
    (tmp_path / "empty.png").write_bytes(b"")
    cv2.imwrite(str(tmp_path / "torn.png"), COLOURS)
    whole = (tmp_path / "torn.png").read_bytes()
    (tmp_path / "torn.png").write_bytes(whole[:30])
    cv2.imwrite(str(tmp_path / "colours.png"), COLOURS)
    (tmp_path / "bad.npy").write_bytes(b"\x93NUMPY\x01")
    np.save(tmp_path / "words.npy", np.array(["a", "b"]))
    cases = [
        (
            read_picture,
            "text.png",
            "text.png is not a picture (PNG, JPEG, TIFF, BMP, WebP), or it is damaged",
        ),
        (read_picture, "torn.png", "or it is damaged"),
        (read_picture, "empty.png", "is empty"),
        (read_picture, "none.png", "No such file"),
        (read_picture, ".", "Is a directory"),
        (read_depth, "colours.png", "a picture of 8 bits, not a depth map"),
        (read_depth, "bad.npy", "is not a NumPy array of numbers"),
        (read_depth, "words.npy", "is not a NumPy array of numbers"),
    ]
    for read, name, words in cases:
        with pytest.raises(PictureFault) as found:
            read(tmp_path / name)

        assert words in str(found.value)


def test_pictures_of_several_sizes_are_named_with_their_sizes():
    pictures = {f"{n}.png": np.zeros((720, 1280)) for n in range(5)} | {"x.png": np.zeros((4, 6))}
    with pytest.raises(PictureFault) as found:
        same_picture_size(pictures)

    assert "1280 x 720: 0.png, 1.png, 2.png and 2 more; 6 x 4: x.png" in str(found.value)
