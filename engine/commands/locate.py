"""`labrun locate`: where on the bench one pixel of a photograph is."""

import json as json_text
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from ...drivers.cameras.vision import measure
from ...drivers.cameras.vision.board import RUNS, Board
from ...drivers.cameras.vision.camera import Camera, CameraFault
from ...drivers.cameras.vision.camera_file import read_cameras
from ...drivers.cameras.vision.pictures import PictureFault, read_depth, read_picture
from ...drivers.cameras.vision.view import view_of
from ...drivers.driver import ActionFailed
from .camera_options import board_size, length_mm, needs_vision, pair_of_numbers
from .options import fail

Image = Annotated[
    Path, typer.Option("--image", metavar="RGB", help="The photograph, which shows the board.")
]
Depth = Annotated[
    Path | None,
    typer.Option("--depth", metavar="DEPTH", help="Its depth map: 16-bit PNG, .npy or float TIFF."),
]
CameraPath = Annotated[
    Path,
    typer.Option(
        "--camera", metavar="CAM.yaml", help="The camera file: labrun's, OpenCV's or a ZED's."
    ),
]
Pixel = Annotated[
    str, typer.Option("--pixel", metavar="u,v", help="Column from the left, row from the top.")
]
Height = Annotated[
    str | None,
    typer.Option(
        "--height", metavar="LENGTH", help='Height of the point, if known: --height "3 mm".'
    ),
]
BoardText = Annotated[
    str | None,
    typer.Option(
        "--board", metavar="9x6", help="Inner corners; default: those of the camera file."
    ),
]
Square = Annotated[
    str | None, typer.Option("--square", metavar="LENGTH", help="Side of a square of the board.")
]
At = Annotated[
    str,
    typer.Option(
        "--board-at", metavar="x,y", help='Bench position of the first corner: "100 mm,300 mm".'
    ),
]
Unit = Annotated[
    str | None,
    typer.Option("--depth-unit", metavar="LENGTH", help='One step of the depth map: "1 mm".'),
]
Runs = Annotated[
    str,
    typer.Option(
        "--x-runs",
        metavar="WAY",
        help="Direction of bench x in the picture: right, up, left, down.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")]


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
    """Show where on the bench a pixel points, from its depth, or from its height if known."""
    needs_vision()
    u, v = pair_of_numbers(pixel, "--pixel")
    height_mm = None if height is None else length_mm(height, "--height")
    step_mm = None if depth_unit is None else length_mm(depth_unit, "--depth-unit", above_zero=True)
    if x_runs not in RUNS:
        fail(f"--x-runs {x_runs}: choose one of {', '.join(RUNS)}")
    try:
        cameras, picture = read_cameras(camera), read_picture(image)
        far = read_depth(depth, step_mm) if depth is not None else None
        view, known = view_of(picture, cameras, camera, x_runs, depth=far)
        fit = measure.calibrate(view, _board(known, board, square, board_at, camera))
        point = measure.locate(view, fit, u, v, height_mm)
    except (PictureFault, CameraFault) as fault:
        fail(str(fault))
    except ActionFailed as failure:
        fail(f"{image}: {failure.message}")
    x, y, z = (round(float(part), 2) for part in fit.pose.place_mm)
    seen: dict[str, Any] = {
        "camera": {"x": x, "y": y, "z": z, "tilt": round(fit.pose.tilt_deg, 2)},
        "rms": round(fit.rms_px, 4),
    }
    if json:
        print(json_text.dumps({**point, **seen}))
        return
    typer.echo(f"x {point['x']:.2f} mm, y {point['y']:.2f} mm, z {point['z']:.2f} mm")
    typer.echo(f"within {point['uncertainty']:.2f} mm, 19 times out of 20")
    typer.echo(
        f"the camera is at x {x:.1f}, y {y:.1f}, z {z:.1f} mm, tilted {fit.pose.tilt_deg:.1f} degrees; "
        f"the board fits to {fit.rms_px:.2f} pixel"
    )


def _board(camera: Camera, size: str | None, square: str | None, at: str, file: Path) -> Board:
    """The board from the options, or else from the camera file."""
    board = camera.board
    if board is None and (size is None or square is None):
        fail(f'{file} does not state which board is on the bench: add --board 9x6 --square "25 mm"')
    board = board or Board()
    if size is not None:
        columns, rows = board_size(size)
        board = replace(board, columns=columns, rows=rows)
    if square is not None:
        board = replace(board, square_mm=length_mm(square, "--square", above_zero=True))
    x_mm, y_mm = pair_of_numbers(at, "--board-at", "mm")
    return replace(board, x_mm=x_mm, y_mm=y_mm)
