"""RaycastingScene: with numpy arrays alone, and beside Open3D's own where it is installed."""

import copy
import pickle
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import CUBE_FACES, CUBE_VERTICES, rays_between

from phalanx.open3d import RaycastingScene

INVALID = RaycastingScene.INVALID_ID


@pytest.fixture
def scene():
    """Two cubes: around the origin, and a smaller one beyond it along x."""
    scene = RaycastingScene()
    assert scene.add_triangles(CUBE_VERTICES, CUBE_FACES.astype(np.uint32)) == 0
    assert scene.add_triangles(CUBE_VERTICES * 0.5 + [4, 0, 0], CUBE_FACES) == 1
    return scene


def open3d():
    try:
        import open3d
    except (ImportError, OSError) as error:
        pytest.skip(f"Open3D cannot be imported: {error}")
    return open3d


def test_the_closest_hit_has_its_own_meshs_triangle(scene):
    rays = np.float32([[[-5, 0.2, 0.5, 1, 0, 0], [9, 0.2, 0.1, -2, 0, 0]]])
    found = scene.cast_rays(np.concatenate([rays, rays + [0, 9, 0, 0, 0, 0]]))
    assert set(found) == {
        "t_hit", "geometry_ids", "primitive_ids", "primitive_uvs", "primitive_normals",
    }  # fmt: skip
    np.testing.assert_array_equal(found["t_hit"], np.float32([[4, 2.25], [np.inf, np.inf]]))
    assert found["geometry_ids"].tolist() == [[0, 1], [INVALID, INVALID]]
    assert found["primitive_ids"].tolist() == [[0, 2], [INVALID, INVALID]]
    normals = [[[-1, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, 0, 0]]]
    np.testing.assert_array_equal(found["primitive_normals"], normals)
    assert found["primitive_uvs"].shape == (2, 2, 2)
    kinds = [found[name].dtype for name in ("t_hit", "geometry_ids", "primitive_ids")]
    assert kinds == [np.float32, np.uint32, np.uint32]


def test_counts_and_lists_have_each_crossing_once(scene):
    # Through both cubes; through the diagonals of all their sides; past them.
    rays = np.float32([[-5, 0.2, 0.1, 1, 0, 0], [-5, 0, 0, 1, 0, 0], [-5, 8, 0, 1, 0, 0]])
    assert scene.count_intersections(rays).tolist() == [4, 4, 0]
    assert scene.count_intersections(rays).dtype == np.int32
    found = scene.list_intersections(rays)
    assert found["ray_splits"].tolist() == [0, 4, 8, 8]
    assert found["ray_ids"].tolist() == [0] * 4 + [1] * 4
    np.testing.assert_allclose(found["t_hit"], [4, 6, 8.5, 9.5] * 2, rtol=1e-6)
    assert found["geometry_ids"].tolist() == [0, 0, 1, 1] * 2
    assert found["primitive_ids"][:4].tolist() == [1, 2, 1, 2]
    assert found["primitive_uvs"].shape == (8, 2)
    assert {found[name].dtype for name in ("ray_splits", "ray_ids", "primitive_ids")} == {
        np.dtype(np.uint32)
    }


def test_a_mesh_that_is_added_after_a_query_is_hit(scene):
    ray = np.float32([[-5, 20.2, 0.5, 1, 0, 0]])
    assert scene.cast_rays(ray)["geometry_ids"].tolist() == [INVALID]
    assert scene.add_triangles(CUBE_VERTICES + [0, 20, 0], CUBE_FACES) == 2
    found = scene.cast_rays(ray)
    assert found["geometry_ids"].tolist() == [2] and found["primitive_ids"].tolist() == [0]


def test_occlusion_counts_between_tnear_and_tfar(scene):
    ray = np.float32([[-5, 0.2, 0.1, 1, 0, 0]])
    between = [
        (0, np.inf, True), (0, 4, False), (0, 4.1, True), (4.1, 5.9, False), (4.1, 6.1, True),
        (6.1, 8.4, False), (8.6, np.inf, True), (9.6, np.inf, False), (-3, 3, False), (5, 4, False),
    ]  # fmt: skip
    for tnear, tfar, wanted in between:
        found = scene.test_occlusions(ray, tnear=tnear, tfar=tfar)
        assert found.dtype == bool and found.tolist() == [wanted], (tnear, tfar)


def test_pinhole_rays_go_through_pixels_centres():
    rays = RaycastingScene.create_rays_pinhole(
        fov_deg=90, center=[0, 0, 0], eye=[0, 0, 4], up=[0, 1, 0], width_px=4, height_px=2
    )
    assert rays.shape == (2, 4, 6) and rays.dtype == np.float32
    np.testing.assert_allclose(rays[..., :3], np.broadcast_to([0, 0, 4], (2, 4, 3)))
    across = rays[0, :, 3] / -rays[0, :, 5]
    np.testing.assert_allclose(abs(across), [0.75, 0.25, 0.25, 0.75], rtol=1e-6)
    with pytest.raises(ValueError):
        RaycastingScene.create_rays_pinhole(90, [0, 0, 0], [0, 4, 0], [0, 1, 0], 4, 2)
    with pytest.raises(ValueError):
        RaycastingScene.create_rays_pinhole(np.eye(4), np.eye(4), 4, 2)


def test_open3d_is_not_imported_for_arrays():
    import subprocess

    script = """
import sys, numpy as np, phalanx.open3d as o3
scene = o3.RaycastingScene()
scene.add_triangles(np.eye(3, dtype=np.float32), np.uint32([[0, 1, 2]]))
assert scene.cast_rays(np.float32([[1, 1, 1, -1, -1, -1]]))["geometry_ids"].tolist() == [0]
assert "open3d" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", script], check=True)


def test_hits_looked_up_in_pieces_are_those_looked_up_at_once(scene, monkeypatch):
    origins, directions = rays_between(np.random.default_rng(17), 1000)
    rays = np.concatenate([origins + [2, 0, 0], directions], axis=1).reshape(20, 50, 6)
    whole = scene.cast_rays(rays)
    assert {0, 1, INVALID} == set(whole["geometry_ids"].flat)
    monkeypatch.setattr("phalanx.open3d._PIECE", 7)
    for name, column in scene.cast_rays(rays).items():
        np.testing.assert_array_equal(column, whole[name])
        assert column.flags.c_contiguous


def test_a_scene_can_be_copied_and_pickled(scene):
    ray = np.float32([[-5, 0.2, 0.5, 1, 0, 0], [9, 0.2, 0.1, -2, 0, 0], [-5, 20.2, 0.5, 1, 0, 0]])
    wanted = scene.cast_rays(ray)
    for again in (copy.copy, copy.deepcopy, lambda scene: pickle.loads(pickle.dumps(scene))):
        other = again(scene)
        for name, column in other.cast_rays(ray).items():
            np.testing.assert_array_equal(column, wanted[name])
        # Meshes that are added later belong to one of them.
        assert other.add_triangles(CUBE_VERTICES + [0, 20, 0], CUBE_FACES) == 2
        assert other.cast_rays(ray)["geometry_ids"].tolist() == [0, 1, 2]
        assert scene.cast_rays(ray)["geometry_ids"].tolist() == [0, 1, INVALID]


def test_threads_of_a_pool_cast_rays_while_others_add_meshes():
    scene = RaycastingScene(nthreads=1)
    ray = np.float32([[-999, 0.2, 0.5, 1, 0, 0]])

    def add_and_cast(k):
        # In front of the meshes of smaller k.
        number = scene.add_triangles(CUBE_VERTICES - [4 * k, 0, 0], CUBE_FACES)
        found = scene.cast_rays(ray, nthreads=1)
        return number, *(found[name][0] for name in ("geometry_ids", "primitive_ids", "t_hit"))

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(8) as pool:
            found = list(pool.map(add_and_cast, range(200)))
    finally:
        sys.setswitchinterval(interval)
    owner = {number: k for k, (number, *_) in enumerate(found)}
    assert sorted(owner) == list(range(200))
    for k, (_, geometry, primitive, t) in enumerate(found):
        assert owner[geometry] >= k and primitive == 0 and round(t) == 998 - 4 * owner[geometry]


def test_point_queries_are_refused_by_name(scene):
    for name in ("closest_points", "distance", "occupancy", "signed_distance"):
        with pytest.raises(NotImplementedError, match=rf"^compute_{name}\(\) .* rays only$"):
            getattr(scene, f"compute_{name}")(np.zeros((1, 3), np.float32), nthreads=1)


def test_all_that_is_public_in_open3ds_scene_is_here():
    names = {name for name in dir(open3d().t.geometry.RaycastingScene) if not name.startswith("_")}
    assert "cast_rays" in names and names <= set(dir(RaycastingScene))


def test_wrong_arguments_are_refused(scene):
    queries = (
        scene.cast_rays, scene.test_occlusions, scene.count_intersections, scene.list_intersections,
    )  # fmt: skip
    for query in queries:
        for rays in (np.zeros(6), np.zeros((4, 5)), np.zeros((4, 3)), 3.0):
            with pytest.raises(ValueError):
                query(rays)
        with pytest.raises(TypeError):
            query(np.full((2, 6), "a"))
        with pytest.raises(ValueError):
            query(np.zeros((2, 6)), nthreads=-1)
    with pytest.raises(IndexError):
        scene.add_triangles(CUBE_VERTICES, CUBE_FACES + 1)
    with pytest.raises(ValueError):
        scene.add_triangles(CUBE_VERTICES * np.nan, CUBE_FACES)
    with pytest.raises(TypeError):
        scene.add_triangles(CUBE_VERTICES)
    assert scene.count_intersections(np.float32([[-5, 0.2, 0.1, 1, 0, 0]])).tolist() == [4]


def test_empty_scenes_and_rays_have_empty_answers(scene):
    ray = np.float32([[0, 0, 5, 0, 0, -1]])
    nothing = RaycastingScene()
    assert nothing.cast_rays(ray)["primitive_ids"].tolist() == [INVALID]
    assert nothing.count_intersections(ray).tolist() == [0]
    nothing.add_triangles(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    assert nothing.list_intersections(ray)["ray_splits"].tolist() == [0, 0]
    for empty in (np.zeros((0, 6)), np.zeros((3, 0, 6))):
        assert scene.cast_rays(empty)["primitive_normals"].shape == (*empty.shape[:-1], 3)
        assert scene.count_intersections(empty).shape == empty.shape[:-1]
        assert scene.test_occlusions(empty, tnear=1.0).shape == empty.shape[:-1]
        assert scene.list_intersections(empty)["ray_splits"].tolist() == [0]


def test_answers_are_those_of_open3d():
    core, geometry = open3d().core, open3d().t.geometry
    theirs, ours = geometry.RaycastingScene(), RaycastingScene()
    for mesh in (geometry.TriangleMesh.create_sphere(1.0, 30), geometry.TriangleMesh.create_box()):
        assert theirs.add_triangles(mesh) == ours.add_triangles(mesh)
    origins, directions = rays_between(np.random.default_rng(15), 12_000)
    rays = np.concatenate([origins, directions], axis=1).reshape(300, 40, 6)
    tensor = core.Tensor(rays)
    a, b, c = theirs.cast_rays(tensor), ours.cast_rays(tensor), ours.cast_rays(rays)
    assert a.keys() == b.keys() == c.keys()
    for name in a:
        assert type(b[name]) is core.Tensor and type(c[name]) is np.ndarray
        assert a[name].dtype == b[name].dtype and a[name].shape == b[name].shape
        np.testing.assert_array_equal(b[name].numpy(), c[name])
        np.testing.assert_allclose(a[name].numpy(), c[name], atol=1e-3)
    assert 0.1 < np.isfinite(c["t_hit"]).mean() < 0.9
    for query, options in (
        ("test_occlusions", {}), ("test_occlusions", {"tnear": 0.4, "tfar": 0.6}),
        ("count_intersections", {}),
    ):  # fmt: skip
        a, b = (getattr(s, query)(tensor, **options) for s in (theirs, ours))
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a.numpy(), b.numpy())
    a, b = theirs.list_intersections(tensor), ours.list_intersections(tensor)
    assert a.keys() == b.keys()
    for name in a:
        assert a[name].dtype == b[name].dtype and a[name].shape == b[name].shape
    np.testing.assert_array_equal(a["ray_splits"].numpy(), b["ray_splits"].numpy())
    # Open3D lists the hits of a ray as its tree has them.
    key = ("ray_ids", "geometry_ids", "primitive_ids")
    for_sets = [set(zip(*(lists[name].numpy().tolist() for name in key))) for lists in (a, b)]
    assert for_sets[0] == for_sets[1]


def test_pinhole_rays_are_those_of_open3d():
    core = open3d().core
    theirs, ours = open3d().t.geometry.RaycastingScene, RaycastingScene
    view = (60, [0.1, 0, 0], [1, 2, 3], [0, 1, 0.2], 40, 30)
    a, b = (kind.create_rays_pinhole(*view) for kind in (theirs, ours))
    np.testing.assert_allclose(a.numpy(), b, atol=1e-6)
    intrinsic = core.Tensor([[100.0, 3, 20], [0, 110, 15], [0, 0, 1]])
    extrinsic = np.eye(4)
    extrinsic[:3, :3] = np.linalg.qr(np.random.default_rng(16).normal(size=(3, 3)))[0]
    extrinsic[:3, 3] = [1, 2, 3]
    extrinsic = core.Tensor(extrinsic)
    a, b = (kind.create_rays_pinhole(intrinsic, extrinsic, 40, 30) for kind in (theirs, ours))
    assert type(b) is core.Tensor
    np.testing.assert_allclose(a.numpy(), b.numpy(), atol=1e-5)
