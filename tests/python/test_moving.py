"""Scenes that move, rays that choose what they hit, and hits that are indexed and pickled."""

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import phalanx
import pytest

CORNERS = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]], np.float32)
FACE = [[0, 1, 2]]
DOWN = [0, 0, -1]
ORIGINS = np.array([[1, 1, 9], [1, 2, 9], [9, 9, 9]], np.float32)


def shifted(z):
    transform = np.eye(4)
    transform[2, 3] = z
    return transform


def scene_of_three():
    """A triangle at z = 0, a sphere on it, and an instance at z = -3."""
    scene = phalanx.Scene()
    scene.add_mesh(CORNERS, FACE)
    scene.add_spheres([[1, 1, 1]], 0.5)
    prototype = scene.add_prototype(CORNERS, FACE)
    scene.add_instance(prototype, shifted(-3))
    return scene, prototype


def test_geometry_moves():
    scene, prototype = scene_of_three()
    assert scene.intersect(ORIGINS, DOWN).t.tolist() == [7.5, 9.0, np.inf]
    scene.set_vertices(0, CORNERS + [0, 0, 2])
    assert scene.intersect(ORIGINS, DOWN).t.tolist() == [7.0, 7.0, np.inf]
    scene.set_transform(2, shifted(5))
    scene.update()
    assert scene.intersect(ORIGINS, DOWN).t.tolist() == [4.0, 4.0, np.inf]
    scene.set_prototype_vertices(prototype, CORNERS + [0, 0, 1])
    assert scene.intersect(ORIGINS, DOWN).t.tolist() == [3.0, 3.0, np.inf]
    scene.set_mask(2, 0)
    assert scene.intersect(ORIGINS, DOWN).t.tolist() == [7.0, 7.0, np.inf]
    assert len(scene) == 2


def test_what_is_removed_leaves_its_number_to_the_next():
    scene, prototype = scene_of_three()
    scene.intersect(ORIGINS, DOWN)
    scene.remove(1)
    assert scene.update()["removed"] == [1]
    hits = scene.intersect(ORIGINS, DOWN)
    assert (hits.t.tolist(), hits.geom_id.tolist()[0]) == ([9.0, 9.0, np.inf], 0)
    with pytest.raises(IndexError, match="no geometry has the number 1"):
        scene.remove(1)
    assert scene.add_spheres([[1, 1, 3]], 0.5) == 1
    assert scene.update()["built"] == [1]
    assert scene.intersect(ORIGINS, DOWN).prim_id.tolist()[:2] == [1, 0]
    with pytest.raises(ValueError, match="geometry 2 is an instance of prototype 0"):
        scene.remove_prototype(prototype)
    scene.remove(2)
    scene.remove_prototype(prototype)
    assert scene.add_prototype(CORNERS, FACE) == prototype


def test_updates_say_what_they_did_and_obey():
    scene, _ = scene_of_three()
    assert scene.update()["work"] == "rebuilt"
    assert scene.update("refit")["work"] == "nothing"
    scene.set_vertices(0, CORNERS + [0, 0, 2])
    done = scene.update("refit")
    assert (done["work"], done["refitted"], done["built"]) == ("refitted", [0], [])
    assert done["cost_growth"] > 0
    added = scene.add_mesh(CORNERS + [0, 0, 5], FACE)
    with pytest.raises(ValueError, match=rf"geometries \[{added}\] and prototypes \[\] have to"):
        scene.update("refit")
    assert scene.intersect(ORIGINS, DOWN).t.tolist() == [4.0, 4.0, np.inf]
    with pytest.raises(ValueError, match="not one of auto, refit, rebuild"):
        scene.update("fast")
    spare = copy.copy(scene)
    spare.set_transform(2, shifted(6))
    with ThreadPoolExecutor() as pool:
        done = pool.submit(spare.update, "rebuild")
        assert scene.intersect(ORIGINS, DOWN).t.tolist() == [4.0, 4.0, np.inf]
        assert done.result()["work"] == "rebuilt"
    assert spare.intersect(ORIGINS, DOWN).t.tolist() == [3.0, 3.0, np.inf]


def test_moved_scenes_answer_as_new_ones():
    rng = np.random.default_rng(3)
    vertices, faces = rng.normal(size=(200, 3)), rng.integers(0, 200, (400, 3))
    scene = phalanx.Scene()
    mesh = scene.add_mesh(vertices, faces)
    small = vertices / 5
    prototype = scene.add_prototype(small, faces)
    instances = [scene.add_instance(prototype, shifted(z)) for z in range(9)]
    origins, directions = rng.normal(size=(2, 500, 3))
    for _ in range(8):
        vertices = vertices + rng.normal(scale=0.1, size=vertices.shape)
        places = [shifted(rng.normal()) for _ in instances]
        scene.set_vertices(mesh, vertices)
        for instance, place in zip(instances, places):
            scene.set_transform(instance, place)
        new = phalanx.Scene()
        new.add_mesh(vertices, faces)
        new.add_prototype(small, faces)
        for place in places:
            new.add_instance(prototype, place)
        moved, built = (s.intersect(origins, directions) for s in (scene, new))
        for name in ("t", "u", "v", "prim_id", "geom_id"):
            assert getattr(moved, name).tobytes() == getattr(built, name).tobytes(), name


def test_wrong_moves_are_refused():
    scene, _ = scene_of_three()
    for geometry in (1, 2, 7):
        with pytest.raises(IndexError, match=f"no mesh has the number {geometry}"):
            scene.set_vertices(geometry, CORNERS)
    with pytest.raises(IndexError, match="no instance has the number 0"):
        scene.set_transform(0, shifted(1))
    with pytest.raises(IndexError, match="no prototype has the number 1"):
        scene.set_prototype_vertices(1, CORNERS)
    with pytest.raises(IndexError, match="no geometry has the number 3"):
        scene.set_mask(3, 1)
    with pytest.raises(ValueError, match="2 vertices for a mesh of 3"):
        scene.set_vertices(0, CORNERS[:2])
    with pytest.raises(ValueError, match="cannot be inverted"):
        scene.set_transform(2, np.diag([1, 0, 1, 1]))


def test_rays_choose_what_they_hit():
    scene, _ = scene_of_three()
    scene.set_mask(1, 2)
    hits = scene.intersect(ORIGINS, DOWN)
    assert scene.intersect(ORIGINS, DOWN, ignore=hits.prim_id).t.tolist() == [9.0, 12.0, np.inf]
    assert scene.intersect(ORIGINS, DOWN, mask=1).t.tolist() == [9.0, 9.0, np.inf]
    assert scene.intersect(ORIGINS, DOWN, tnear=[0, 9, 0]).t.tolist() == [7.5, 12.0, np.inf]
    assert scene.occluded(ORIGINS, DOWN, tnear=9.5, tmax=11).tolist() == [False] * 3
    assert scene.occluded(ORIGINS, DOWN, tnear=9.5).tolist() == [True, True, False]
    assert scene.count(ORIGINS, DOWN, mask=[2, 1, 3]).tolist() == [3, 2, 0]
    assert scene.all_hits(ORIGINS, DOWN, ignore=0).t.tolist() == [7.5, 12.0, 12.0]
    assert scene.intersect(ORIGINS, DOWN, mask=~2).t.tolist() == [9.0, 9.0, np.inf]
    with pytest.raises(ValueError, match="mask has 4294967296"):
        scene.intersect(ORIGINS, DOWN, mask=2**32)
    with pytest.raises(ValueError, match="ignore has -2"):
        scene.intersect(ORIGINS, DOWN, ignore=-2)
    with pytest.raises(ValueError, match="ignore has the shape"):
        scene.intersect(ORIGINS, DOWN, ignore=[0, 1])
    with pytest.raises(TypeError, match="integers"):
        scene.intersect(ORIGINS, DOWN, ignore=0.5)


def test_rays_that_start_in_a_sphere_hit_its_far_side():
    scene = phalanx.Scene()
    scene.add_spheres([[0, 0, 0]], 1.0)
    ray = [[0, 0, -5]], [0, 0, 1]
    assert scene.intersect(*ray, tnear=4).t.tolist() == [6.0]
    assert scene.intersect(*ray, tnear=6).t.tolist() == [np.inf]
    assert scene.occluded(*ray, tnear=5).tolist() == [True]
    assert scene.occluded(*ray, tnear=5, tmax=6).tolist() == [False]
    rays = [[0, 0, -5]] * 3, [0, 0, 1]
    assert scene.count(*rays, tnear=[3, 5, 7]).tolist() == [1, 1, 0]
    assert scene.all_hits(*rays, tnear=[3, 5, 7]).t.tolist() == [4.0, 6.0]
    assert scene.intersect(*ray, ignore=0).t.tolist() == [np.inf]
    rng = np.random.default_rng(0)
    starts = rng.normal(size=(1000, 3))
    starts = np.float32(starts / np.linalg.norm(starts, axis=1, keepdims=True))
    inward = -starts + 0.3 * rng.uniform(-1, 1, starts.shape)
    assert (scene.intersect(starts, inward, tnear=1e-3).t > 0.5).all()


def test_no_rays_have_no_hits():
    scene, _ = scene_of_three()
    for hits in (scene.intersect([], []), scene.intersect([]), scene.intersect([], DOWN)):
        assert (hits.t.shape, len(hits), hits.normal.shape) == ((0,), 0, (0, 3))
    assert scene.occluded([], []).shape == scene.count([]).shape == (0,)
    moved = phalanx.Scene(origin=(5, 5, 5))
    assert moved.intersect([], []).t.shape == moved.intersect([]).t.shape == (0,)


def test_zero_threads_are_all():
    scene, _ = scene_of_three()
    scene.build(threads=0)
    assert scene.intersect(ORIGINS, DOWN, threads=0).t.tolist() == [7.5, 9.0, np.inf]


def test_hits_are_indexed():
    scene, _ = scene_of_three()
    rays = np.concatenate([ORIGINS, np.broadcast_to(np.float32(DOWN), (3, 3))], axis=1)
    for hits in (scene.intersect(ORIGINS, DOWN), scene.intersect(rays)):
        assert (hits[1].t.shape, hits[1].t, hits[-1].prim_id) == ((), 9.0, -1)
        some = hits[hits.hit]
        assert (len(some), some.t.tolist(), some.geom_id.tolist()) == (2, [7.5, 9.0], [1, 0])
        assert np.array_equal(some.normal, hits.normal[hits.hit])
        for part, whole in zip(hits[1:].refine(), hits.refine()):
            assert np.array_equal(part, whole[1:], equal_nan=True)
        with pytest.raises(IndexError):
            hits[3]
    picture = scene.intersect(np.broadcast_to(ORIGINS[0], (4, 5, 3)), DOWN)
    assert (picture[..., 0].t.shape, picture[1:3, ::2].v.shape) == ((4,), (2, 3))
    assert picture[2, 3].refine()[1].tolist() == [1.0, 1.0, 1.5]


def test_hits_show_themselves():
    scene, _ = scene_of_three()
    page = scene.intersect(ORIGINS, DOWN)._repr_html_()
    assert "2 of 3 rays hit" in page and page.count("<tr>") == 4 and "<td>7.5</td>" in page
    many = scene.intersect(np.broadcast_to(ORIGINS[0], (50, 3)), DOWN)._repr_html_()
    assert many.count("<tr>") == 11 and "…" in many


def test_scenes_and_hits_are_pickled_and_copied():
    scene, _ = scene_of_three()
    hits = scene.intersect(ORIGINS, DOWN)
    for again in (pickle.loads(pickle.dumps(scene)), copy.copy(scene), copy.deepcopy(scene)):
        again.set_vertices(0, CORNERS + [0, 0, 4])
        assert again.intersect(ORIGINS, DOWN).t.tolist() == [5.0, 5.0, np.inf]
        assert scene.intersect(ORIGINS, DOWN).t.tolist() == [7.5, 9.0, np.inf]
    for again in (pickle.loads(pickle.dumps(hits)), copy.copy(hits), copy.deepcopy(hits)):
        for name in ("t", "u", "v", "prim_id", "geom_id", "hit", "normal"):
            assert np.array_equal(getattr(again, name), getattr(hits, name)), name
        for mine, theirs in zip(again.refine(), hits.refine()):
            assert np.array_equal(mine, theirs, equal_nan=True)
        assert again[1:].normal.tolist() == hits.normal[1:].tolist()
    empty = phalanx.Scene(origin=(1, 2, 3))
    assert len(pickle.loads(pickle.dumps(empty))) == 0
    with pytest.raises(ValueError, match="a pickled scene"):
        scene.__setstate__(b"nonsense")


def test_a_scene_may_change_while_others_query_it():
    scene, _ = scene_of_three()
    known = {(7.5, 9.0), (7.5, 8.5)}

    def query(_):
        return tuple(scene.intersect(ORIGINS[:2], DOWN).t.tolist())

    with ThreadPoolExecutor(4) as pool:
        answers = pool.map(query, range(400))
        for k in range(100):
            scene.set_vertices(0, CORNERS + [0, 0, 0.5 * (k % 2)])
        assert set(answers) <= known
