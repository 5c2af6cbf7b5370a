"""Ray casting against triangles and spheres, on numpy arrays.

Scene holds the geometry and casts rays at it: help(phalanx.Scene). Answers
are the same bits on every CPU. phalanx.trimesh and phalanx.open3d have
classes for programs that use trimesh and Open3D.
"""

from ._levels import load as _load

_phalanx = _load()

AllHits = _phalanx.AllHits
Hits = _phalanx.Hits
Scene = _phalanx.Scene
isa = _phalanx.isa
__version__ = _phalanx.__version__

__all__ = ["AllHits", "Hits", "Scene", "isa"]
