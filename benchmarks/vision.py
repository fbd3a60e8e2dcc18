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
from labrun.drivers.cameras.vision.pixel_position import (
    point_at_depth,
    point_at_height,
    uncertainty_mm,
)
from labrun.drivers.cameras.vision.pose import Calibration, fit_pose
from labrun.drivers.cameras.vision.view import DepthView

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


def calibrated(corners: np.ndarray) -> tuple[Calibration, Intrinsics]:
    """The camera pose as labrun estimates it."""
    eye = Intrinsics(LENS.width, LENS.height, LENS.matrix(), np.array(LENS.distortion))
    board = Board(BOARD.columns, BOARD.rows, BOARD.square, BOARD.x, BOARD.y)
    return fit_pose(corners, board, eye), eye


def noisy_depth(at: Stand, u: float, v: float, random: np.random.Generator) -> np.ndarray:
    """A depth map of the bench with its noise, known only around one pixel."""
    depth = np.full((LENS.height, LENS.width), np.nan, np.float32)
    rows, columns = (slice(max(0, round(w) - 8), round(w) + 9) for w in (v, u))
    j, i = np.mgrid[rows, columns][:, : LENS.height, : LENS.width]
    inside = (j < LENS.height) & (i < LENS.width)
    rays = LENS.rays(np.stack([i, j], -1).astype(float)) @ at.turn
    exact = -at.place[2] / rays[..., 2]
    depth[j[inside], i[inside]] = (exact * random.normal(1, DEPTH_SHARE, exact.shape))[inside]
    return depth


def errors(
    at: Stand, corners: np.ndarray, random: np.random.Generator, points: int
) -> list[tuple[float, float, float, bool, bool]]:
    """For points on the bench: XY and Z off by depth, XY off by height, whether each is as near as told."""
    fit, eye = calibrated(corners)
    low, high = BOARD.corners()[0, 0, :2] - AROUND, BOARD.corners()[-1, -1, :2] + AROUND
    found = []
    while len(found) < points:
        truth = np.array([*random.uniform(low, high), 0.0])
        u, v = LENS.pixels(at.seen(truth))
        if not eye.holds(u - 10, v - 10) or not eye.holds(u + 10, v + 10):
            continue
        depth = noisy_depth(at, u, v, random)
        view = DepthView(np.zeros((LENS.height, LENS.width, 3), np.uint8), depth, eye)
        ahead, spread = depth_around(view.depth, u, v)
        by_depth = point_at_depth(fit.pose, eye, u, v, ahead) - truth
        by_height = point_at_height(fit.pose, eye, u, v, 0.0) - truth
        sd = view.depth_sd_mm(ahead, spread)
        told = [uncertainty_mm(fit, eye, u, v, height, ahead, sd) for height in (None, 0.0)]
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
    return errors(at, corners + random.normal(0, CORNER_PX, corners.shape), random, points)


def main() -> None:
    """Print the errors of many scenes with the required limits."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rendered", type=int, default=20, help="scenes that are photographed")
    parser.add_argument("--projected", type=int, default=300, help="scenes of corners alone")
    parser.add_argument("--points", type=int, default=20, help="points a scene")
    asked = parser.parse_args()
    for kind, count in (("rendered", asked.rendered), ("projected", asked.projected)):
        random = np.random.default_rng(5)
        rows = [
            row for _ in range(count) for row in scene(random, asked.points, kind == "rendered")
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
