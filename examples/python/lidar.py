"""A rotating LiDAR in a scene: its points, and a plot of them from above.

    python lidar.py [scene.glb] [--at X Y Z] [--up y] [--out lidar.png]

Needs numpy and matplotlib. The scene is a glTF, OBJ, PLY or STL file, or a standard scene, by
default standard:street:50k. The scanner has 64 lasers from 25° below the horizon to 15° above it,
and 1800 steps per revolution; ranges have an error of 2 cm and end at 100 m.
"""

import argparse
import pathlib

import numpy as np

import phalanx


def beams(up: int, lasers: int = 64, steps: int = 1800) -> np.ndarray:
    """Unit directions, float32, (lasers, steps, 3): laser after laser, so neighbours are coherent."""
    polar = np.radians(np.linspace(-25, 15, lasers))[:, None]
    around = np.radians(np.arange(steps) * 360 / steps)
    east, north = np.cos(polar) * np.cos(around), np.cos(polar) * np.sin(around)
    parts = [east, north, np.broadcast_to(np.sin(polar), east.shape)]
    return np.roll(np.stack(parts, axis=-1), up + 1, axis=-1).astype(np.float32)


def scan(scene: phalanx.Scene, at, up: int) -> np.ndarray:
    """Points that the scanner reports: float64, (n, 3)."""
    rays = beams(up)
    hits = scene.intersect(np.asarray(at, np.float32), rays, tmax=100.0)
    t = hits.t[hits.hit] + np.random.default_rng(1).normal(0, 0.02, hits.hit.sum())
    return np.asarray(at) + t[:, None] * rays[hits.hit]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scene", nargs="?", default="standard:street:50k")
    parser.add_argument("--at", type=float, nargs=3, help="the scanner's position")
    parser.add_argument("--up", choices="xyz", default="y")
    parser.add_argument("--out", default="lidar.png")
    args = parser.parse_args()
    scene, up, at = phalanx.Scene.load(args.scene), "xyz".index(args.up), args.at
    if at is None:
        # Above the lowest surface at the middle of the scene.
        at = scene.bounds.mean(axis=0)
        down = -np.eye(3)[up]
        ground = scene.all_hits(at - 1e4 * down, down).t.max(initial=1e4)
        at = at + (1.8 - ground + 1e4) * -down
    points = scan(scene, at, up)
    print(f"{len(points)} points from {np.round(at, 2)}")
    from matplotlib import pyplot

    across = [axis for axis in range(3) if axis != up]
    figure, axes = pyplot.subplots(figsize=(9, 8))
    plot = axes.scatter(*points[:, across].T, c=points[:, up], s=0.3, cmap="viridis")
    axes.plot(*np.asarray(at)[across], "r+", markersize=14)
    axes.set(aspect="equal", xlabel="xyz"[across[0]], ylabel="xyz"[across[1]])
    axes.set_title(f"{pathlib.Path(args.scene).name}: {len(points):,} points from above")
    figure.colorbar(plot, label=f"height, {args.up}")
    figure.savefig(args.out, dpi=120)
