"""What queries answer, against the definition in double precision."""

import numpy as np
import pytest
from conftest import CUBE_FACES, CUBE_VERTICES, by_definition, rays_between

import phalanx


@pytest.fixture(scope="module")
def soup():
    """Triangles at random, and rays among them: (scene, vertices, faces, origins, directions)."""
    rng = np.random.default_rng(3)
    vertices = rng.uniform(-3, 3, size=(600, 3)).astype(np.float32)
    faces = np.arange(600).reshape(200, 3)
    scene = phalanx.Scene()
    scene.add_mesh(vertices, faces)
    return scene, vertices, faces, *rays_between(rng, 1000)


def test_the_closest_hit_is_that_of_the_definition(soup):
    scene, vertices, faces, origins, directions = soup
    hits = scene.intersect(origins, directions)
    assert hits.t.dtype == hits.u.dtype == hits.v.dtype == np.float32
    assert hits.prim_id.dtype == hits.geom_id.dtype == np.int32 and hits.hit.dtype == bool
    assert 0.5 < hits.hit.mean() < 1.0
    for k in range(len(origins)):
        wanted = by_definition(vertices, faces, origins[k], directions[k])
        assert hits.hit[k] == bool(wanted)
        if wanted:
            assert hits.prim_id[k] == wanted[0][1]
            assert hits.t[k] == pytest.approx(wanted[0][0], rel=1e-4, abs=1e-5)
    miss = ~hits.hit
    assert np.isinf(hits.t[miss]).all() and (hits.prim_id[miss] == -1).all()
    assert (hits.u[miss] == 0).all() and (hits.normal[miss] == 0).all()


def test_weights_and_normals_belong_to_the_hit(soup):
    scene, vertices, faces, origins, directions = soup
    hits = scene.intersect(origins, directions)
    met = np.flatnonzero(hits.hit)
    a, b, c = np.moveaxis(vertices[faces[hits.prim_id[met]]].astype(np.float64), 1, 0)
    u, v = hits.u[met, None], hits.v[met, None]
    points = a * (1 - u - v) + b * u + c * v
    t, refined = hits.refine()
    assert t.dtype == refined.dtype == np.float64
    np.testing.assert_allclose(points, refined[met], atol=2e-5)
    on_ray = origins[met] + t[met, None] * directions[met]
    np.testing.assert_allclose(refined[met], on_ray, atol=1e-12)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    np.testing.assert_allclose(hits.normal[met], normal, atol=1e-6)
    assert np.isinf(t[~hits.hit]).all() and np.isnan(refined[~hits.hit]).all()


def test_all_hits_are_those_of_the_definition_in_order(soup):
    scene, vertices, faces, origins, directions = soup
    lists = scene.all_hits(origins, directions)
    counts = scene.count(origins, directions)
    assert lists.starts[0] == 0 and lists.starts[-1] == len(lists) == counts.sum()
    assert counts.max() > 4
    for k in range(len(origins)):
        rows = slice(lists.starts[k], lists.starts[k + 1])
        wanted = by_definition(vertices, faces, origins[k], directions[k])
        assert lists.prim_id[rows].tolist() == [face for _, face in wanted]
        assert (lists.ray_id[rows] == k).all() and counts[k] == len(wanted)
        assert (np.diff(lists.t[rows]) >= 0).all()


def test_all_hits_are_refined_with_the_ray_that_they_are_of(soup):
    scene, vertices, faces, origins, directions = soup
    lists = scene.all_hits(origins, directions)
    t, points = lists.refine()
    assert t.shape == (len(lists),) and points.shape == (len(lists), 3)
    on_ray = origins[lists.ray_id] + t[:, None] * directions[lists.ray_id]
    np.testing.assert_allclose(points, on_ray, atol=1e-12)
    np.testing.assert_allclose(t, lists.t, rtol=1e-3, atol=1e-5)
    first = scene.intersect(origins, directions).refine()[0]
    heads = lists.starts[:-1][np.diff(lists.starts) > 0]
    np.testing.assert_array_equal(t[heads], first[np.isfinite(first)])
    # Rays with no hits in between, and rays of more sides than one.
    grid = scene.all_hits(origins.reshape(10, 100, 3), directions.reshape(10, 100, 3))
    np.testing.assert_array_equal(grid.refine()[1], points)
    assert scene.all_hits(np.zeros((0, 6))).refine()[1].shape == (0, 3)


def test_occluded_is_whether_there_is_a_hit_before_tmax(soup):
    scene, _, _, origins, directions = soup
    hits = scene.intersect(origins, directions)
    np.testing.assert_array_equal(scene.occluded(origins, directions), hits.hit)
    short = np.where(hits.hit, hits.t, 1.0)
    assert not scene.occluded(origins, directions, tmax=short).any()
    longer = np.nextafter(short, np.float32(np.inf))
    np.testing.assert_array_equal(scene.occluded(origins, directions, tmax=longer), hits.hit)
    np.testing.assert_array_equal(scene.intersect(origins, directions, tmax=longer).t, hits.t)
    half = scene.intersect(origins, directions, tmax=0.5)
    assert 0 < half.hit.sum() < hits.hit.sum() and (half.t[half.hit] < 0.5).all()


def test_answers_have_the_shape_of_the_rays(soup):
    scene, _, _, origins, directions = soup
    flat = scene.intersect(origins, directions)
    rays = np.concatenate([origins, directions], axis=1)
    for shape in ((1000,), (10, 100), (2, 5, 100)):
        hits = scene.intersect(rays.reshape(*shape, 6))
        assert hits.t.shape == hits.geom_id.shape == shape
        assert hits.normal.shape == hits.refine()[1].shape == (*shape, 3)
        np.testing.assert_array_equal(hits.t.ravel(), flat.t)
        assert scene.occluded(rays.reshape(*shape, 6)).shape == shape
        assert scene.count(rays.reshape(*shape, 6)).shape == shape
    assert scene.intersect(origins[0], directions[0]).t.shape == ()
    one, tiled = (scene.intersect(o, directions) for o in (origins[0], [origins[0]] * 1000))
    np.testing.assert_array_equal(one.t, tiled.t)


def test_answers_do_not_depend_on_threads(soup):
    scene, _, _, origins, directions = soup
    origins, directions = np.tile(origins, (6, 1)), np.tile(directions, (6, 1))
    one = scene.intersect(origins, directions, threads=1)
    for threads in (2, 3, 7, None):
        more = scene.intersect(origins, directions, threads=threads)
        for column in ("t", "u", "v", "prim_id", "geom_id"):
            assert getattr(one, column).tobytes() == getattr(more, column).tobytes()
        counts = scene.count(origins, directions, threads=threads)
        np.testing.assert_array_equal(counts, scene.count(origins, directions, threads=1))


def test_no_ray_slips_through_an_edge_or_a_vertex(cube):
    # From within to each corner, to points of each edge, and of each diagonal.
    corners = CUBE_VERTICES[CUBE_FACES]
    weights = np.linspace(0, 1, 101, dtype=np.float32)[:, None, None]
    edges = [corners[:, k] * (1 - weights) + corners[:, k - 1] * weights for k in range(3)]
    targets = np.concatenate(edges).reshape(-1, 3)
    for origin in ([0, 0, 0], [0.25, 0.125, 0.5], [0.1, -0.7, 0.3]):
        origin = np.float32(origin)
        assert cube.occluded(origin, targets - origin).all()
        assert (cube.count(origin, targets - origin) >= 1).all()


def test_hits_begin_beyond_the_origin(cube):
    hits = cube.intersect([[0.2, 0.1, 1.0]], [[0, 0, -1]])
    assert hits.t.tolist() == [2.0]


def test_of_equal_distances_the_smallest_primitive_counts():
    scene = phalanx.Scene()
    for _ in range(3):
        scene.add_mesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    assert scene.intersect([[1, 1, 5]], [[0, 0, -1]]).prim_id.tolist() == [0]
    assert scene.all_hits([[1, 1, 5]], [[0, 0, -1]]).prim_id.tolist() == [0, 1, 2]


def test_spheres_are_hit_where_the_ray_enters():
    scene = phalanx.Scene()
    scene.add_spheres([[0, 0, 0], [0, 0, 5]], [1.0, 2.0])
    hits = scene.all_hits([[0, 0, -3]], [[0, 0, 2]])
    assert hits.t.tolist() == [1.0, 3.0] and hits.prim_id.tolist() == [0, 1]
    np.testing.assert_array_equal(hits.refine()[1], [[0, 0, -1], [0, 0, 3]])
