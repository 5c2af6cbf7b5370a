"""Rays against triangles and spheres: numpy arrays in, numpy arrays out, the same bits on every CPU.

Scene holds what rays meet, and casts them. phalanx.trimesh and phalanx.open3d have the classes that
programs for trimesh and Open3D use.
"""

from ._levels import load as _load

_phalanx = _load()

AllHits = _phalanx.AllHits
Hits = _phalanx.Hits
Scene = _phalanx.Scene
isa = _phalanx.isa
__version__ = _phalanx.__version__

__all__ = ["AllHits", "Hits", "Scene", "isa"]
