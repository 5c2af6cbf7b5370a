"""Hits on edges and vertices: one for each crossing of the surface."""

from __future__ import annotations

from typing import Callable

import numpy as np
from numpy.typing import NDArray

from . import AllHits

# Barycentric weights below this one lie on an edge as far as single precision can tell.
_EDGE = 1e-6

# Distance between hits on edges that are at one place, in units of the scene's size.
_SAME_PLACE = 1e-6


def on_edge(hits: AllHits) -> NDArray[np.bool_]:
    """Tells which hits lie on an edge or a vertex, as far as float32 can tell: (n,)."""
    return np.minimum(np.minimum(hits.u, hits.v), 1.0 - hits.u - hits.v) <= _EDGE


def crossings(
    hits: AllHits,
    directions: NDArray,
    normals: Callable[[NDArray[np.int64]], NDArray],
    size: float,
) -> NDArray[np.int64]:
    """Rows of the hits, without those that meet another triangle at the same place of an edge.

    Of hits on edges at one place, the nearest of those that enter the surface remains, and the
    nearest of those that leave it: one where the ray crosses it, two where it touches an edge.

    directions : (n, 3), of each ray
    normals : gives the normals, (k, 3), of the triangles that k rows of the hits meet
    size : size of the scene in units of the rays
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
