"""A rotating LiDAR on a car in traffic: cars move while the sensor turns.

    python moving_lidar.py [--sweeps 10] [--picture lidar.png]

Needs only numpy. 64 lasers, from 25° below the horizon to 15° above it, fire 2048 times in a turn
of 0.1 s. The scene is updated 32 times a turn. The sensor's own car is masked out.
"""

import argparse
import time
import zlib
from itertools import product

import numpy as np

import phalanx

SENSOR, BLIND, REACH = (-0.3, 0, 1.85, 1), 0.5, 120.0  # place in its car, and range: metres
OWN, OTHERS = 2, 1  # bits of masks; geometries other than the own car keep all bits
# Cross-sections of cars: x, half width and height of the waist, half width and height of the top.
SALOON = [(-2.2, 0.8, 0.6, 0.7, 0.8), (-1.6, 0.88, 0.9, 0.72, 1), (-0.8, 0.88, 0.92, 0.58, 1.42)]
SALOON += [(0.3, 0.88, 0.9, 0.6, 1.45), (1.1, 0.88, 0.85, 0.74, 1), (2.2, 0.78, 0.5, 0.7, 0.68)]
VAN = [(-2.5, 0.95, 1.1, 0.88, 2.2), (1.2, 0.98, 1.2, 0.86, 2.3), (2, 0.96, 1.1, 0.8, 1.25)]
MODELS = [SALOON, SALOON, [*VAN, (2.6, 0.9, 0.7, 0.8, 0.9)]]
# Heading in degrees, speed in m/s, metres left of the street's middle, metres past the crossing.
LANES = [(0, 9, -1.8, (-14, -1, 31, -30, 47, -52)), (180, 12, -1.8, (4, -13, -24, -41, 27, 45))]
LANES += [(90, 0, -1.8, (-11, -17, -24)), (270, 0, -1.8, (-11, -17))]
LANES += [(0, 0, -5.6, (-45, -38, -25, 21, 27, 35)), (180, 0, -5.6, (41, 28, -18, -24, -39))]
CARS = [(*lane, place) for *lane, places in LANES for place in places]  # the first is the sensor's
# Red, green and blue of each label at the ground, and what 14 m of height add to it.
COLORS = np.array([(20, 90, 235, 0, 0, 0), (60, 60, 255, 195, 10, -65), (0, 120, 60, 180, 380, 60)])
COLORS = np.append(COLORS, [(190, 160, 100, 0, 0, 0), (300, 70, 0, 0, 800, 250)], axis=0) / 255
LABELS = ["ground", "houses", "trees", "trunks", "cars"]
LABEL = np.array([0, 1, 2, 3] + [4] * len(CARS))  # of each geom_id


def mesh(bodies) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of closed bodies, each a list of rings of equally many points."""
    vertices, faces = np.empty((0, 3)), []
    for rings in bodies:
        n, k = np.shape(rings)[:2]
        a, j = np.arange((n - 1) * k), np.arange(k - 2)
        b = a - a % k + (a + 1) % k
        cap = np.stack([0 * j, j + 1, j + 2], axis=1)
        parts = [*zip(a, b + k, b), *zip(a, a + k, b + k), *cap, *(cap + (n - 1) * k)]
        faces.append(np.array(parts) + len(vertices))
        vertices = np.concatenate([vertices, np.reshape(rings, (-1, 3))])
    return vertices, np.concatenate(faces)


def box(x, y, z) -> list:
    """Rings of a box, from its two x, y and z."""
    return [[(a, y[i], z[j]) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))] for a in x]


def car(sections) -> list:
    """A body and four wheels, the nose towards x."""
    half = [[(x, w, 0.3), (x, w, h), (x, v, top)] for x, w, h, v, top in sections]
    body = [ring + [(x, -y, z) for x, y, z in ring[::-1]] for ring in half]
    places = product((sections[0][0] + 0.8, sections[-1][0] - 0.8), (-0.9, 0.7))
    return [body] + [box((x - 0.3, x + 0.3), (y, y + 0.2), (0, 0.6)) for x, y in places]


def pose(number: int, seconds: float) -> np.ndarray:
    """Matrix of a car. Streets end 90 m from the crossing, and start again at their other end."""
    heading, speed, left, ahead = CARS[number]
    c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
    ahead = (ahead + speed * seconds + 90) % 180 - 90
    x, y = c * ahead - s * left, s * ahead + c * left
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])


def street(seconds: float = 0.0) -> tuple[phalanx.Scene, list[int]]:
    """The scene at a time, and the geom_id of each car."""
    scene, rng, signs = phalanx.Scene(), np.random.default_rng(4), (-1, 1)
    blocks = [box((7 * a, 99 * a), (7 * b, 99 * b), (0, 0.15)) for a in signs for b in signs]
    scene.add_mesh(*mesh([box((-99, 99), (-99, 99), (-1, 0)), *blocks]))
    lots, rand = product(signs, signs, range(12, 90, 15)), rng.uniform
    houses = [((a * x, a * (x + rand(11, 15))), (b * rand(11.5, 13), b * 36)) for a, b, x in lots]
    scene.add_mesh(*mesh(box(*house, (0, rand(7, 22))) for house in houses))
    trees = [(x, y) for x in range(-90, 91, 9) for y in (-8.3, 8.3) if abs(x) > 9]
    crowns = np.repeat([(x, y, 4.4) for x, y in trees], 20, axis=0)
    scene.add_spheres(crowns + rand(-1.1, 1.1, crowns.shape), rand(0.3, 0.8, len(crowns)))
    scene.add_mesh(*mesh(box((x, x + 0.2), (y, y + 0.2), (0, 4)) for x, y in trees))
    models = [scene.add_prototype(*mesh(car(sections))) for sections in MODELS]
    cars = [scene.add_instance(models[i % 3], pose(i, seconds)) for i in range(len(CARS))]
    scene.set_mask(cars[0], OWN)
    return scene, cars


def move(scene: phalanx.Scene, cars: list[int], seconds: float) -> None:
    """Moves the cars to their places at a time."""
    for number, geom_id in enumerate(cars):
        if CARS[number][1] > 0:
            scene.set_transform(geom_id, pose(number, seconds))
    scene.update()


def fire(scene: phalanx.Scene, seconds: float, azimuths: np.ndarray) -> tuple:
    """Points of all lasers at some azimuths of the sensor, in the world, and their geom_id."""
    up, turn = np.meshgrid(np.radians(np.linspace(-25, 15, 64)), azimuths, indexing="ij")
    rays = np.stack([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)], axis=-1)
    matrix = pose(0, seconds)[:3]
    origin, rays = matrix @ SENSOR, rays @ matrix[:, :3].T
    # Filtered rays are traced one by one. With the own car hidden by set_mask(cars[0], 0), and
    # without tnear and mask, rays would be traced several times as fast.
    hits = scene.intersect(origin, rays, tmax=REACH, tnear=BLIND, mask=OTHERS)
    return origin + hits.t[hits.hit, None] * rays[hits.hit], hits.geom_id[hits.hit]


def sweep(scene: phalanx.Scene, cars: list[int], start: float, sectors: int = 32) -> list:
    """Points of a turn, clockwise from behind; their geom_id; their times."""
    parts = []
    for i, azimuths in enumerate(np.split(np.pi * (1 - np.arange(2048) / 1024), sectors)):
        seconds = start + 0.1 * i / sectors
        move(scene, cars, seconds)
        # fire() keeps arrays only: a scene whose Hits are still alive is copied when it changes.
        points, ids = fire(scene, seconds, azimuths)
        parts.append((points, ids, np.full(len(ids), seconds)))
    return [np.concatenate(column) for column in zip(*parts)]


def picture(scene, cars, seconds, points, ids, width: int = 1200, height: int = 675) -> np.ndarray:
    """Glowing points and the own car, from above the street: uint8, (height, width, 3)."""
    eye = pose(0, seconds)[:3] @ [-21, 0, 15, 1]
    axes = np.array([[0.05, -1, 0], [0.39, 0.02, 0.92], [0.92, 0.046, -0.391]])
    axes, zoom = axes / np.linalg.norm(axes, axis=1, keepdims=True), 0.8 * width
    x, y, depth = axes @ (points - eye).T
    at = np.stack([height / 2 - zoom * y / depth, width / 2 + zoom * x / depth], axis=1)
    # Dots of Gaussian profile, 7 × 7 pixels.
    seen = (depth > 1) & (abs(at / [height, width] - 0.5) < 0.5).all(axis=1)
    at, color = at[seen, None], COLORS[LABEL[ids[seen]]]
    color = color[:, :3] + color[:, 3:] * np.clip(points[seen, 2:] / 14, 0, 1)
    pixel = np.floor(at).astype(int) + np.stack(np.mgrid[-3:4, -3:4], axis=-1).reshape(-1, 2)
    size = np.clip(0.028 * zoom / depth[seen, None], 0.6, 1.5)
    weight = np.exp(-((pixel + 0.5 - at) ** 2).sum(axis=2) / 2 / size**2)
    light = np.zeros((height + 6, width + 6, 3))
    np.add.at(light, tuple((pixel + 3).transpose(2, 0, 1)), weight[..., None] * color[:, None])
    light = light[3:-3, 3:-3]
    row, column = np.mgrid[:height, :width] + 0.5
    rays = np.stack([column - width / 2, height / 2 - row, 0 * row + zoom], axis=-1) @ axes
    hits = scene.intersect(eye, rays)
    own, lit = hits.geom_id == cars[0], 0.15 + abs(hits.normal @ [-0.25, -0.3, 0.6])
    light[own] = lit[own, None] * (0.75, 0.85, 1)
    return ((1 - np.exp(-1.15 * light)) * 247 + (2, 4, 8)).astype(np.uint8) & 0xF8


def png(pixels: np.ndarray) -> bytes:
    """A PNG file of 8-bit colors."""
    height, width = pixels.shape[:2]
    head = np.array([width, height], ">u4").tobytes() + bytes([8, 2, 0, 0, 0])
    rows = zlib.compress(np.pad(pixels.reshape(height, -1), ((0, 0), (1, 0))).tobytes(), 9)
    file = b"\x89PNG\r\n\x1a\n"
    for data in (b"IHDR" + head, b"IDAT" + rows, b"IEND"):
        file += (len(data) - 4).to_bytes(4, "big") + data + zlib.crc32(data).to_bytes(4, "big")
    return file


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--sweeps", type=int, default=10)
    parser.add_argument("--picture", help="PNG file for the points of the last sweep")
    args, (scene, cars) = parser.parse_args(), street()
    clock = [time.perf_counter()]
    for number in range(args.sweeps):
        points, ids, times = sweep(scene, cars, 0.1 * number)
        clock.append(time.perf_counter())
    for _ in range(99):
        move(scene, cars, times[-1])
        clock.append(time.perf_counter())
    spent, update = (np.median(part) for part in np.split(np.diff(clock), [args.sweeps]))
    print(f"{len(points):,} points per sweep, {len(points) / spent / 1e6:.2f} million per second")
    print(f"{spent * 1e3:.1f} ms per sweep of 100 ms, with 32 updates of {update * 1e6:.0f} µs")
    print(*(f"{n:,} of {label}" for label, n in zip(LABELS, np.bincount(LABEL[ids]))), sep=", ")
    if args.picture:
        with open(args.picture, "wb") as file:
            file.write(png(picture(scene, cars, times[-1], points, ids)))
