"""Ambient occlusion of each vertex: the share of a cosine-weighted sky that is visible.

    python ambient_occlusion.py [--rays 256] [--out picture.png]

Needs numpy, and matplotlib for the picture. Rays end after the mesh's own size.
"""

import argparse

import numpy as np

import phalanx


def hills(side: int) -> tuple[np.ndarray, np.ndarray]:
    """A surface of hills: vertices (side², 3) and faces (m, 3), counter-clockwise from above."""
    x, y = np.meshgrid(np.linspace(-3, 3, side), np.linspace(-3, 3, side))
    z = np.sin(2 * x) * np.cos(3 * y)
    a = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.stack([a, a + 1, a + side + 1, a, a + side + 1, a + side], axis=1)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3), faces.reshape(-1, 3)


def vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals of vertices, weighted by the area of their triangles."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    normals = np.zeros_like(vertices)
    np.add.at(normals, faces, np.cross(b - a, c - a)[:, None])
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def ambient_occlusion(vertices, faces, rays: int = 256) -> np.ndarray:
    """The free share of the sky at each vertex, from 0 to 1."""
    scene = phalanx.Scene()
    scene.add_mesh(vertices, faces)
    normals = vertex_normals(vertices, faces)
    # Points of a sphere on top of the normal are weighted by the cosine.
    height = 1 - (2 * np.arange(rays) + 1) / rays
    around = np.arange(rays) * np.pi * (3 - np.sqrt(5))
    wide = np.sqrt(1 - height**2)
    ball = np.stack([wide * np.cos(around), wide * np.sin(around), height], axis=1)
    size = np.ptp(vertices, axis=0).max()
    origins = np.repeat((vertices + 1e-4 * size * normals)[:, None], rays, axis=1)
    return 1 - scene.occluded(origins, normals[:, None] + ball, tmax=size).mean(axis=1)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rays", type=int, default=256)
    parser.add_argument("--out", help="a picture of the surface from above")
    args, (vertices, faces) = parser.parse_args(), hills(121)
    free = ambient_occlusion(vertices, faces, args.rays)
    print(f"{len(free)} vertices, free sky {free.min():.3f} to {free.max():.3f}")
    if args.out:
        from matplotlib import pyplot

        pyplot.tripcolor(*vertices[:, :2].T, faces, free, shading="gouraud", cmap="gray", vmin=0)
        pyplot.gca().set(aspect="equal", xlabel="x", ylabel="y", title="Free share of the sky")
        pyplot.colorbar()
        pyplot.savefig(args.out, dpi=120)
