"""RayMeshIntersector beside trimesh's own, on a mesh of trimesh."""

import copy
import pickle
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import by_definition, rays_between

trimesh = pytest.importorskip("trimesh")
RayMeshIntersector = pytest.importorskip("phalanx.trimesh").RayMeshIntersector


@pytest.fixture
def mesh():
    """A ring, which rays meet up to four times, with our intersector."""
    mesh = trimesh.creation.torus(2.0, 0.6, major_sections=31, minor_sections=17)
    mesh.ray = RayMeshIntersector(mesh)
    return mesh


def rays():
    origins, directions = rays_between(np.random.default_rng(10), 800)
    return origins.astype(np.float64), directions.astype(np.float64)


def test_all_hits_are_those_of_the_definition(mesh):
    origins, directions = rays()
    triangles, index_ray, locations = mesh.ray.intersects_id(
        origins, directions, return_locations=True
    )
    assert triangles.dtype == index_ray.dtype == np.int64 and locations.dtype == np.float64
    wanted = [by_definition(mesh.vertices, mesh.faces, *ray) for ray in zip(origins, directions)]
    assert max(map(len, wanted)) == 4
    assert index_ray.tolist() == [k for k, hits in enumerate(wanted) for _ in hits]
    assert triangles.tolist() == [face for hits in wanted for _, face in hits]
    t = np.array([t for hits in wanted for t, _ in hits])
    exact = origins[index_ray] + t[:, None] * directions[index_ray]
    np.testing.assert_allclose(locations, exact, atol=2e-6)
    first = [hits[0][1] if hits else -1 for hits in wanted]
    np.testing.assert_array_equal(mesh.ray.intersects_first(origins, directions), first)
    np.testing.assert_array_equal(
        mesh.ray.intersects_any(origins, directions), np.array(first) >= 0
    )


def test_locations_lie_on_their_rays(mesh):
    origins, directions = rays()
    for multiple_hits in (True, False):
        locations, index_ray, triangles = mesh.ray.intersects_location(
            origins, directions, multiple_hits=multiple_hits
        )
        assert len(locations) == len(index_ray) == len(triangles) > 100
        along = trimesh.unitize(directions)[index_ray]
        off = np.cross(locations - origins[index_ray], along)
        np.testing.assert_allclose(off, 0.0, atol=1e-12)
        assert len(np.unique(index_ray)) == len(index_ray) or multiple_hits


def test_max_hits_bounds_the_hits_of_each_ray(mesh):
    origins, directions = rays()
    _, all_rays = mesh.ray.intersects_id(origins, directions)
    for most in (0, 1, 2, 3):
        triangles, index_ray = mesh.ray.intersects_id(origins, directions, max_hits=most)
        wanted = np.minimum(np.bincount(all_rays, minlength=800), most)
        np.testing.assert_array_equal(np.bincount(index_ray, minlength=800), wanted)
        if most == 1:
            single = mesh.ray.intersects_id(origins, directions, multiple_hits=False)
            np.testing.assert_array_equal(triangles, single[0])
            np.testing.assert_array_equal(index_ray, single[1])


def test_results_are_those_of_trimesh(mesh):
    pytest.importorskip("rtree")
    own = trimesh.ray.ray_triangle.RayMeshIntersector(mesh)
    origins, directions = rays()
    ours, theirs = (
        sorted(zip(*map(np.ndarray.tolist, ray.intersects_id(origins, directions))))
        for ray in (mesh.ray, own)
    )
    assert ours == theirs
    points = np.random.default_rng(11).uniform(-2.7, 2.7, size=(2000, 3))
    within = mesh.ray.contains_points(points)
    np.testing.assert_array_equal(within, own.contains_points(points))
    assert 20 < within.sum() < 1000


def test_points_within_a_ring_are_those_near_its_circle():
    ring = trimesh.creation.torus(2.0, 0.6, major_sections=200, minor_sections=200)
    ring.ray = RayMeshIntersector(ring)
    points = np.random.default_rng(12).uniform(-2.7, 2.7, size=(20_000, 3))
    circle = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 2.0, points[:, 2])
    sure = abs(circle - 0.6) > 1e-3
    np.testing.assert_array_equal(ring.contains(points)[sure], (circle < 0.6)[sure])


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_lines_through_edges_and_vertices_do_not_deceive_contains(way, monkeypatch):
    # The first directions run through corners and edges of the box, on both sides at once.
    import phalanx.trimesh

    lines = np.concatenate([way * np.array([[1, 1, 1], [1, 1, 0]]), phalanx.trimesh._LINES])
    monkeypatch.setattr(phalanx.trimesh, "_LINES", lines)
    box = trimesh.creation.box().subdivide().subdivide()
    ray = RayMeshIntersector(box)
    steps = np.arange(-6, 7) / 8
    points = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    sure = abs(abs(points) - 0.5).min(axis=1) > 0
    wanted = (abs(points) < 0.5).all(axis=1)
    np.testing.assert_array_equal(ray.contains_points(points)[sure], wanted[sure])


def test_a_cavity_is_outside_and_an_open_mesh_has_no_inside():
    inner = trimesh.creation.icosphere(radius=0.5)
    inner.invert()
    shell = trimesh.util.concatenate([trimesh.creation.icosphere(radius=1.0), inner])
    ray = RayMeshIntersector(shell)
    assert ray.contains_points([[0, 0, 0], [0.7, 0, 0], [0, 0, 1.2]]).tolist() == [
        False, True, False,
    ]  # fmt: skip
    plate = trimesh.Trimesh([[-9, -9, 0], [9, -9, 0], [0, 9, 0.1]], [[0, 1, 2]])
    assert not RayMeshIntersector(plate).contains_points([[0, 0, 0.01], [0, 0, 0.09]]).any()


def test_a_crossing_at_a_vertex_or_an_edge_is_one_hit():
    box = trimesh.creation.box()
    ray = RayMeshIntersector(box)
    targets = np.concatenate([box.vertices, box.vertices[box.edges_unique].mean(axis=1)])
    for origin in ([0, 0, 0], [0.125, -0.25, 0.0625]):
        _, index_ray = ray.intersects_id(np.tile(origin, (len(targets), 1)), targets - origin)
        np.testing.assert_array_equal(index_ray, np.arange(len(targets)))
    # From outside through the middle, in at one corner and out at the other.
    _, index_ray = ray.intersects_id(box.vertices * 3, -box.vertices)
    assert np.bincount(index_ray).tolist() == [2] * 8
    # Along the diagonal of a side, and past an edge from outside.
    assert len(ray.intersects_id([[0.25, 0.25, 3]], [[0, 0, -1]])[0]) == 2
    triangles, _ = ray.intersects_id([[1.0, 0.0, 0.25]], [[-1, 1, 0]])
    assert len(triangles) == 2


def test_coincident_surfaces_are_all_hit():
    box = trimesh.creation.box()
    both = trimesh.util.concatenate([box, box])
    ray = RayMeshIntersector(both)
    assert len(ray.intersects_id([[0.1, 0.2, 3]], [[0, 0, -1]])[0]) == 4


@pytest.mark.parametrize("scale", [1e-30, 1e-12, 1e-4, 1.0, 1e4, 1e8, 1e12, 1e30])
def test_scale_does_not_matter(scale):
    mesh = trimesh.creation.icosphere(subdivisions=2)
    origins, directions = map(np.float64, rays_between(np.random.default_rng(13), 2000, 1.5))
    wanted = RayMeshIntersector(mesh).intersects_id(origins, directions)
    small = trimesh.Trimesh(mesh.vertices * scale, mesh.faces, process=False)
    ray = RayMeshIntersector(small)
    found = ray.intersects_id(origins * scale, directions * scale, return_locations=True)
    # Rounding the scaled rays moves few of them across an edge.
    assert len(found[0]) == len(wanted[0])
    assert (found[1] == wanted[1]).all() and (found[0] == wanted[0]).mean() > 0.999
    off = np.cross(found[2] / scale - origins[found[1]], directions[found[1]])
    np.testing.assert_allclose(off, 0.0, atol=1e-9)


@pytest.mark.parametrize("scale", [1e-4, 0.1, 1.0, 10, 1e4, 1e8])
def test_a_ray_that_starts_on_the_surface_hits_the_other_side_only(scale):
    mesh = trimesh.creation.box().subdivide().subdivide()
    mesh.apply_scale(scale)
    for box in (True, False):
        ray = RayMeshIntersector(mesh, scale_to_box=box)
        down = [[0.0, 0.0, -1.0]]
        on = ray.intersects_id([[0.0, 0.0, scale / 2]], down, return_locations=True)
        np.testing.assert_allclose(on[2], [[0, 0, -scale / 2]], rtol=1e-7)
        assert len(ray.intersects_id([[0.0, 0.0, scale]], down)[0]) == 2


def test_far_from_the_origin_of_coordinates_no_precision_is_lost():
    mesh = trimesh.creation.icosphere(subdivisions=3)
    far = np.array([528980.0, 183526.0, 1e6])
    origins, directions = (
        a.astype(np.float64) for a in rays_between(np.random.default_rng(14), 999)
    )
    near = RayMeshIntersector(mesh).intersects_id(origins, directions, return_locations=True)
    mesh.apply_translation(far)
    found = RayMeshIntersector(mesh).intersects_id(origins + far, directions, return_locations=True)
    np.testing.assert_array_equal(found[1], near[1])
    assert (found[0] == near[0]).mean() > 0.999
    np.testing.assert_allclose(found[2] - far, near[2], atol=1e-5)


def test_it_follows_the_mesh(mesh):
    down = ([[2.0, 0.1, 5.0]], [[0.0, 0.0, -1.0]])
    assert mesh.ray.intersects_any(*down)[0]
    mesh.apply_translation([10, 0, 0])
    assert not mesh.ray.intersects_any(*down)[0]
    mesh.vertices -= [10, 0, 0]
    assert mesh.ray.intersects_any(*down)[0]
    mesh.update_faces(np.zeros(len(mesh.faces), bool))
    assert not mesh.ray.intersects_any(*down)[0]
    assert not mesh.ray.contains_points([[2, 0, 0]])[0]


def test_it_can_be_copied_and_pickled(mesh):
    down = ([[2.0, 0.1, 5.0]], [[0.0, 0.0, -1.0]])
    first = mesh.ray.intersects_id(*down)
    for again in (copy.copy, copy.deepcopy, lambda ray: pickle.loads(pickle.dumps(ray))):
        ray = again(mesh.ray)
        assert ray is not mesh.ray
        np.testing.assert_array_equal(ray.intersects_id(*down), first)
    assert copy.deepcopy(mesh.ray).mesh is not mesh


def test_threads_of_a_pool_share_one_scene(mesh, monkeypatch):
    origins, directions = rays()
    wanted = mesh.ray.intersects_first(origins, directions)
    made = []
    make = RayMeshIntersector._make

    def slowly_make(ray):
        made.append(ray)
        time.sleep(0.05)
        return make(ray)

    monkeypatch.setattr(RayMeshIntersector, "_make", slowly_make)
    ray = RayMeshIntersector(mesh, threads=1)
    with ThreadPoolExecutor(8) as pool:
        found = pool.map(lambda _: ray.intersects_first(origins, directions), range(64))
        for first in found:
            np.testing.assert_array_equal(first, wanted)
    assert made == [ray]


@pytest.mark.parametrize("module", ["ray_pyembree", "ray_triangle"])
def test_all_that_is_public_in_trimeshs_own_is_here(mesh, module):
    own = pytest.importorskip(f"trimesh.ray.{module}")
    names = {name for name in dir(own.RayMeshIntersector(mesh)) if not name.startswith("_")}
    assert "intersects_id" in names and names <= set(dir(mesh.ray))


def test_no_rays_have_no_hits(mesh):
    for none in (np.zeros((0, 3)), []):
        assert [len(a) for a in mesh.ray.intersects_id(none, none)] == [0, 0]
        locations, index_ray, triangles = mesh.ray.intersects_location(none, none)
        assert locations.shape == (0, 3) and index_ray.dtype == triangles.dtype == np.int64
        assert mesh.ray.intersects_first(none, none).shape == (0,)
        assert mesh.ray.intersects_any(none, none).shape == (0,)
    assert mesh.ray.contains_points(np.zeros((0, 3))).shape == (0,)


def test_rays_and_points_that_are_none_are_refused_or_hit_nothing(mesh):
    queries = (mesh.ray.intersects_id, mesh.ray.intersects_first, mesh.ray.intersects_any)
    for query in queries:
        for origins, directions in (([[0, 0, 0]], [[0, 0]]), ([0, 0, 0], [0, 0, 1])):
            with pytest.raises(ValueError, match="shape"):
                query(origins, directions)
        with pytest.raises(TypeError):
            query([["a", "b", "c"]], [["a", "b", "c"]])
    for bad in (np.nan, np.inf):
        assert not mesh.ray.intersects_any([[bad, 0, 5]], [[0, 0, -1]])[0]
        assert not mesh.ray.intersects_any([[2, 0.1, 5]], [[0, 0, bad]])[0]
        assert not mesh.ray.contains_points([[bad, 0, 0]])[0]
    assert not mesh.ray.intersects_any([[2, 0, 0]], [[0, 0, 0]])[0]
    for length in (1e-300, 1e-30, 1e30, 1e300):
        assert mesh.ray.intersects_any([[2, 0.1, 5]], [[0, 0, -length]])[0]
    with pytest.raises(ValueError, match="shape"):
        mesh.ray.contains_points([0, 0, 0])
    bent = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], process=False)
    with pytest.raises(ValueError):
        RayMeshIntersector(bent).intersects_any([[0, 0, 1]], [[0, 0, -1]])
