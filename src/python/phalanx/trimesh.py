"""Ray casting for trimesh: `mesh.ray = phalanx.trimesh.RayMeshIntersector(mesh)`.

Methods, arguments and results are those of trimesh.ray.ray_pyembree, with three differences:

- Hits count only beyond the origin (0 < t): a ray that starts on a surface does not hit it there.
- All hits come from one traversal of the tree, ordered by (ray, distance), rather than from rays
  restarted behind each hit. Coincident surfaces are all hit.
- Locations are computed in float64 from the rays as they were given.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import AllHits, Hits, Scene
from ._crossings import crossings, on_edge
from ._locks import ProcessLock

__all__ = ["RayMeshIntersector"]

# Sizes within these powers of two are not scaled: products of three lengths stay far from the
# limits of float32.
_EXPONENTS = 20

# Lines for the test of points inside: not along planes, edges or symmetries of typical meshes.
# Later ones serve points that earlier ones leave undecided.
_LINES = np.array(
    [
        [0.4213, 0.6071, 0.6737],
        [-0.7331, 0.2917, 0.6143],
        [0.1543, -0.8699, 0.4684],
        [0.8117, -0.2239, -0.5393],
        [-0.3571, -0.4877, -0.7966],
    ]
)

# Number of points tested at once; bounds the memory.
_POINTS = 1 << 18

# Squared lengths of directions that float32 represents without scaling.
_LENGTHS = (1e-12, 1e12)


class RayMeshIntersector:
    """Ray queries on a trimesh.Trimesh; changes to the mesh are followed.

    Rays are arrays of (n, 3), origins and directions; directions may have any length but zero. Rays
    with a component that is not finite hit nothing. Queries raise ValueError for other shapes and
    TypeError for non-numeric arrays.
    """

    def __init__(self, mesh: Any, scale_to_box: bool = True, threads: int | None = None) -> None:
        """Wraps a trimesh.Trimesh; the first query builds the tree.

        scale_to_box : whether to scale meshes of extreme size by a power of two; other meshes keep
            every bit
        threads : threads of each query; None for one per CPU
        """
        self.mesh = mesh
        self._scale_to_box = scale_to_box
        self._threads = threads
        # The mesh's hash when the scene was made, the scene, and the power of two that scales it.
        self._made: tuple[int, Scene, float] | None = None
        # Held while the scene is made, so that threads share one.
        self._lock = ProcessLock()

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.mesh, self._scale_to_box, self._threads)

    def intersects_location(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True
    ) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
        """Points where rays hit the mesh: (locations, index_ray, index_tri).

        locations is float64, (m, 3); index_ray and index_tri are int64, (m,). Ordered by (ray,
        distance); without multiple_hits, only the first hit of each ray.
        """
        triangles, rays, locations = self.intersects_id(
            ray_origins, ray_directions, multiple_hits=multiple_hits, return_locations=True
        )
        return locations, rays, triangles

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = True,
        max_hits: int = 100,
        return_locations: bool = False,
    ) -> tuple[NDArray, ...]:
        """Triangles that rays hit: (index_tri, index_ray), and locations if requested.

        index_tri and index_ray are int64, (m,), rows of mesh.faces and of the rays; locations is
        float64, (m, 3). Ordered by (ray, distance), at most max_hits per ray; without
        multiple_hits, only the first one.

        A ray that crosses the surface at an edge or a vertex hits one of the triangles there: the
        one with the nearest hit.
        """
        scene, scale = self._scene()
        origins, directions = _rays(ray_origins, ray_directions, scale)
        hits: AllHits | Hits
        if multiple_hits:
            hits = scene.all_hits(origins, directions, threads=self._threads)
            rows = self._crossings(hits, directions, scale)
            rank = np.arange(len(rows)) - np.searchsorted(hits.ray_id[rows], hits.ray_id[rows])
            rows = rows[rank < max_hits]
            rays = hits.ray_id[rows]
        else:
            hits = scene.intersect(origins, directions, threads=self._threads)
            rows = rays = np.flatnonzero(hits.hit) if max_hits > 0 else np.zeros(0, np.int64)
        triangles = hits.prim_id[rows].astype(np.int64)
        if not return_locations:
            return triangles, rays
        return triangles, rays, hits.refine()[1][rows] / scale

    def intersects_first(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike
    ) -> NDArray[np.int64]:
        """The first triangle of each ray: int64, (n,), rows of mesh.faces; -1 for a miss."""
        scene, scale = self._scene()
        origins, directions = _rays(ray_origins, ray_directions, scale)
        hits = scene.intersect(origins, directions, threads=self._threads)
        return hits.prim_id.astype(np.int64)

    def intersects_any(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike
    ) -> NDArray[np.bool_]:
        """Whether each ray hits the mesh: bool, (n,)."""
        scene, scale = self._scene()
        origins, directions = _rays(ray_origins, ray_directions, scale)
        return scene.occluded(origins, directions, threads=self._threads)

    def contains_points(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points, (n, 3), lie inside the mesh: bool, (n,). On its surface, either.

        A point is inside if a line through it crosses the surface an odd number of times on both
        sides. If the two sides disagree, as at a hole, or the line touches an edge, other lines are
        tried; a point is outside if one side of a line hits nothing. Raises ValueError for other
        shapes.
        """
        points = np.asarray(points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ValueError(f"points have the shape {points.shape}, not (n, 3)")
        inside = np.zeros(len(points), dtype=bool)
        if len(self.mesh.faces) == 0:
            return inside
        low, high = self.mesh.bounds
        near = np.flatnonzero(((low <= points) & (points <= high)).all(axis=1))
        for start in range(0, len(near), _POINTS):
            part = near[start : start + _POINTS]
            inside[part] = self._within(points[part])
        return inside

    def _crossings(self, hits: AllHits, directions: NDArray, scale: float) -> NDArray[np.int64]:
        def normals(rows: NDArray[np.int64]) -> NDArray[np.float64]:
            faces = np.asarray(self.mesh.faces)[hits.prim_id[rows]]
            a, b, c = np.moveaxis(np.asarray(self.mesh.vertices)[faces], 1, 0)
            return np.cross(b - a, c - a)

        return crossings(hits, directions, normals, self._size() * scale)

    def _within(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        scene, scale = self._scene()
        inside = np.zeros(len(points), dtype=bool)
        left = np.arange(len(points))
        for line in _LINES:
            sides = []
            for direction in (line, -line):
                hits = scene.all_hits(points[left] * scale, direction, threads=self._threads)
                doubtful = np.zeros(len(left), dtype=bool)
                doubtful[hits.ray_id[on_edge(hits)]] = True
                sides.append((np.diff(hits.starts), doubtful))
            (ahead, doubt_ahead), (behind, doubt_behind) = sides
            agree = (ahead % 2 == behind % 2) & ~doubt_ahead & ~doubt_behind
            inside[left[agree]] = ahead[agree] % 2 == 1
            left = left[~agree & (ahead > 0) & (behind > 0)]
            if len(left) == 0:
                break
        return inside

    def _scene(self) -> tuple[Scene, float]:
        """The scene of the mesh as it is now, and the power of two by which it is scaled."""
        now = hash(self.mesh)
        with self._lock:
            if self._made is None or self._made[0] != now:
                self._made = (now, *self._make())
            return self._made[1:]

    def _make(self) -> tuple[Scene, float]:
        scale, center = 1.0, np.zeros(3)
        if len(self.mesh.faces) > 0:
            center = self.mesh.bounds.mean(axis=0)
            exponent = math.frexp(self._size())[1]
            if self._scale_to_box and abs(exponent) > _EXPONENTS:
                scale = math.ldexp(1.0, -exponent)
        scene = Scene(origin=tuple(center * scale))
        scene.add_mesh(np.asarray(self.mesh.vertices) * scale, np.asarray(self.mesh.faces))
        return scene, scale

    def _size(self) -> float:
        """Longest side of the mesh's box; trimesh's own scale is 1 for the smallest meshes."""
        return float(np.ptp(self.mesh.bounds, axis=0).max())


def _rays(origins: ArrayLike, directions: ArrayLike, scale: float) -> tuple[NDArray, NDArray]:
    """The rays in the coordinates of a scene scaled by a power of two."""
    starts, along = np.asarray(origins), np.asarray(directions)
    if starts.shape != along.shape:
        raise ValueError(f"rays differ in shape: {starts.shape} and {along.shape}")
    if starts.size == 0:
        starts, along = np.zeros((0, 3)), np.zeros((0, 3))
    if starts.ndim != 2 or starts.shape[1] != 3:
        raise ValueError(f"rays have the shape {starts.shape}, not (n, 3)")
    if starts.dtype.kind not in "fiu" or along.dtype.kind not in "fiu":
        raise TypeError(f"rays hold {starts.dtype} and {along.dtype}, not real numbers")
    if scale != 1.0:
        starts = starts * scale
    return starts, _of_usual_length(along)


def _of_usual_length(directions: NDArray) -> NDArray:
    """Directions, scaled if they are too long or too short for float32."""
    if directions.dtype.kind != "f":
        directions = directions.astype(np.float64)
    with np.errstate(all="ignore"):
        # Faster than sum(axis=1) and einsum(), for one ray and for many.
        squares = (directions * directions) @ np.ones(3, directions.dtype)
        if squares.min(initial=1.0) >= _LENGTHS[0] and squares.max(initial=1.0) <= _LENGTHS[1]:
            return directions
        unusual = ~((squares >= _LENGTHS[0]) & (squares <= _LENGTHS[1]))
        directions = directions.astype(np.float64)
        rows = directions[unusual]
        directions[unusual] = rows / np.abs(rows).max(axis=1, keepdims=True)
    return directions
