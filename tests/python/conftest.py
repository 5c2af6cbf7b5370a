"""Things that several tests cast rays at."""

import os
import pathlib

import numpy as np
import pytest

import phalanx

ROOT = pathlib.Path(__file__).parents[2]

# Two triangles to each side of the cube from -1 to 1, corners counter-clockwise from outside.
CUBE_VERTICES = np.array(
    [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float32
)
CUBE_FACES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip


@pytest.fixture
def cube():
    scene = phalanx.Scene()
    scene.add_mesh(CUBE_VERTICES, CUBE_FACES)
    return scene


@pytest.fixture
def program():
    """The program phalanx, where it is built."""
    name = "phalanx.exe" if os.name == "nt" else "phalanx"
    path = pathlib.Path(os.environ.get("PHALANX", ROOT / "target" / "release" / name))
    if not path.is_file():
        pytest.skip(f"{path} is not built; PHALANX names another")
    return path


def rays_between(rng, n, size=3.0):
    """Rays from points to points at random in a cube: origins and directions, float32, (n, 3)."""
    ends = rng.uniform(-size, size, size=(2, n, 3)).astype(np.float32)
    return ends[0], ends[1] - ends[0]


def by_definition(vertices, faces, origin, direction):
    """Hits of one ray by the definition, in double precision: a list of (t, face)."""
    corners = np.asarray(vertices, dtype=np.float64)[faces]
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    direction, origin = np.asarray(direction, np.float64), np.asarray(origin, np.float64)
    p = np.cross(direction, ac)
    det = np.einsum("ij,ij->i", ab, p)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.einsum("ij,ij->i", origin - a, p) / det
        q = np.cross(origin - a, ab)
        v = q @ direction / det
        t = np.einsum("ij,ij->i", ac, q) / det
        met = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
    return sorted((t[k], int(k)) for k in np.flatnonzero(met))
