"""A plugin of pytest for trimesh's own tests: both of its RayMeshIntersectors are ours.

python -m pytest -p trimesh_plugin TRIMESH/tests/test_ray.py
"""

import pytest
import trimesh
import trimesh.ray.ray_pyembree
import trimesh.ray.ray_triangle

import phalanx.trimesh

EXCLUDED = {
    "test_embree_duplicate_hits": (
        "wants a hit at distance 0 for a ray that starts on the surface, which Embree counts: ours "
        "begin beyond the origin. tests/python/test_trimesh.py casts these rays"
    ),
}

for module in (trimesh.ray.ray_pyembree, trimesh.ray.ray_triangle):
    module.RayMeshIntersector = phalanx.trimesh.RayMeshIntersector


def pytest_collection_modifyitems(items):
    for item in items:
        if item.name in EXCLUDED:
            item.add_marker(pytest.mark.skip(reason=EXCLUDED[item.name]))


def pytest_sessionfinish():
    # Nothing is shown if a later import has undone the change.
    assert type(trimesh.creation.box().ray) is phalanx.trimesh.RayMeshIntersector
