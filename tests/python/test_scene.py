"""What a scene is made of, and that it can be kept in a file."""

import json
import subprocess

import numpy as np
import pytest
from conftest import CUBE_FACES, CUBE_VERTICES, rays_between

import phalanx


def test_geometries_are_numbered_and_their_primitives_begin_where_first_prim_says():
    scene = phalanx.Scene()
    assert scene.add_mesh(CUBE_VERTICES, CUBE_FACES) == 0
    assert scene.add_spheres([[5, 0, 0], [9, 0, 0]], 1.0) == 1
    assert scene.add_mesh(CUBE_VERTICES + [0, 8, 0], CUBE_FACES) == 2
    assert [scene.first_prim(geom) for geom in (0, 1, 2, 3, -1)] == [0, 12, 14, None, None]
    hits = scene.intersect([[0.2, 0.1, 5], [9, 0, 5], [0.2, 8.1, 5], [20, 20, 5]], [0, 0, -1])
    assert hits.geom_id.tolist() == [0, 1, 2, -1]
    assert hits.prim_id.tolist() == [10, 13, 24, -1]
    assert len(scene) == 26


def test_instances_show_a_prototype_where_their_transform_puts_it():
    scene = phalanx.Scene()
    cube = scene.add_prototype(CUBE_VERTICES, CUBE_FACES)
    move = np.eye(4)
    move[:3, 3] = [10, 0, 0]
    half = np.diag([0.5, 0.5, 0.5, 1.0])
    assert scene.add_instance(cube, move) == 0
    assert scene.add_instance(cube, half[:3]) == 1
    hits = scene.intersect([[10.1, 0.2, 5], [0.1, 0.2, 5], [0.8, 0.2, 5]], [0, 0, -1])
    np.testing.assert_array_equal(hits.t, np.float32([4.0, 4.5, np.inf]))
    assert hits.geom_id.tolist() == [0, 1, -1]
    np.testing.assert_allclose(scene.bounds, [[-0.5, -1, -1], [11, 1, 1]], atol=1e-4)
    # Each of the primitives that instances show has a number of 31 bits.
    dense = scene.add_prototype(CUBE_VERTICES, np.tile(CUBE_FACES, (50_000, 1)))
    for _ in range(3579):
        scene.add_instance(dense, move)
    with pytest.raises(ValueError, match="2148000036 primitives.* at most 2147483647"):
        scene.build()
    with pytest.raises(IndexError, match="prototype 7"):
        scene.add_instance(7, move)
    with pytest.raises(ValueError):
        scene.add_instance(cube, np.zeros((4, 4)))


def test_an_origin_keeps_the_precision_of_maps():
    far = np.array([528980.0, 183526.0, 40.0])
    scene = phalanx.Scene(origin=tuple(far))
    scene.add_mesh(CUBE_VERTICES.astype(np.float64) * 0.01 + far, CUBE_FACES)
    t, points = scene.intersect([far + [0.003, 0.001, 5.0]], [[0.0, 0.0, -1.0]]).refine()
    np.testing.assert_allclose(t, [4.99], atol=1e-8)
    np.testing.assert_allclose(points, [far + [0.003, 0.001, 0.01]], atol=1e-7)
    np.testing.assert_allclose(scene.bounds, [far - 0.01, far + 0.01], atol=1e-7)


def test_rays_side_by_side_keep_the_precision_of_maps_too():
    far = np.array([528980.0, 183526.0, 40.0])
    scene = phalanx.Scene(origin=tuple(far))
    scene.add_mesh(CUBE_VERTICES.astype(np.float64) * 0.01 + far, CUBE_FACES)
    origins = far + np.random.default_rng(5).uniform(-0.01, 0.01, (500, 3))
    origins[:, 2] = 45.0
    down = np.broadcast_to([0.0, 0.0, -1.0], origins.shape)
    apart, together = scene.intersect(origins, down), scene.intersect(np.hstack([origins, down]))
    assert apart.hit.all()
    for column in ("t", "u", "v", "prim_id"):
        assert getattr(apart, column).tobytes() == getattr(together, column).tobytes()


def test_a_saved_scene_gives_the_same_bits(cube, tmp_path):
    path = tmp_path / "cube.phx"
    cube.save(path)
    origins, directions = rays_between(np.random.default_rng(1), 5000)
    before = cube.intersect(origins, directions)
    for again in (phalanx.Scene.open(path), phalanx.Scene.load(path)):
        after = again.intersect(origins, directions)
        for column in ("t", "u", "v", "prim_id", "geom_id"):
            assert getattr(before, column).tobytes() == getattr(after, column).tobytes()
    with pytest.raises(ValueError, match=".phx"):
        cube.save(tmp_path / "cube.obj")
    with pytest.raises(OSError):
        phalanx.Scene.open(tmp_path / "none.phx")
    again = phalanx.Scene.open(path)
    assert again.add_spheres([[0, 0, 9]], 0.5) == cube.add_spheres([[0, 0, 9]], 0.5)
    assert again.intersect([[0, 0, 20]], [0, 0, -1]).geom_id == [1]
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(ValueError):
        phalanx.Scene.open(path)


@pytest.mark.parametrize("quality", ["fastest", "fast", "medium", "best"])
def test_answers_do_not_depend_on_the_tree(quality):
    scenes = [phalanx.Scene.load("standard:room:5k") for _ in range(2)]
    scenes[1].build(quality=quality)
    low, high = scenes[0].bounds
    rng = np.random.default_rng(2)
    ends = rng.uniform(low, high, size=(2, 20000, 3)).astype(np.float32)
    first, second = (scene.intersect(ends[0], ends[1] - ends[0]) for scene in scenes)
    assert first.hit.mean() > 0.5
    for column in ("t", "u", "v", "prim_id"):
        assert getattr(first, column).tobytes() == getattr(second, column).tobytes()
    with pytest.raises(ValueError, match="quality"):
        scenes[1].build(quality="perfect")


def test_a_query_sees_what_was_added_before_it(cube):
    up = ([[0.1, 0.2, 2.0]], [[0.0, 0.0, 1.0]])
    assert not cube.occluded(*up)[0]
    cube.add_spheres([[0, 0, 5]], [1.0])
    assert cube.occluded(*up)[0]


def test_pictures_have_the_size_that_was_asked_for(cube):
    camera = ((0, 0, 5), (0, 0, 0), (0, 1, 0), 40.0)
    depth = cube.depth(camera=camera, size=(31, 21))
    assert depth.shape == (21, 31) and depth.dtype == np.float32
    # The camera looks along the ray of the middle pixel.
    assert depth[10, 15] == pytest.approx(4.0, abs=1e-6) and np.isinf(depth[0, 0])
    layers = cube.render(camera=camera, size=(31, 21), aovs=["primitive"])
    assert layers["color"].shape == (21, 31, 3)
    assert layers["primitive"][10, 15] in (10, 11) and layers["primitive"][0, 0] == -1
    with pytest.raises(ValueError, match="layer"):
        cube.render(size=(8, 8), aovs=["smell"])


def test_exposure_and_tone_come_after_the_light(cube, program, tmp_path):
    camera = ((3, 2, 5), (0, 0, 0), (0, 1, 0), 40)
    plain = cube.render(camera, (32, 24))
    assert plain.max() > 0
    np.testing.assert_array_equal(cube.render(camera, (32, 24), exposure=0), plain)
    np.testing.assert_array_equal(cube.render(camera, (32, 24), exposure=-3), plain / 8)
    toned = cube.render(camera, (32, 24), exposure=9.5, tone="neutral")
    assert 0.9 < toned.max() <= 1 and (toned >= 0).all()
    # What `auto` measures does not depend on the size, and is the program's.
    auto = cube.render(camera, (32, 24), exposure="auto")
    lit = plain > 0
    ratios = auto[lit] / plain[lit]
    np.testing.assert_allclose(ratios, ratios[0], rtol=1e-6)
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in CUBE_VERTICES)
    faces = "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in CUBE_FACES)
    path = tmp_path / "cube.obj"
    path.write_text(corners + faces)
    scene = phalanx.Scene.load(path)
    gains = [scene.render(size=size, spp=1, exposure="auto").max() / scene.render(size=size, spp=1).max()
             for size in ((64, 48), (400, 300))]
    command = [program, "render", path, "-o", tmp_path / "a.png", "--size", "64x48", "--exposure", "auto", "--json"]
    told = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    np.testing.assert_allclose(gains, 2 ** told["image"]["exposure"], rtol=1e-6)
    layers = cube.render(camera, (32, 24), aovs=["direct"], exposure=1)
    np.testing.assert_array_equal(layers["direct"] * 2, layers["color"])
    for wrong in ({"exposure": "bright"}, {"exposure": 101}, {"exposure": float("nan")}, {"exposure": [1]}, {"tone": "filmic"}):
        with pytest.raises(ValueError, match="expected"):
            cube.render(camera, **wrong)
