#!/usr/bin/env python3
"""Answers of phalanx and of Embree (embreex) on the same rays, and the truth in exact arithmetic.

    python perf/python_answers.py differences MESH...    # closest hits that differ, by class
    python perf/python_answers.py lost MESH...           # rays from within that leave closed meshes

Needs numpy, trimesh and embreex. Both tracers get the same float32 vertices and rays, neither scaled
nor moved. Where they name different triangles, the ray is intersected with all triangles in rational
numbers: float32 numbers are fractions, so that nothing is rounded. perf/notes/python.md has the
tables.
"""

import argparse
import pathlib
from fractions import Fraction

import numpy as np
import trimesh
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

import phalanx
import phalanx.trimesh

# Weights and cosines below this one count as zero: some roundings of float32.
NEAR = 4e-6
CLASSES = ("vertex", "edge", "coplanar", "precision")
RIGHT = ("both", "phalanx", "embree", "neither")


def load(path: str) -> trimesh.Trimesh:
    """A mesh, its vertices rounded to float32; 'sphere' is one of 20480 triangles."""
    if path == "sphere":
        mesh = trimesh.creation.icosphere(5)
    else:
        mesh = trimesh.load(path, force="mesh")
    mesh.vertices = mesh.vertices.astype(np.float32)
    return mesh


def tracers(mesh: trimesh.Trimesh, robust: bool = True) -> tuple[phalanx.Scene, EmbreeScene]:
    vertices, faces = mesh.vertices.astype(np.float32), mesh.faces.astype(np.int32)
    ours, theirs = phalanx.Scene(), EmbreeScene(robust=robust)
    ours.add_mesh(vertices, faces)
    TriangleMesh(theirs, vertices, faces)
    return ours, theirs


def rays_at(mesh: trimesh.Trimesh, n: int, rng) -> tuple[np.ndarray, np.ndarray]:
    """Rays from around the mesh, float32: a third at points anywhere, at vertices, and at edges."""
    vertices, edges = mesh.vertices.astype(np.float32), mesh.edges_unique
    middle, size = mesh.bounds.mean(axis=0), np.ptp(mesh.bounds, axis=0).max()
    origins = (middle + rng.uniform(-1, 1, size=(n, 3)) * size).astype(np.float32)
    anywhere = middle + rng.uniform(-0.5, 0.5, size=(n, 3)) * np.ptp(mesh.bounds, axis=0)
    picked = edges[rng.integers(len(edges), size=n)]
    share = rng.choice([0.0, 0.25, 0.5, 0.75], size=(n, 1)).astype(np.float32)
    on_edges = vertices[picked[:, 0]] * (1 - share) + vertices[picked[:, 1]] * share
    on_edges = np.where(share == 0.0, vertices[picked[:, 0]], on_edges)
    kind = (np.arange(n) % 3)[:, None]
    targets = np.select([kind == 0, kind == 1], [anywhere, vertices[picked[:, 0]]], on_edges)
    return origins, (targets - origins).astype(np.float32)


class Triangles:
    """Triangles in float64, and balls around them that tell which a ray may meet."""

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        self.corners = mesh.vertices.view(np.ndarray)[mesh.faces].astype(np.float64)
        self.centers = self.corners.mean(axis=1)
        away = np.linalg.norm(self.corners - self.centers[:, None], axis=2).max(axis=1)
        self.squares = (away + 1e-6 * np.ptp(mesh.bounds)) ** 2

    def candidates(self, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Triangles to whose balls the ray's line comes near, with a wide margin."""
        from_origin = self.centers - origin
        along = from_origin @ (direction / np.linalg.norm(direction))
        away = np.einsum("ij,ij->i", from_origin, from_origin) - along**2
        return np.flatnonzero(away <= self.squares * (1 + 1e-6))


def exact(corners, origin, direction):
    """(t, weights of the corners) of a hit, in fractions; None for a miss or a ray in the plane."""
    o, d = ([Fraction(float(x)) for x in v] for v in (origin, direction))
    a, b, c = ([Fraction(float(x)) - y for x, y in zip(corner, o)] for corner in corners)
    weights = [triple(b, c, d), triple(c, a, d), triple(a, b, d)]
    total = sum(weights)
    if total == 0 or min(weights) < 0 < max(weights):
        return None
    weights = [weight / total for weight in weights]
    axis = max(range(3), key=lambda k: abs(d[k]))
    t = sum(weight * corner[axis] for weight, corner in zip(weights, (a, b, c))) / d[axis]
    return (t, weights) if t > 0 else None


def triple(a, b, c):
    """The determinant of three vectors."""
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def judge(triangles, origin, direction, ours: int, theirs: int) -> tuple[str, str]:
    """The class of a difference, and which of the two triangles are exactly right."""
    hits, corners = {}, triangles.corners
    for face in triangles.candidates(origin.astype(np.float64), direction.astype(np.float64)):
        found = exact(corners[face], origin, direction)
        if found:
            hits[int(face)] = found
    nearest = min((t for t, _ in hits.values()), default=None)
    truth = {face for face, (t, _) in hits.items() if t == nearest} or {-1}
    right = RIGHT[{(1, 1): 0, (1, 0): 1, (0, 1): 2, (0, 0): 3}[ours in truth, theirs in truth]]
    named = [face for face in {ours, theirs} | truth if face >= 0]
    zeros, steepest = 0, 1.0
    for face in named:
        a, b, c = corners[face]
        normal = np.cross(b - a, c - a)
        area = np.linalg.norm(normal)
        long = np.linalg.norm(direction.astype(np.float64))
        steepest = min(steepest, abs(normal @ direction) / max(area * long, 1e-300))
        zeros = max(zeros, near_zero(corners[face], origin, direction))
    if steepest < NEAR:
        return "coplanar", right
    return ("precision", "edge", "vertex")[min(zeros, 2)], right


def near_zero(corners, origin, direction) -> int:
    """Number of corner weights that are zero but for roundings, where the ray meets the plane.

    A weight is compared with the ray's rounding in units of the triangle's height.
    """
    a, b, c = (corner - origin.astype(np.float64) for corner in corners)
    direction = direction.astype(np.float64)
    weights = np.array([np.cross(p, q) @ direction for p, q in ((b, c), (c, a), (a, b))])
    edges = [np.linalg.norm(p - q) for p, q in ((b, c), (c, a), (a, b))]
    reach = max(np.abs(a).max(), np.abs(b).max(), np.abs(c).max())
    bound = NEAR * reach * np.linalg.norm(direction) * np.array(edges)
    return int((np.abs(weights) <= bound).sum())


def differences(mesh: trimesh.Trimesh, n: int, most: int, seed: int) -> dict:
    """Counts of a mesh: rays, hits, differing rays, and those judged by class and by who is right."""
    ours, theirs = tracers(mesh)
    origins, directions = rays_at(mesh, n, np.random.default_rng(seed))
    mine = ours.intersect(origins, directions)
    other = theirs.run(origins, directions, output=1)
    differing = np.flatnonzero(mine.prim_id != other["primID"])
    triangles = Triangles(mesh)
    counts = {"rays": n, "hits": int(mine.hit.sum()), "differ": len(differing)}
    # Both hit, but not at one place.
    far = abs(mine.t - other["tfar"]) * np.linalg.norm(directions, axis=1) > 1e-4 * mesh.scale
    both = mine.hit & (other["primID"] >= 0)
    counts["apart"] = int((far & both)[differing].sum())
    judged = np.random.default_rng(seed).permutation(differing)[:most]
    counts["judged"] = len(judged)
    table = {}
    for k in judged:
        ray = (origins[k], directions[k])
        key = judge(triangles, *ray, int(mine.prim_id[k]), int(other["primID"][k]))
        missed = "phalanx" if mine.prim_id[k] < 0 else "embree" if other["primID"][k] < 0 else ""
        table[key] = table.get(key, 0) + 1
        if missed:
            table["missed", missed] = table.get(("missed", missed), 0) + 1
            if key[1] == missed:
                table["rightly", missed] = table.get(("rightly", missed), 0) + 1
    counts["table"] = table
    return counts


def lost(mesh: trimesh.Trimesh, n: int, seed: int) -> dict:
    """Rays from points within a closed mesh at its vertices and edges: how many hit nothing."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(*mesh.bounds, size=(20_000, 3)).astype(np.float32)
    within = phalanx.trimesh.RayMeshIntersector(mesh).contains_points(points)
    # Clear of the surface, so that these points are within for both.
    points = points[within][:400]
    points = points[mesh.nearest.on_surface(points)[1] > 1e-3 * mesh.scale]
    vertices, edges = mesh.vertices.astype(np.float32), mesh.edges_unique
    counts = {"phalanx": 0, "embree": 0, "embree, not robust": 0}
    scenes = [*tracers(mesh), tracers(mesh, robust=False)[1]]
    for start in range(0, n, 500_000):
        size = min(500_000, n - start)
        picked = edges[rng.integers(len(edges), size=size)]
        share = rng.choice([0.0, 0.25, 0.5, 1.0], size=(size, 1)).astype(np.float32)
        targets = vertices[picked[:, 0]] * (1 - share) + vertices[picked[:, 1]] * share
        origins = points[rng.integers(len(points), size=size)]
        counts["phalanx"] += int((~scenes[0].intersect(origins, targets - origins).hit).sum())
        for name, scene in (("embree", scenes[1]), ("embree, not robust", scenes[2])):
            counts[name] += int((scene.run(origins, targets - origins) < 0).sum())
    return counts


def print_differences(paths: list[str], n: int, most: int) -> None:
    print("| mesh | triangles | rays | hits | differ | apart | judged | " + " | ".join(CLASSES) + " |", end="")
    print(" both right | phalanx | embree | neither | phalanx misses (rightly) | embree misses |")
    print("|---" + "|---:" * 16 + "|")
    for path in paths:
        mesh = load(path)
        found = differences(mesh, n, most, seed=1)
        table = found["table"]
        kinds = [sum(table.get((kind, who), 0) for who in RIGHT) for kind in CLASSES]
        right = [sum(table.get((kind, who), 0) for kind in CLASSES) for who in RIGHT]
        misses = [
            f"{table.get(('missed', who), 0)} ({table.get(('rightly', who), 0)})"
            for who in ("phalanx", "embree")
        ]
        first = [found[key] for key in ("rays", "hits", "differ", "apart", "judged")]
        numbers = [f"{number:,}" for number in [len(mesh.faces), *first, *kinds, *right]]
        print(f"| {pathlib.Path(path).name} | {' | '.join([*numbers, *misses])} |", flush=True)


def print_lost(paths: list[str], n: int) -> None:
    print("| closed mesh | triangles | rays | phalanx | embree | embree, not robust |")
    print("|---" + "|---:" * 5 + "|")
    sums: dict[str, int] = {}
    meshes = [(path, mesh) for path in paths if (mesh := load(path)).is_watertight]
    for k, (path, mesh) in enumerate(meshes):
        counts = lost(mesh, n // len(meshes), seed=k)
        sums = {name: sums.get(name, 0) + count for name, count in counts.items()}
        cells = [pathlib.Path(path).name, f"{len(mesh.faces):,}", f"{n // len(meshes):,}"]
        print("| " + " | ".join([*cells, *(f"{c:,}" for c in counts.values())]) + " |", flush=True)
    total = " | ".join(f"{count:,}" for count in sums.values())
    print(f"| all | | {n // len(meshes) * len(meshes):,} | {total} |")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=["differences", "lost"])
    parser.add_argument("meshes", nargs="+", metavar="MESH")
    parser.add_argument("--rays", type=int, help="of each mesh; of all together for lost")
    parser.add_argument("--judge", type=int, default=400, help="most differing rays to judge")
    args = parser.parse_args()
    if args.what == "lost":
        print_lost(args.meshes, args.rays or 10_000_000)
    else:
        print_differences(args.meshes, args.rays or 300_000, args.judge)
