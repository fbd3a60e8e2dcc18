"""`labrun calibrate-camera IMAGES...`: measure a lens from pictures of a chessboard."""

import json as json_text
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...drivers.cameras.vision.board import Board
from ...drivers.cameras.vision.camera_file import write_camera
from ...drivers.cameras.vision.lens import LensFault, LensFit, fit_lens, fit_pair
from ...drivers.cameras.vision.pictures import (
    PICTURES,
    PictureFault,
    read_picture,
    same_picture_size,
)
from .camera_options import board_size, length_mm, needs_vision
from .options import fail, say

if TYPE_CHECKING:
    import numpy as np

Images = Annotated[
    list[Path],
    typer.Argument(metavar="IMAGES...", help="Pictures of the board, or folders of them."),
]
BoardText = Annotated[
    str,
    typer.Option(
        "--board",
        metavar="9x6",
        help="Inner corners, columns x rows: one fewer than squares each way.",
    ),
]
Square = Annotated[
    str, typer.Option("--square", metavar="LENGTH", help='Side of a square: --square "25 mm".')
]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="CAM.yaml", help="The file to write; default: standard output."
    ),
]
SideBySide = Annotated[
    bool, typer.Option("--side-by-side", help="Each picture holds the left and the right view.")
]
Json = Annotated[bool, typer.Option("--json", help="Print the report as JSON.")]
FEW, LITTLE = 10, 0.6


def calibrate_camera(
    images: Images,
    board: BoardText,
    square: Square,
    output: Output = None,
    side_by_side: SideBySide = False,
    json: Json = False,
) -> None:
    """Measure a camera's lens, show how well each picture fits, and write it for `labrun locate`."""
    needs_vision()
    columns, rows = board_size(board)
    asked = Board(columns, rows, length_mm(square, "--square", above_zero=True))
    files = _files(images)
    greys, unread = _read(files)
    try:
        if not greys:
            raise PictureFault(next(iter(unread.values())))
        width, _ = same_picture_size(greys)
        if side_by_side:
            halves = {
                name: (one[:, : width // 2], one[:, width - width // 2 :])
                for name, one in greys.items()
            }
            fit = fit_pair(halves, asked)
        else:
            fit = fit_lens(greys, asked)
    except (LensFault, PictureFault) as fault:
        _name_left_out(unread)
        fail(str(fault))
    fit.left_out.update(unread)
    if output is not None:
        _write(output, fit)
    if json:
        print(json_text.dumps(_report(fit, output), indent=2))
        return
    _tell(fit, to_stderr=output is None)
    if output is None:
        import yaml

        print(
            yaml.safe_dump(fit.camera.to_dict(), sort_keys=False, default_flow_style=None), end=""
        )
    else:
        say(f"{output} written")


def _files(images: list[Path]) -> list[Path]:
    found: list[Path] = []
    for path in images:
        if not path.is_dir():
            found.append(path)
            continue
        try:
            inside = sorted(one for one in path.iterdir() if one.suffix.lower() in PICTURES)
        except OSError as fault:
            fail(f"{path} cannot be read: {fault.strerror}")
        if not inside:
            fail(f"{path} holds no pictures ({', '.join(PICTURES)})")
        found += inside
    return list(dict.fromkeys(found))


def _read(files: list[Path]) -> tuple[dict[str, "np.ndarray"], dict[str, str]]:
    """Grey pictures by name, and why the others cannot be read."""
    import cv2

    pictures: dict[str, np.ndarray] = {}
    unread: dict[str, str] = {}
    for path in files:
        try:
            pictures[str(path)] = cv2.cvtColor(read_picture(path), cv2.COLOR_BGR2GRAY)
        except PictureFault as fault:
            unread[str(path)] = str(fault)
    return pictures, unread


def _name_left_out(unread: dict[str, str]) -> None:
    for why in unread.values():
        say(f"left out: {why}")


def _write(output: Path, fit: LensFit) -> None:
    words = (
        f"made by labrun calibrate-camera from {len(fit.errors_px)} pictures; lengths in mm,\n"
        "pixels from the centre of the first one, distortion k1 k2 p1 p2 k3 in OpenCV's order"
    )
    try:
        write_camera(output, fit.camera, words)
    except OSError as fault:
        fail(f"{output} cannot be written: {fault.strerror}; name another file with -o")


def _tell(fit: LensFit, *, to_stderr: bool) -> None:
    width = max(map(len, [*fit.errors_px, *fit.left_out]))
    for name, error in fit.errors_px.items():
        remark = "  fits worse than the others" if name in fit.odd else ""
        typer.echo(f"{name:<{width}}  {error:.3f} pixel{remark}", err=to_stderr)
    for name, why in fit.left_out.items():
        typer.echo(f"{name:<{width}}  left out: {why}", err=to_stderr)
    eye = fit.camera.left
    u, v = eye.matrix[:2, 2]
    lines = [
        f"reprojection error {fit.rms_px:.3f} pixel (rms) over {len(fit.errors_px)} pictures of "
        f"{eye.width} x {eye.height}",
        f"focal length {eye.focal_px:.1f} pixel, give or take {fit.focal_sd_px:.1f}; "
        f"optical axis at pixel {u:.1f}, {v:.1f}",
        f"distortion {', '.join(f'{k:.4f}' for k in eye.distortion[:5])} (k1 k2 p1 p2 k3)",
    ]
    if fit.camera.shift_mm is not None:
        away = sum(float(part) ** 2 for part in fit.camera.shift_mm) ** 0.5
        lines.append(f"the eyes are {away:.2f} mm apart")
    typer.echo("\n".join(lines + _advice(fit)), err=to_stderr)


def _advice(fit: LensFit) -> list[str]:
    advice = []
    if len(fit.errors_px) < FEW:
        advice.append(
            f"more pictures give a surer result: {FEW} to 20, each with the board held differently"
        )
    if fit.covered < LITTLE:
        advice.append(
            f"the board covered only {fit.covered:.0%} of the picture: hold it in the corners "
            "too, where distortion is largest"
        )
    return advice


def _report(fit: LensFit, output: Path | None) -> dict[str, Any]:
    used = [
        {"image": n, "used": True, "rms": round(e, 4), "odd": n in fit.odd}
        for n, e in fit.errors_px.items()
    ]
    left_out = [{"image": name, "used": False, "why": why} for name, why in fit.left_out.items()]
    return {
        "rms": round(fit.rms_px, 4),
        "focal": round(fit.camera.left.focal_px, 3),
        "focal_sd": round(fit.focal_sd_px, 3),
        "covered": round(fit.covered, 3),
        "images": used + left_out,
        "camera": fit.camera.to_dict(),
        "written": None if output is None else str(output),
        "advice": _advice(fit),
    }
