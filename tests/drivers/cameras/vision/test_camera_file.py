"""Cameras from files of every kind that is promised, and sentences about those that are none."""

import cv2
import numpy as np
import pytest

from labrun.drivers.cameras.vision.board import Board
from labrun.drivers.cameras.vision.camera import Camera, CameraFault, of_size
from labrun.drivers.cameras.vision.camera_file import read_cameras, write_camera
from labrun.drivers.cameras.vision.intrinsics import Intrinsics

MATRIX = np.array([[1065.2, 0, 651.4], [0, 1064.8, 349.7], [0, 0, 1]])
DISTORTION = np.array([-0.06, 0.03, 0.001, -0.002, 0.004])
EYE = Intrinsics(1280, 720, MATRIX, DISTORTION)
ZED = """[LEFT_CAM_2K]
fx=1900.5
fy=1900.6
cx=1110.1
cy=620.2
k1=-0.04
k2=0.009
p1=0.0001
p2=0.0002
k3=-0.005

[RIGHT_CAM_2K]
fx=1901.5
fy=1901.6
cx=1111.1
cy=621.2
k1=-0.041
k2=0.0091
p1=0.0003
p2=0.0004
k3=-0.0051

[LEFT_CAM_HD]
fx=1065.5
fy=1065.6
cx=640.1
cy=360.2
k1=-0.04
k2=0.009

[RIGHT_CAM_HD]
fx=1066.5
fy=1066.6
cx=641.1
cy=361.2
k1=-0.041
k2=0.0091

[STEREO]
Baseline=119.93
TY=0.1
TY_HD=0.05
TZ_HD=-0.2
CV_2K=0.001
CV_HD=0.002
RX_HD=-0.003
RZ_HD=0.0004
"""


def same(one: Intrinsics, other: Intrinsics) -> bool:
    alike = np.allclose(one.matrix, other.matrix), np.allclose(one.distortion, other.distortion)
    return all(alike) and (one.width, one.height) == (other.width, other.height)


def fault(path) -> str:
    with pytest.raises(CameraFault) as found:
        read_cameras(path)
    return str(found.value)


def test_what_labrun_writes_it_reads_again(tmp_path):
    turn = cv2.Rodrigues(np.array([0.01, -0.02, 0.003]))[0]
    board = Board(8, 5, 12.5)
    camera = Camera(EYE, EYE, turn, np.array([-60.0, 0.1, 0.2]), board, 0.21)
    write_camera(tmp_path / "deep" / "cam.yaml", camera, "two\nlines")
    (read,) = read_cameras(tmp_path / "deep" / "cam.yaml")

    assert same(read.left, EYE) and read.right is not None and same(read.right, EYE)
    assert np.allclose(read.turn, turn) and read.shift_mm.tolist() == [-60, 0.1, 0.2]
    assert (read.board, read.rms_px) == (board, 0.21)
    assert (tmp_path / "deep" / "cam.yaml").read_text().startswith("# two\n# lines\nwidth: 1280\n")


@pytest.mark.parametrize("ending", ["yml", "xml", "json"])
def test_opencv_s_own_files_are_read(tmp_path, ending):
    path = tmp_path / f"cam.{ending}"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 1280)
    storage.write("image_height", 720)
    storage.write("camera_matrix", MATRIX)
    storage.write("distortion_coefficients", DISTORTION.reshape(1, 5))
    storage.write("avg_reprojection_error", 0.31)
    storage.release()
    (read,) = read_cameras(path)

    assert same(read.left, EYE)
    assert read.right is None and read.rms_px == 0.31


def test_opencv_s_stereo_sample_is_read_and_fits_any_size_whose_middle_is_right(tmp_path):
    path = tmp_path / "stereo.yml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, value in (("M1", MATRIX), ("D1", DISTORTION), ("M2", MATRIX + 1), ("D2", DISTORTION)):
        storage.write(name, value)
    storage.write("R", np.eye(3))
    storage.write("T", np.array([[-60.0], [0], [0]]))
    storage.release()
    cameras = read_cameras(path)
    camera = of_size(cameras, 1280, 720, path)

    assert camera.size == (1280, 720) and camera.shift_mm.tolist() == [-60, 0, 0]
    assert camera.right.matrix[0, 0] == pytest.approx(1066.2)
    with pytest.raises(CameraFault, match="another picture size, and this one is 640 x 360"):
        of_size(cameras, 640, 360, path)


def test_ros_camera_info_is_read(tmp_path):
    path = tmp_path / "head.yaml"
    path.write_text(
        "image_width: 1280\nimage_height: 720\ncamera_name: head\n"
        f"camera_matrix: {{rows: 3, cols: 3, data: {MATRIX.ravel().tolist()}}}\n"
        "distortion_model: plumb_bob\n"
        f"distortion_coefficients: {{rows: 1, cols: 5, data: {DISTORTION.tolist()}}}\n"
    )

    assert same(read_cameras(path)[0].left, EYE)


def test_a_zed_s_file_knows_two_lenses_for_each_size_of_picture(tmp_path):
    path = tmp_path / "SN123.conf"
    path.write_text(ZED)
    cameras = read_cameras(path)
    camera = of_size(cameras, 1280, 720, path)

    assert [one.size for one in cameras] == [(2208, 1242), (1280, 720)]
    assert camera.left.matrix.tolist() == [[1065.5, 0, 640.1], [0, 1065.6, 360.2], [0, 0, 1]]
    assert camera.right.distortion.tolist() == [-0.041, 0.0091, 0, 0, 0]
    assert camera.shift_mm.tolist() == [-119.93, -0.05, 0.2]
    assert np.allclose(camera.turn, cv2.Rodrigues(np.array([-0.003, 0.002, 0.0004]))[0])


def test_a_file_of_another_resolution_is_refused_with_both(tmp_path):
    path = tmp_path / "SN123.conf"
    path.write_text(ZED)
    with pytest.raises(CameraFault) as found:
        of_size(read_cameras(path), 1920, 1080, path)

    assert "pictures of 2208 x 1242 and 1280 x 720, and this one is 1920 x 1080" in str(found.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "does not describe a camera"),
        ("- 1\n- 2\n", "does not describe a camera"),
        ("a: [1\nb: 2", "is not YAML in line 2"),
        ("width: 1280\nheight: 720\n", "has no matrix"),
        ("width: 1280\nheight: 720\nmatrix: [[1, 2], [3, 4]]", "matrix must be 3 x 3 numbers"),
        ("width: 1280\nheight: 720\nmatrix: [[-1,0,1],[0,1,1],[0,0,1]]", "fx and fy above 0"),
        ("width: 9\nheight: 7\nmatrix: [[1,0,1],[0,1,1],[0,0,1]]\ndistortion: [1, 2]", "not 2"),
        ("width: wide\nheight: 720\n", "does not describe a camera"),
        ("%YAML:1.0\n---\nimage_width: 3\n", "there is no camera matrix"),
        ("%YAML:1.0\n---\n\t- [", "OpenCV cannot read this"),
        ("[LEFT_CAM_HD]\nfx=1\n[STEREO]\nBaseline=120\n", "no pair of lenses"),
        (ZED.replace("119.93", "far"), "baseline is 'far', not a number"),
        (ZED.replace("Baseline=119.93", ""), "has no baseline"),
        (ZED.replace("fx=1065.5", "fx=0"), "must be above 0"),
    ],
)
def test_what_is_no_camera_is_said_in_a_sentence(tmp_path, text, words):
    path = tmp_path / "cam.yaml"
    path.write_text(text)
    said = fault(path)

    assert words in said
    assert str(path) in said and "\n" not in said


def test_files_that_are_not_there_or_no_text_are_said(tmp_path):
    (tmp_path / "cam.yaml").write_bytes(b"\x89PNG\xff\xfe")

    assert "No such file" in fault(tmp_path / "none.yaml")
    assert "Is a directory" in fault(tmp_path)
    assert "is not text" in fault(tmp_path / "cam.yaml")
