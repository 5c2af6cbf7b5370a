"""Hits on edges and vertices, reduced to one per crossing of the surface."""

from __future__ import annotations

from typing import Callable

import numpy as np
from numpy.typing import NDArray

from . import AllHits

# Hits with a barycentric weight below this are on an edge, within single precision.
_EDGE = 1e-6

# Largest distance between hits on edges at the same point, in units of the scene's size.
_SAME_PLACE = 1e-6


def on_edge(hits: AllHits) -> NDArray[np.bool_]:
    """Flags hits on an edge or a vertex, within float32 precision: (n,)."""
    return np.minimum(np.minimum(hits.u, hits.v), 1.0 - hits.u - hits.v) <= _EDGE


def crossings(
    hits: AllHits,
    directions: NDArray,
    normals: Callable[[NDArray[np.int64]], NDArray],
    size: float,
) -> NDArray[np.int64]:
    """Rows of the hits, without duplicates on triangles that share an edge or a vertex.

    Among hits on edges at one point, the nearest that enters the surface and the nearest that
    leaves it remain: one if the ray crosses the surface, two if it touches an edge.

    directions : (n, 3), of each ray
    normals : returns the normals, (k, 3), of the triangles of k rows of hits
    size : size of the scene in the rays' units
    """
    rows = np.arange(len(hits))
    edge = np.flatnonzero(on_edge(hits))
    if len(edge) < 2:
        return rows
    ray, t = hits.ray_id[edge], hits.t[edge].astype(np.float64)
    leaves = np.einsum("ij,ij->i", normals(edge), directions[ray]) > 0.0
    gap = np.diff(t) * np.linalg.norm(directions[ray[1:]], axis=1)
    new_place = (np.diff(ray) != 0) | (gap > _SAME_PLACE * size)
    place = np.concatenate([[0], np.cumsum(new_place)])
    _, first = np.unique(2 * place + leaves, return_index=True)
    return np.delete(rows, np.delete(edge, first))
