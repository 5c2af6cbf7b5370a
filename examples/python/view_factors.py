"""View factors of a room with a hanging box: the share of a surface's light that reaches another.

    python view_factors.py [--samples 20000]

Needs only numpy. Rows are senders, and add up to 1; areas times factors are symmetric.
"""

import argparse

import numpy as np

import phalanx

NAMES = ["floor", "ceiling", "west", "east", "south", "north", "box", "sum"]


def box(low, high, inside: bool) -> list[np.ndarray]:
    """The six sides of a box, two triangles each: (2, 3, 3), facing inwards or outwards."""
    sides = []
    for axis in (2, 0, 1):
        for end in (0, 1):
            bits = np.roll([[end] * 4, [0, 1, 1, 0], [0, 0, 1, 1]], axis, axis=0)
            side = np.where(bits.T, high, low)[[[0, 1, 2], [0, 2, 3]]].astype(float)
            sides.append(side if inside == (end == 0) else side[:, ::-1])
    return sides


def view_factors(surfaces, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Areas (n,) and view factors (n, n) of surfaces, each an array of triangles (m, 3, 3)."""
    scene = phalanx.Scene()
    for triangles in surfaces:
        scene.add_mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
    rng, areas, factors = np.random.default_rng(1), [], []
    for triangles in surfaces:
        sides = np.diff(triangles, axis=1)
        normals = np.cross(sides[:, 0], sides[:, 1])
        twice = np.linalg.norm(normals, axis=1)
        chosen = rng.choice(len(triangles), samples, p=twice / twice.sum())
        weights = rng.dirichlet([1, 1, 1], samples)
        points = np.einsum("ij,ijk->ik", weights, triangles[chosen])
        normal = (normals / twice[:, None])[chosen]
        ball = rng.normal(size=(samples, 3))
        ball /= np.linalg.norm(ball, axis=1, keepdims=True)
        met = scene.intersect(points + 1e-5 * normal, normal + ball).geom_id
        areas.append(twice.sum() / 2)
        factors.append(np.bincount(met, minlength=len(surfaces)) / samples)
    return np.array(areas), np.array(factors)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--samples", type=int, default=20_000)
    room = box((0, 0, 0), (5, 4, 2.5), inside=True)
    hanging = np.concatenate(box((2, 1.5, 0.4), (2.6, 2.1, 2.2), inside=False))
    areas, factors = view_factors([*room, hanging], parser.parse_args().samples)
    print(" " * 8 + "".join(f"{name:>9}" for name in NAMES))
    for name, row in zip(NAMES, factors):
        print(f"{name:8}" + "".join(f"{share:9.4f}" for share in [*row, row.sum()]))
    breach = abs(areas[:, None] * factors - areas * factors.T).max()
    print(f"largest breach of reciprocity: {breach:.3f} m²")
