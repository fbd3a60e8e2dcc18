"""`labrun locate`: where on the bench the thing at one pixel of a photograph is."""

import json as json_text
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from ...drivers.driver import ActionFailed
from ...drivers.vision import measure
from ...drivers.vision.board import RUNS, Board
from ...drivers.vision.camera import Camera, CameraFault, of_size
from ...drivers.vision.camera_file import read_cameras
from ...drivers.vision.pictures import PictureFault, read_depth, read_picture
from ...drivers.vision.view import DepthView, StereoView, View
from .camera_options import board_size, length_mm, pair_of_numbers, stop

Image = Annotated[
    Path, typer.Option("--image", metavar="RGB", help="The photograph, with the board in it.")
]
Depth = Annotated[
    Path | None,
    typer.Option("--depth", metavar="DEPTH", help="Its depth map: 16-bit PNG, .npy or float TIFF."),
]
CameraPath = Annotated[
    Path,
    typer.Option(
        "--camera", metavar="CAM.yaml", help="The lens: labrun's, OpenCV's or a ZED's file."
    ),
]
Pixel = Annotated[
    str, typer.Option("--pixel", metavar="u,v", help="Column from the left, row from the top.")
]
Height = Annotated[
    str | None,
    typer.Option("--height", metavar="LENGTH", help='Its height, if known: --height "3 mm".'),
]
BoardText = Annotated[
    str | None,
    typer.Option("--board", metavar="9x6", help="Inner corners; else those of the camera file."),
]
Square = Annotated[
    str | None, typer.Option("--square", metavar="LENGTH", help="A square of the board.")
]
At = Annotated[
    str,
    typer.Option(
        "--board-at", metavar="x,y", help='The first corner on the bench: "100 mm,300 mm".'
    ),
]
Unit = Annotated[
    str | None,
    typer.Option("--depth-unit", metavar="LENGTH", help='One step of the depth map: "1 mm".'),
]
Runs = Annotated[
    str,
    typer.Option(
        "--x-runs", metavar="WAY", help="How bench x runs in the picture: right, up, left, down."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="The answer as JSON.")]


def locate(
    image: Image,
    camera: CameraPath,
    pixel: Pixel,
    depth: Depth = None,
    height: Height = None,
    board: BoardText = None,
    square: Square = None,
    board_at: At = "0,0",
    depth_unit: Unit = None,
    x_runs: Runs = "right",
    json: Json = False,
) -> None:
    """Say where on the bench a pixel points: by its depth, or by its height where that is known."""
    u, v = pair_of_numbers(pixel, "--pixel")
    height_mm = None if height is None else length_mm(height, "--height")
    step_mm = None if depth_unit is None else length_mm(depth_unit, "--depth-unit", above_zero=True)
    if x_runs not in RUNS:
        stop(f"--x-runs {x_runs}: it is one of {', '.join(RUNS)}")
    try:
        view, known = _view(image, depth, camera, step_mm, x_runs)
        fit = measure.calibrate(view, _board(known, board, square, board_at, camera))
        point = measure.locate(view, fit, u, v, height_mm)
    except (PictureFault, CameraFault) as fault:
        stop(str(fault))
    except ActionFailed as failure:
        stop(f"{image}: {failure.message}")
    x, y, z = (round(float(part), 2) for part in fit.pose.place_mm)
    seen: dict[str, Any] = {
        "camera": {"x": x, "y": y, "z": z, "tilt": round(fit.pose.tilt_deg, 2)},
        "rms": round(fit.rms_px, 4),
    }
    if json:
        print(json_text.dumps({**point, **seen}))
        return
    typer.echo(f"x {point['x']:.2f} mm, y {point['y']:.2f} mm, z {point['z']:.2f} mm")
    typer.echo(f"within {point['uncertainty']:.2f} mm, 19 times of 20")
    typer.echo(
        f"the camera is at x {x:.1f}, y {y:.1f}, z {z:.1f} mm, tilted {fit.pose.tilt_deg:.1f} degrees; "
        f"the board fits to {fit.rms_px:.2f} pixel"
    )


def _view(
    image: Path, depth: Path | None, file: Path, step_mm: float | None, x_runs: str
) -> tuple[View, Camera]:
    """What is seen, and the camera that saw it: two eyes where the picture is twice as wide as one's."""
    cameras = read_cameras(file)
    picture = read_picture(image)
    rows, columns = picture.shape[:2]
    two_eyed = [
        one for one in cameras if one.right is not None and one.size == (columns // 2, rows)
    ]
    if depth is None and two_eyed:
        half = columns // 2
        return StereoView.of(picture[:, :half], picture[:, half:], two_eyed[0], x_runs), two_eyed[0]
    camera = of_size(cameras, columns, rows, file)
    if depth is None:
        return View(picture, camera.left, x_runs), camera
    return DepthView(picture, read_depth(depth, step_mm), camera.left, x_runs), camera


def _board(camera: Camera, size: str | None, square: str | None, at: str, file: Path) -> Board:
    """The board as told, or as the camera file remembers it."""
    board = camera.board
    if board is None and (size is None or square is None):
        stop(f'{file} does not say which board lies on the bench: add --board 9x6 --square "25 mm"')
    board = board or Board()
    if size is not None:
        columns, rows = board_size(size)
        board = replace(board, columns=columns, rows=rows)
    if square is not None:
        board = replace(board, square_mm=length_mm(square, "--square", above_zero=True))
    x_mm, y_mm = pair_of_numbers(at, "--board-at", "mm")
    return replace(board, x_mm=x_mm, y_mm=y_mm)
