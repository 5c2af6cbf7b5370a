#!/usr/bin/env python3
"""Answers of phalanx and of Embree (embreex) on the same rays, and the truth in exact arithmetic.

    python perf/python_answers.py differences MESH...    # closest hits that differ, by class
    python perf/python_answers.py lost MESH...           # rays that leave closed meshes from within
    python perf/python_answers.py through MESH...        # rays that enter them from outside, unseen

Needs numpy, trimesh and embreex. Both tracers get the same float32 vertices and rays, neither
scaled nor moved. Where they name different triangles, the ray is intersected with all triangles in
rational numbers: float32 numbers are fractions, so that nothing is rounded. The tables are in
perf/notes/python.md.
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
    is_sphere = path == "sphere"
    mesh = trimesh.creation.icosphere(5) if is_sphere else trimesh.load(path, force="mesh")
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
        """Triangles that the ray's line meets, with a wide margin."""
        from_origin = self.centers - origin
        along = from_origin @ (direction / np.linalg.norm(direction))
        away = np.einsum("ij,ij->i", from_origin, from_origin) - along**2
        near = np.flatnonzero(away <= self.squares * (1 + 1e-6))
        from_origin = self.corners[near] - origin
        a, b, c = np.moveaxis(from_origin, 1, 0)
        weights = [np.cross(p, q) @ direction for p, q in ((b, c), (c, a), (a, b))]
        # Roundings of float64 are a millionth of this.
        reach = np.abs(from_origin).max(initial=0.0)
        margin = 1e-9 * reach**2 * np.linalg.norm(direction)
        low, high = np.minimum.reduce(weights), np.maximum.reduce(weights)
        return near[(low >= -margin) | (high <= margin)]


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


def judge(triangles: Triangles, origin, direction, ours: int, theirs: int) -> str:
    """Which of the two triangles, or misses, are exactly right."""
    hits = {}
    for face in triangles.candidates(origin.astype(np.float64), direction.astype(np.float64)):
        found = exact(triangles.corners[face], origin, direction)
        if found:
            hits[int(face)] = found
    nearest = min((t for t, _ in hits.values()), default=None)
    truth = {face for face, (t, _) in hits.items() if t == nearest} or {-1}
    right = (ours in truth, theirs in truth)
    return {(True, True): "both", (True, False): "phalanx", (False, True): "embree"}.get(
        right, "neither"
    )


def classes(triangles: Triangles, origins, directions, faces) -> np.ndarray:
    """The class of each difference, a row of CLASSES, by both triangles, (n, 2); -1 for a miss.

    A ray meets a triangle at an edge, or a vertex, where one or two weights of the corners are zero
    but for roundings of float32, and is coplanar where it lies in the plane but for these.
    """
    zeros = np.zeros(len(faces), dtype=int)
    steepest = np.ones(len(faces))
    directions = directions.astype(np.float64)
    length = np.linalg.norm(directions, axis=1)
    for column in faces.T:
        corners = triangles.corners[column] - origins[:, None].astype(np.float64)
        a, b, c = np.moveaxis(corners, 1, 0)
        bound = NEAR * np.abs(corners).max(axis=(1, 2)) * length
        near = 0
        for p, q in ((b, c), (c, a), (a, b)):
            weight = np.einsum("ij,ij->i", np.cross(p, q), directions)
            near = near + (abs(weight) <= bound * np.linalg.norm(p - q, axis=1))
        zeros = np.where(column >= 0, np.maximum(zeros, near), zeros)
        normal = np.cross(b - a, c - a)
        slope = abs(np.einsum("ij,ij->i", normal, directions))
        slope /= np.maximum(np.linalg.norm(normal, axis=1) * length, 1e-300)
        steepest = np.where(column >= 0, np.minimum(steepest, slope), steepest)
    kinds = np.array([CLASSES.index(name) for name in ("precision", "edge", "vertex", "vertex")])
    return np.where(steepest < NEAR, CLASSES.index("coplanar"), kinds[zeros])


def differences(mesh: trimesh.Trimesh, n: int, most: int, seed: int) -> dict:
    """Counts of a mesh: rays, hits, differing rays by class, and for some of them who is right."""
    ours, theirs = tracers(mesh)
    origins, directions = rays_at(mesh, n, np.random.default_rng(seed))
    mine = ours.intersect(origins, directions)
    other = theirs.run(origins, directions, output=1)
    differing = np.flatnonzero(mine.prim_id != other["primID"])
    triangles = Triangles(mesh)
    counts = {"rays": n, "hits": int(mine.hit.sum()), "differ": len(differing)}
    both = np.stack([mine.prim_id, other["primID"]], axis=1)[differing]
    # Both hit, but not at one place.
    gap = abs(mine.t - other["tfar"])[differing] * np.linalg.norm(directions[differing], axis=1)
    counts["apart"] = int(((gap > 1e-4 * mesh.scale) & (both >= 0).all(axis=1)).sum())
    kinds = classes(triangles, origins[differing], directions[differing], both)
    counts |= {name: int((kinds == k).sum()) for k, name in enumerate(CLASSES)}
    judged = np.random.default_rng(seed).permutation(len(differing))[:most]
    counts["judged"] = len(judged)
    counts |= dict.fromkeys(RIGHT, 0)
    for k in judged:
        ray = (origins[differing[k]], directions[differing[k]])
        counts[judge(triangles, *ray, *map(int, both[k]))] += 1
    for name, column in zip(("phalanx misses", "embree misses"), both.T):
        misses = differing[column < 0]
        counts[name] = len(misses)
        rightly = [judge(triangles, origins[k], directions[k], -1, -2) == "phalanx" for k in misses]
        counts[f"{name} rightly"] = sum(rightly)
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


def through(triangles: Triangles, mine, other, origins, directions, most: int) -> list[int]:
    """Rays of which one tracer's hit, or miss, lies behind the other's: number, and what is nearer.

    By exact arithmetic: nothing; triangles from both sides, so that the ray touches an edge and
    goes on; or triangles from one side only, so that it went through the surface.
    """
    behind = np.flatnonzero(mine > other * (1 + 1e-4))
    found = [len(behind), 0, 0, 0]
    for k in behind[:most]:
        ray = [ends[k].astype(np.float64) for ends in (origins, directions)]
        sides = set()
        for face in triangles.candidates(*ray):
            a, b, c = triangles.corners[face]
            hit = exact((a, b, c), *ray)
            if hit and float(hit[0]) < mine[k] * (1 - 5e-5):
                sides.add(bool(np.cross(b - a, c - a) @ ray[1] > 0.0))
        found[1 + (0, 2, 1)[len(sides)]] += 1
    return found


def print_through(paths: list[str], n: int, most: int) -> None:
    print("| closed mesh | tracer | farther | nothing nearer | touches | goes through |")
    print("|---|---" + "|---:" * 4 + "|")
    for path in paths:
        mesh = load(path)
        ours, theirs = tracers(mesh)
        origins, directions = rays_at(mesh, n, np.random.default_rng(1))
        hits, other = ours.intersect(origins, directions), theirs.run(origins, directions, output=1)
        first = hits.t.astype(np.float64)
        second = np.where(other["primID"] >= 0, other["tfar"].astype(np.float64), np.inf)
        for name, pair in (("phalanx", (first, second)), ("embree", (second, first))):
            found = through(Triangles(mesh), *pair, origins, directions, most)
            cells = [pathlib.Path(path).stem, name, *(f"{count:,}" for count in found)]
            print("| " + " | ".join(cells) + " |", flush=True)


def print_differences(paths: list[str], n: int, most: int) -> None:
    for k, path in enumerate(paths):
        mesh = load(path)
        counts = {"triangles": len(mesh.faces), **differences(mesh, n, most, seed=1)}
        if k == 0:
            print("| mesh | " + " | ".join(counts) + " |")
            print("|---" + "|---:" * len(counts) + "|")
        cells = [pathlib.Path(path).stem, *(f"{count:,}" for count in counts.values())]
        print("| " + " | ".join(cells) + " |", flush=True)


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
    parser.add_argument("what", choices=["differences", "lost", "through"])
    parser.add_argument("meshes", nargs="+", metavar="MESH")
    parser.add_argument("--rays", type=int, help="of each mesh; of all together for lost")
    parser.add_argument("--judge", type=int, default=400, help="most differing rays to judge")
    args = parser.parse_args()
    if args.what == "lost":
        print_lost(args.meshes, args.rays or 10_000_000)
    elif args.what == "through":
        print_through(args.meshes, args.rays or 300_000, args.judge)
    else:
        print_differences(args.meshes, args.rays or 300_000, args.judge)
