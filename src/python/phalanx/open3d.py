"""Ray casting for Open3D: RaycastingScene with the ray queries of open3d.t.geometry.

Open3D tensors in, tensors out; numpy arrays in, numpy arrays out, in which case Open3D need not be
installed. The point queries, compute_…, raise NotImplementedError, and the argument device is
missing. There are three differences:

- Hits count only beyond the origin (0 < t).
- Arrays of any real numbers are accepted and rounded to float32; vertices and triangles are copied.
- If triangles coincide, all of them are counted and listed.
"""

from __future__ import annotations

import math
from typing import Any, Callable, NoReturn

import numpy as np
from numpy.typing import NDArray

from . import AllHits, Scene
from ._crossings import crossings
from ._locks import ProcessLock

__all__ = ["RaycastingScene"]

# Number of rays whose hits are listed at once when counting; bounds the memory.
_RAYS = 1 << 18

# Number of primitives looked up at once: their rows stay in the cache and reuse its memory.
_PIECE = 1 << 14

# Unit normal and number of a mesh's triangle, side by side so that one lookup finds both. numpy
# looks up items of 16 bytes ten times as fast as rows of three floats.
_TRIANGLE = np.dtype([("x", "f4"), ("y", "f4"), ("z", "f4"), ("number", "u4")])


def _point_query(name: str) -> Callable[..., NoReturn]:
    """A method of Open3D's class that this one refuses."""

    def refuse(self: RaycastingScene, *args: Any, **kwargs: Any) -> NoReturn:
        raise NotImplementedError(f"{name}() asks about points: phalanx casts rays only")

    return refuse


class RaycastingScene:
    """Triangle meshes to cast rays at; point queries are refused.

    Rays are (…, 6) with at least two dimensions: origin and direction, of any length but zero.
    nthreads is 0 for one thread per CPU. Queries raise ValueError for other shapes, and TypeError
    for non-numeric arrays.
    """

    INVALID_ID = 0xFFFFFFFF

    def __init__(self, nthreads: int = 0) -> None:
        """Creates an empty scene; the first query builds its tree with nthreads threads."""
        self._scene = Scene()
        self._nthreads = nthreads
        self._meshes: list[tuple[NDArray, NDArray]] = []
        self._table: _Table | None = None
        # Held while the table and its meshes may differ.
        self._lock = ProcessLock()

    def __reduce__(self) -> tuple[Any, ...]:
        with self._lock:
            return _with_meshes, (type(self), self._nthreads, tuple(self._meshes))

    def add_triangles(
        self, vertex_positions: Any = None, triangle_indices: Any = None, *, mesh: Any = None
    ) -> int:
        """Adds an open3d.t.geometry.TriangleMesh, or vertices (n, 3) and triangles (m, 3).

        Returns the mesh's geometry ID. Raises ValueError for vertices that are not finite, and
        IndexError for triangles that refer to no vertex.
        """
        vertices, triangles = vertex_positions, triangle_indices
        if triangles is None:
            mesh = vertices if mesh is None else mesh
            if not hasattr(mesh, "triangle"):
                raise TypeError("give a TriangleMesh of open3d.t, or vertices and triangles")
            vertices, triangles = mesh.vertex["positions"], mesh.triangle["indices"]
        vertices = np.array(_as_numpy(vertices), dtype=np.float32)
        triangles = np.array(_as_numpy(triangles))
        with self._lock:
            number = self._scene.add_mesh(vertices, triangles)
            self._meshes.append((vertices, triangles.reshape(-1, 3)))
            self._table = None
        return number

    def cast_rays(self, rays: Any, nthreads: int = 0) -> dict[str, Any]:
        """The first hit of each ray, in arrays of the rays' shape without its last dimension.

        t_hit : float32, distance in units of the direction; inf for a miss
        geometry_ids, primitive_ids : uint32; INVALID_ID for a miss
        primitive_uvs : float32, (…, 2), weights of the triangle's second and third vertex
        primitive_normals : float32, (…, 3), unit normal of the triangle; 0 for a miss
        """
        numbers, wrap = _rays(rays)
        self._built()
        hits = self._scene.intersect(numbers, threads=_threads(nthreads))
        # Covers at least the meshes that were hit, even if another thread has added some.
        table = self._built()
        triangles, normals = table.look_up(hits.prim_id)
        found = {
            "t_hit": hits.t,
            "geometry_ids": hits.geom_id.view(np.uint32),
            "primitive_ids": triangles,
            "primitive_uvs": np.stack([hits.u, hits.v], axis=-1),
            "primitive_normals": normals,
        }
        return {name: wrap(column) for name, column in found.items()}

    def test_occlusions(
        self, rays: Any, tnear: float = 0.0, tfar: float = math.inf, nthreads: int = 0
    ) -> Any:
        """Whether each ray hits anything with tnear < t < tfar: bool, of the rays' shape."""
        numbers, wrap = _rays(rays)
        self._built()
        threads = _threads(nthreads)
        if tnear <= 0.0:
            return wrap(self._scene.occluded(numbers, tmax=tfar, threads=threads))
        first = self._scene.intersect(numbers, tmax=tfar, threads=threads)
        blocked = np.array(first.hit & (first.t > tnear))
        # A hit before tnear may hide others.
        rest = np.nonzero(first.hit & ~blocked)
        hits = self._scene.all_hits(numbers[rest], tmax=tfar, threads=threads)
        beyond = hits.ray_id[hits.t > tnear]
        blocked[rest] = np.bincount(beyond, minlength=len(hits.starts) - 1) > 0
        return wrap(blocked)

    def count_intersections(self, rays: Any, nthreads: int = 0) -> Any:
        """Number of times that each ray crosses a surface: int32, of the rays' shape.

        A crossing at an edge or a vertex counts once.
        """
        numbers, wrap = _rays(rays)
        flat = numbers.reshape(-1, 6)
        counts = np.zeros(len(flat), dtype=np.int32)
        for start in range(0, len(flat), _RAYS):
            part = flat[start : start + _RAYS]
            hits, rows = self._crossings(part, nthreads)
            counts[start : start + len(part)] = np.bincount(hits.ray_id[rows], minlength=len(part))
        return wrap(counts.reshape(numbers.shape[:-1]))

    def list_intersections(self, rays: Any, nthreads: int = 0) -> dict[str, Any]:
        """All crossings of each ray, ordered by (ray, distance).

        ray_splits : uint32, (rays + 1,): ray i has rows ray_splits[i] to ray_splits[i + 1]
        ray_ids : uint32, the ray of each row
        t_hit, geometry_ids, primitive_ids, primitive_uvs : as in cast_rays()
        """
        numbers, wrap = _rays(rays)
        flat = numbers.reshape(-1, 6)
        hits, rows = self._crossings(flat, nthreads)
        table = self._built()
        ray = hits.ray_id[rows]
        found = {
            "ray_splits": np.searchsorted(ray, np.arange(len(flat) + 1)).astype(np.uint32),
            "ray_ids": ray.astype(np.uint32),
            "t_hit": hits.t[rows],
            "geometry_ids": hits.geom_id[rows].view(np.uint32),
            "primitive_ids": table.triangles["number"][hits.prim_id[rows]],
            "primitive_uvs": np.stack([hits.u[rows], hits.v[rows]], axis=-1),
        }
        return {name: wrap(column) for name, column in found.items()}

    @staticmethod
    def create_rays_pinhole(*args: Any, **kwargs: Any) -> Any:
        """Rays of a pinhole camera: float32, (height_px, width_px, 6), through pixel centres.

        create_rays_pinhole(intrinsic_matrix, extrinsic_matrix, width_px, height_px)
            An upper triangular (3, 3) matrix, and a (4, 4) one from the world to the camera.
        create_rays_pinhole(fov_deg, center, eye, up, width_px, height_px)
            Horizontal field of view in degrees, and three points or vectors of (3,).

        Returns a tensor if a matrix or a point is one, else a numpy array.
        """
        given = [*args, *kwargs.values()]
        wrap = _wrapper(*given)
        if len(given) == 4:
            return wrap(_rays_of_matrices(*args, **kwargs))
        return wrap(_rays_of_view(*args, **kwargs))

    compute_closest_points = _point_query("compute_closest_points")
    compute_distance = _point_query("compute_distance")
    compute_occupancy = _point_query("compute_occupancy")
    compute_signed_distance = _point_query("compute_signed_distance")

    def _built(self) -> _Table:
        """The table of the current meshes; builds the tree."""
        with self._lock:
            if self._table is None:
                self._scene.build(threads=_threads(self._nthreads))
                self._table = _Table(self._meshes)
            return self._table

    def _crossings(self, flat: NDArray, nthreads: int) -> tuple[AllHits, NDArray[np.int64]]:
        self._built()
        hits = self._scene.all_hits(flat, threads=_threads(nthreads))
        table = self._built()

        def normals(rows: NDArray[np.int64]) -> NDArray:
            return table.look_up(hits.prim_id[rows])[1]

        return hits, crossings(hits, flat[:, 3:], normals, table.size)


class _Table:
    """Data of each primitive; the last row is for a miss, whose number is -1."""

    def __init__(self, meshes: list[tuple[NDArray, NDArray]]) -> None:
        corners = [vertices[triangles.astype(np.int64)] for vertices, triangles in meshes]
        numbers = [np.arange(len(mesh)) for mesh in corners]
        a, b, c = np.moveaxis(
            np.concatenate([*corners, np.zeros((1, 3, 3))]).astype(np.float64), 1, 0
        )
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        normal /= np.where(length > 0.0, length, 1.0)
        self.triangles = np.empty(len(a), _TRIANGLE)
        for name, column in zip("xyz", normal.T):
            self.triangles[name] = column
        self.triangles["number"] = np.concatenate([*numbers, [RaycastingScene.INVALID_ID]])
        low, high = (a[:-1].min(axis=0), a[:-1].max(axis=0)) if len(a) > 1 else (0.0, 0.0)
        self.size = float(np.linalg.norm(high - low))

    def look_up(self, prims: NDArray) -> tuple[NDArray[np.uint32], NDArray[np.float32]]:
        """Numbers and normals of primitives."""
        numbers = np.empty(prims.size, np.uint32)
        normals = np.empty((prims.size, 3), np.float32)
        flat = prims.reshape(-1)
        for start in range(0, len(flat), _PIECE):
            part = slice(start, start + _PIECE)
            # Cheaper than the conversion that numpy makes on its own.
            rows = self.triangles[flat[part].astype(np.intp)]
            numbers[part] = rows["number"]
            for axis, name in enumerate("xyz"):
                normals[part, axis] = rows[name]
        return numbers.reshape(prims.shape), normals.reshape(*prims.shape, 3)


def _with_meshes(
    kind: type[RaycastingScene], nthreads: int, meshes: tuple[tuple[NDArray, NDArray], ...]
) -> RaycastingScene:
    """The scene that was copied or pickled."""
    scene = kind(nthreads)
    for vertices, triangles in meshes:
        scene.add_triangles(vertices, triangles)
    return scene


def _threads(nthreads: int) -> int | None:
    return None if nthreads == 0 else nthreads


def _is_tensor(value: Any) -> bool:
    return type(value).__module__.startswith("open3d.") and hasattr(value, "numpy")


def _as_numpy(value: Any) -> Any:
    return value.cpu().numpy() if _is_tensor(value) else value


def _wrapper(*values: Any) -> Any:
    """The conversion of answers: to a tensor if one of the values is one."""
    for value in filter(_is_tensor, values):
        from_numpy = type(value).from_numpy
        return lambda array: from_numpy(np.ascontiguousarray(array))
    return lambda array: array


def _rays(rays: Any) -> tuple[NDArray, Any]:
    """Rays as an array, and the conversion of answers."""
    numbers = np.asarray(_as_numpy(rays))
    if numbers.ndim < 2 or numbers.shape[-1] != 6:
        raise ValueError(f"rays have the shape {numbers.shape}, not (…, 6) with at least two dimensions")
    return numbers, _wrapper(rays)


def _rays_of_matrices(
    intrinsic_matrix: Any, extrinsic_matrix: Any, width_px: int, height_px: int
) -> NDArray[np.float32]:
    intrinsic = np.asarray(_as_numpy(intrinsic_matrix), dtype=np.float64)
    extrinsic = np.asarray(_as_numpy(extrinsic_matrix), dtype=np.float64)
    if intrinsic.shape != (3, 3) or extrinsic.shape != (4, 4):
        shapes = f"{intrinsic.shape} and {extrinsic.shape}"
        raise ValueError(f"the matrices have the shapes {shapes}, not (3, 3) and (4, 4)")
    # The camera looks along its z axis; the transpose rotates back to the world.
    rotation, offset = extrinsic[:3, :3], extrinsic[:3, 3]
    along_x, along_y, corner = np.linalg.inv(intrinsic).T @ rotation
    across = np.outer(np.arange(width_px) + 0.5, along_x) + corner
    down = np.outer(np.arange(height_px) + 0.5, along_y)
    rays = np.empty((height_px, width_px, 6), np.float32)
    # Whole rows first: single components are written several times slower.
    rays[:] = np.concatenate([np.broadcast_to(-offset @ rotation, across.shape), across], axis=1)
    for k in range(3):
        np.add(across[:, k], down[:, k, None], out=rays[..., 3 + k], casting="same_kind")
    return rays


def _rays_of_view(
    fov_deg: float, center: Any, eye: Any, up: Any, width_px: int, height_px: int
) -> NDArray[np.float32]:
    center, eye, up = (
        np.asarray(_as_numpy(point), dtype=np.float64).reshape(3) for point in (center, eye, up)
    )
    focal = 0.5 * width_px / math.tan(0.5 * math.radians(fov_deg))
    intrinsic = [[focal, 0.0, 0.5 * width_px], [0.0, focal, 0.5 * height_px], [0.0, 0.0, 1.0]]
    # Rows of the picture go along `up`, as Open3D has them, and columns to its left.
    forward = center - eye
    left = np.cross(up, forward)
    if not np.linalg.norm(left) > 0.0:
        raise ValueError("the camera's up is parallel to its view")
    axes = [left, np.cross(forward, left), forward]
    extrinsic = np.eye(4)
    extrinsic[:3, :3] = [axis / np.linalg.norm(axis) for axis in axes]
    extrinsic[:3, 3] = -extrinsic[:3, :3] @ eye
    return _rays_of_matrices(intrinsic, extrinsic, width_px, height_px)
