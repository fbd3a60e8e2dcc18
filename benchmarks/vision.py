"""Accuracy of positions from a camera: rendered scenes with noise, and its stated uncertainty.

Each scene is a bench seen from up to 1 m at 20 to 45 degrees by a lens with distortion, a board of
9 x 6 corners of 25 mm on it (200 x 125 mm). The corners that are found get noise of 0.3 pixel, every
pixel of the depth map noise of 0.5 %. `scenes.py` holds the truth: a projection of its own.
The ratios are errors over what is wanted: 95 of 100 within 1 mm in XY and 2 mm in Z by depth, within
0.9 mm in XY where the height is known. Run: python benchmarks/vision.py
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from scenes import Chessboard, Lens, Stand, photograph, stand

from labrun.drivers.cameras.vision.board import Board, corners_on_bench, find_corners
from labrun.drivers.cameras.vision.depth import depth_around
from labrun.drivers.cameras.vision.intrinsics import Intrinsics
from labrun.drivers.cameras.vision.measure import calibrate
from labrun.drivers.cameras.vision.pixel_position import (
    point_at_depth,
    point_at_height,
    uncertainty_mm,
)
from labrun.drivers.cameras.vision.pose import Calibration, fit_pose
from labrun.drivers.cameras.vision.view import DepthView, View

LENS = Lens(distortion=(-0.06, 0.03, 0.0008, -0.0005, 0.0))
BOARD = Chessboard()
CORNER_PX, DEPTH_SHARE = 0.3, 0.005
WANTED = {"XY by depth": 1.0, "Z by depth": 2.0, "XY, height known": 0.9}
AWAY = (500.0, 1000.0)  # mm, from the board's middle
AROUND = 50.0  # mm around the board, where things are looked for


def place(random: np.random.Generator) -> Stand:
    """A camera somewhere up to 1 m from the board's middle."""
    away, tilt = random.uniform(*AWAY), random.uniform(20, 45)
    return stand(BOARD.middle(), away, tilt, random.uniform(-20, 20), random.uniform(-8, 8))


def eye() -> Intrinsics:
    """The lens as labrun knows it."""
    return Intrinsics(LENS.width, LENS.height, LENS.matrix(), np.array(LENS.distortion))


def calibrated(corners: np.ndarray) -> Calibration:
    """The camera pose as labrun estimates it."""
    board = Board(BOARD.columns, BOARD.rows, BOARD.square, BOARD.x, BOARD.y)
    return fit_pose(corners, board, eye())


def noisy_depth(
    at: Stand, u: float, v: float, random: np.random.Generator, height: float = 0.0
) -> np.ndarray:
    """A depth map of the bench with its noise, known only around one pixel."""
    depth = np.full((LENS.height, LENS.width), np.nan, np.float32)
    rows, columns = (slice(max(0, round(w) - 8), round(w) + 9) for w in (v, u))
    j, i = np.mgrid[rows, columns][:, : LENS.height, : LENS.width]
    inside = (j < LENS.height) & (i < LENS.width)
    rays = LENS.rays(np.stack([i, j], -1).astype(float)) @ at.turn
    exact = (height - at.place[2]) / rays[..., 2]
    depth[j[inside], i[inside]] = (exact * random.normal(1, DEPTH_SHARE, exact.shape))[inside]
    return depth


def errors(
    at: Stand, fit: Calibration, random: np.random.Generator, points: int, truth: Chessboard = BOARD
) -> list[tuple[float, float, float, bool, bool]]:
    """For points: XY and Z off by depth, XY off by height, whether each is as near as told."""
    corners, lens = truth.corners()[..., :2], eye()
    low, high = corners.min(axis=(0, 1)) - AROUND, corners.max(axis=(0, 1)) + AROUND
    found = []
    while len(found) < points:
        place = np.array([*random.uniform(low, high), truth.height])
        u, v = LENS.pixels(at.seen(place))
        if not lens.holds(u - 10, v - 10) or not lens.holds(u + 10, v + 10):
            continue
        depth = noisy_depth(at, u, v, random, truth.height)
        view = DepthView(np.zeros((LENS.height, LENS.width, 3), np.uint8), depth, lens)
        ahead, spread = depth_around(view.depth, u, v)
        by_depth = point_at_depth(fit.pose, lens, u, v, ahead) - place
        by_height = point_at_height(fit.pose, lens, u, v, truth.height) - place
        sd = view.depth_sd_mm(ahead, spread)
        told = [
            uncertainty_mm(fit, lens, u, v, height, ahead, sd) for height in (None, truth.height)
        ]
        found.append((
            float(np.hypot(*by_depth[:2])), abs(float(by_depth[2])), float(np.hypot(*by_height[:2])),
            bool(np.linalg.norm(by_depth) <= told[0]), bool(np.linalg.norm(by_height) <= told[1]),
        ))  # fmt: skip
    return found


def scene(random: np.random.Generator, points: int, rendered: bool) -> list:
    """One scene: its corners found in a photograph, or projected; noise added; points looked for."""
    while True:
        at = place(random)
        truth = LENS.pixels(at.seen(BOARD.corners()))
        if truth.min() > 30 and (truth < (LENS.width - 30, LENS.height - 30)).all():
            break
    corners = truth
    if rendered:
        grey, _ = photograph(LENS, at, BOARD, random)
        board = Board(BOARD.columns, BOARD.rows, BOARD.square, BOARD.x, BOARD.y)
        corners = corners_on_bench(grey, find_corners(grey, board))
    fit = calibrated(corners + random.normal(0, CORNER_PX, corners.shape))
    return errors(at, fit, random, points)


LYING = [(angle, height) for height in (0.0, 12.7) for angle in (0.0, 7.0, -12.0, 88.0, 0.3, 45.0)]
"""Twelve boards as people lay them: turned by so many degrees, on a plate of so many mm."""
TOUCH_MM = 0.2
TOUCHED = ((0, 0), (8, 0), (8, 5))


def lying(
    angle: float, height: float, random: np.random.Generator
) -> tuple[Stand, np.ndarray, Chessboard]:
    """A board that lies at an angle on a plate, photographed from somewhere that shows all of it."""
    board = Chessboard(angle=angle, height=height)
    while True:
        away, tilt = random.uniform(*AWAY), random.uniform(20, 45)
        at = stand(board.middle(), away, tilt, random.uniform(-20, 20), random.uniform(-8, 8))
        seen = LENS.pixels(at.seen(board.corners()))
        if seen.min() > 30 and (seen < (LENS.width - 30, LENS.height - 30)).all():
            return at, photograph(LENS, at, board, random)[0], board


def touches(board: Chessboard, random: np.random.Generator, count: int = 3) -> list[dict]:
    """Corners as a tool touches them, each axis off by TOUCH_MM."""
    corners = board.corners()
    found = []
    for column, row in TOUCHED[:count]:
        x, y, z = corners[row, column] + random.normal(0, TOUCH_MM, 3)
        found.append({"column": column, "row": row, "x": x, "y": y, "z": z})
    return found


def as_touched_scene(
    angle: float, height: float, random: np.random.Generator, points: int, count: int = 3
) -> list:
    """One board as it lies, found by the corners that were touched."""
    at, grey, truth = lying(angle, height, random)
    plain = Board(truth.columns, truth.rows, truth.square)
    touched = touches(truth, random, count)
    fit = calibrate(View(np.dstack([grey] * 3), eye()), plain, touched, TOUCH_MM)
    return errors(at, fit, random, points, truth)


def main() -> None:
    """Print the errors of many scenes with the required limits."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rendered", type=int, default=20, help="scenes that are photographed")
    parser.add_argument("--projected", type=int, default=300, help="scenes of corners alone")
    parser.add_argument("--touched", type=int, default=12, help="boards found by touched corners")
    parser.add_argument("--points", type=int, default=20, help="points a scene")
    asked = parser.parse_args()
    for kind, count in (
        ("rendered", asked.rendered), ("projected", asked.projected), ("touched", asked.touched),
    ):  # fmt: skip
        random = np.random.default_rng(5)
        rows = [
            row
            for number in range(count)
            for row in (
                as_touched_scene(*LYING[number % len(LYING)], random, asked.points)
                if kind == "touched"
                else scene(random, asked.points, kind == "rendered")
            )
        ]
        if not rows:
            continue
        table = np.array(rows, float)
        print(
            f"{kind}: {count} scenes, {len(rows)} points; mm     median      95 %    wanted   ratio"
        )
        for column, (name, wanted) in enumerate(WANTED.items()):
            middle, most = np.percentile(table[:, column], [50, 95])
            print(f"  {name:<38}{middle:10.2f}{most:10.2f}{wanted:10.1f}{most / wanted:8.2f}")
        for column, name in (
            (3, "as near as told, by depth"),
            (4, "as near as told, height known"),
        ):
            print(f"  {name:<38}{table[:, column].mean():10.1%}{'':10}{'95 %':>10}")


if __name__ == "__main__":
    main()
