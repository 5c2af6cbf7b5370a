"""Arrays as no one should give them: an exception of the right type, or a defined answer."""

import sys

import numpy as np
import pytest
from conftest import CUBE_FACES, CUBE_VERTICES, rays_between

import phalanx

ORIGINS = np.float32([[0.2, 0.1, 5], [0.3, 0.1, 5], [9, 9, 5]])
DIRECTIONS = np.float32([[0, 0, -1], [0, 0, -2], [0, 0, -1]])
QUERIES = ["intersect", "occluded", "count", "all_hits"]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_rays_that_are_not_finite_hit_nothing(cube, bad):
    for column in range(6):
        rays = np.concatenate([ORIGINS, DIRECTIONS], axis=1)
        rays[0, column] = bad
        assert cube.intersect(rays).prim_id.tolist() == [-1, 10, -1]
        assert cube.occluded(rays).tolist() == [False, True, False]
        assert cube.count(rays).tolist() == [0, 2, 0]
        assert cube.all_hits(rays).ray_id.tolist() == [1, 1]
    # Numbers beyond float32 become infinite.
    with np.errstate(over="ignore"):
        assert not cube.occluded([[1e300, 0, 5]], [[0, 0, -1]])[0]


@pytest.mark.parametrize("tmax", [0.0, -1.0, np.nan, -np.inf])
def test_a_tmax_that_is_not_positive_hits_nothing(cube, tmax):
    assert not cube.occluded(ORIGINS, DIRECTIONS, tmax=tmax).any()
    assert not cube.intersect(ORIGINS, DIRECTIONS, tmax=np.full(3, tmax)).hit.any()
    assert cube.occluded(ORIGINS, DIRECTIONS, tmax=[tmax, np.inf, 1]).tolist() == [
        False,
        True,
        False,
    ]


def test_a_direction_of_zero_hits_nothing(cube):
    assert not cube.occluded([[0, 0, 0], [0, 0, 1]], [0, 0, 0]).any()
    assert np.isinf(cube.intersect([[0, 0, 0]], [[-0.0, 0, 0]]).t[0])


def test_directions_of_extreme_length_do_no_harm(cube):
    for length in (1e-44, 1e-38, 1e-20, 1e20, 3e38):
        hits = cube.intersect([[0.2, 0.1, 5]], np.float32([[0, 0, -length]]))
        assert hits.prim_id[0] in (-1, 10)
        assert not hits.hit[0] or hits.t[0] == pytest.approx(4 / length, rel=1e-3)


def test_empty_arrays_have_empty_answers(cube):
    for scene in (cube, phalanx.Scene()):
        for shape in ((0, 3), (0, 5, 3), (4, 0, 3)):
            empty = np.zeros(shape)
            hits = scene.intersect(empty, empty)
            assert hits.t.shape == shape[:-1] and hits.normal.shape == shape
            assert hits.refine()[1].shape == shape
            assert scene.occluded(empty, empty).shape == shape[:-1]
            assert scene.count(empty, empty).shape == shape[:-1]
            lists = scene.all_hits(empty, empty)
            assert len(lists) == 0 and lists.starts.tolist() == [0]


def test_a_scene_of_nothing_is_hit_by_nothing(tmp_path):
    nothing = phalanx.Scene()
    flat = phalanx.Scene()
    assert flat.add_mesh(np.zeros((0, 3)), np.zeros((0, 3), int)) == 0
    assert flat.add_mesh(np.zeros((0, 3)), []) == 1
    assert flat.add_mesh([[0, 0, 0]], []) == 2
    # Triangles without area.
    assert flat.add_mesh([[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, 1, 0], [0, 1, 1]]) == 3
    for scene in (nothing, flat):
        assert not scene.intersect(ORIGINS, DIRECTIONS).hit.any()
        assert not scene.occluded([[0.5, 0, 5]], [[0, 0, -1]]).any()
        assert scene.count(ORIGINS, DIRECTIONS).tolist() == [0, 0, 0]
        assert len(scene.all_hits(ORIGINS, DIRECTIONS)) == 0
        assert scene.render(size=(8, 8)).shape == (8, 8, 3)
        scene.save(tmp_path / "nothing.phx")
        assert not phalanx.Scene.open(tmp_path / "nothing.phx").occluded(ORIGINS, DIRECTIONS).any()


@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize(
    "origins, directions",
    [
        (np.zeros((4, 2)), np.zeros((4, 2))),
        (np.zeros((4, 3)), np.zeros((5, 3))),
        (np.zeros((4, 3)), np.zeros((4, 4))),
        (np.zeros(()), np.zeros(())),
        (np.zeros((3, 4)), np.zeros((3, 4))),
        (np.zeros((4, 3)), None),
        (np.zeros((4, 7)), None),
    ],
)
def test_wrong_shapes_are_value_errors(cube, query, origins, directions):
    with pytest.raises(ValueError, match="shape"):
        getattr(cube, query)(origins, directions)


@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize(
    "origins",
    [
        np.zeros((4, 3), complex),
        np.zeros((4, 3), bool),
        np.zeros((4, 3), "datetime64[s]"),
        np.full((4, 3), "a"),
        np.full((4, 3), None),
        np.zeros((4, 3), [("x", "f4")]),
        [[1, 2, 3], [4, 5]],
        "rays",
        object(),
        {1: 2},
    ],
)
def test_what_holds_no_numbers_is_a_type_error(cube, query, origins):
    with pytest.raises(TypeError):
        getattr(cube, query)(origins, DIRECTIONS[0])
    with pytest.raises(TypeError):
        getattr(cube, query)(ORIGINS, ORIGINS, tmax=origins)


def test_a_wrong_tmax_is_a_value_error(cube):
    for tmax in (np.ones(2), np.ones((3, 1)), np.ones((1, 3)), np.ones((3, 3)), []):
        with pytest.raises(ValueError, match="tmax"):
            cube.occluded(ORIGINS, DIRECTIONS, tmax=tmax)


def variants(array):
    """The same numbers as numpy may hold them."""
    array = np.ascontiguousarray(array)
    yield "float64", array.astype(np.float64)
    yield "float16", array.astype(np.float16)
    yield "longdouble", array.astype(np.longdouble)
    yield "list", array.tolist()
    yield "Fortran", np.asfortranarray(array)
    yield "byte-swapped", array.astype(array.dtype.newbyteorder())
    yield "strided", np.repeat(array, 3, axis=0)[::3]
    yield "columns", np.repeat(array, 2, axis=1)[:, ::2]
    yield "backwards", np.ascontiguousarray(array[::-1])[::-1]
    yield "part", np.pad(array, 2)[2:-2, 2:-2]
    unaligned = np.zeros(array.nbytes + 1, np.uint8)[1:].view(array.dtype).reshape(array.shape)
    unaligned[...] = array
    assert not unaligned.flags.aligned
    yield "unaligned", unaligned
    read_only = array.copy()
    read_only.flags.writeable = False
    yield "read-only", read_only
    yield "memoryview", memoryview(array)
    yield "subclass", array.view(type("Mine", (np.ndarray,), {}))
    yield "bytes", np.frombuffer(array.tobytes(), array.dtype).reshape(array.shape)


@pytest.mark.parametrize("part", ["rays", "vertices"])
def test_all_layouts_give_the_same_bits(part):
    rng = np.random.default_rng(4)
    exact = lambda shape: rng.integers(-48, 48, size=shape).astype(np.float32) / 16  # noqa: E731
    origins, directions, vertices = exact((500, 3)), exact((500, 3)), exact((60, 3))
    faces = np.arange(60).reshape(20, 3)
    scene = phalanx.Scene()
    scene.add_mesh(vertices, faces)
    wanted = scene.intersect(origins, directions)
    assert 100 < wanted.hit.sum() < 500
    given = variants(origins) if part == "rays" else variants(vertices)
    for name, array in given:
        if part == "vertices":
            scene = phalanx.Scene()
            scene.add_mesh(array, faces)
            array = origins
        for hits in (
            scene.intersect(array, directions),
            scene.intersect(np.concatenate([np.asarray(array), directions], axis=1)),
        ):
            for column in ("t", "u", "v", "prim_id"):
                assert getattr(hits, column).tobytes() == getattr(wanted, column).tobytes(), name
        assert hits.normal.tobytes() == wanted.normal.tobytes(), name


def test_broadcast_arrays_are_read_within_their_bounds(cube):
    one = np.float32([0.2, 0.1, 5])
    many = np.broadcast_to(one, (1000, 3))
    assert cube.occluded(many, np.broadcast_to(np.float32([0, 0, -1]), (1000, 3))).all()
    assert cube.intersect(many, [0, 0, -1], tmax=np.broadcast_to(9.0, (1000,))).hit.all()


@pytest.mark.parametrize("kind", ["u1", "i1", "u2", "i4", "u4", "i8", "u8", ">i4", ">u8"])
def test_faces_may_be_of_any_integers(kind):
    scene = phalanx.Scene()
    scene.add_mesh(CUBE_VERTICES, CUBE_FACES.astype(kind))
    scene.add_mesh(CUBE_VERTICES, np.asfortranarray(CUBE_FACES.astype(kind)))
    assert scene.count([[0.2, 0.1, 5]], [[0, 0, -1]])[0] == 4


@pytest.mark.parametrize(
    "vertices, faces, error",
    [
        (CUBE_VERTICES, [[0, 1, 8]], IndexError),
        (CUBE_VERTICES, [[0, 1, -1]], IndexError),
        (CUBE_VERTICES, [[0, 1, 2**31]], IndexError),
        (CUBE_VERTICES, [[0, 1, 2**32]], IndexError),
        (CUBE_VERTICES, [[0, 1, 2**32 + 1]], IndexError),
        (CUBE_VERTICES, [[0, 1, 2**63 - 1]], IndexError),
        (CUBE_VERTICES, np.uint64([[0, 1, 2**64 - 1]]), IndexError),
        (CUBE_VERTICES, [[0, 1, 2**70]], (TypeError, OverflowError)),
        (np.zeros((0, 3)), [[0, 0, 0]], IndexError),
        (CUBE_VERTICES, [[0, 1]], ValueError),
        (CUBE_VERTICES, [0, 1, 2], ValueError),
        (CUBE_VERTICES, [[0.0, 1.0, 2.0]], TypeError),
        (CUBE_VERTICES, [[True, False, True]], TypeError),
        (CUBE_VERTICES, None, TypeError),
        (CUBE_VERTICES[:, :2], CUBE_FACES, ValueError),
        (CUBE_VERTICES.ravel(), CUBE_FACES, ValueError),
        (np.where(CUBE_VERTICES > 0, np.nan, 0), CUBE_FACES, ValueError),
        (np.where(CUBE_VERTICES > 0, np.inf, 0), CUBE_FACES, ValueError),
        (CUBE_VERTICES * 1e39, CUBE_FACES, ValueError),
        (CUBE_VERTICES.astype(complex), CUBE_FACES, TypeError),
    ],
)
@pytest.mark.filterwarnings("ignore:overflow")
def test_a_bad_mesh_is_refused_and_leaves_the_scene_as_it_was(cube, vertices, faces, error):
    for add in (cube.add_mesh, cube.add_prototype):
        with pytest.raises(error):
            add(vertices, faces)
    assert len(cube) == 12
    assert cube.intersect(ORIGINS, DIRECTIONS).prim_id.tolist() == [10, 10, -1]
    assert cube.add_mesh(CUBE_VERTICES, CUBE_FACES) == 1


@pytest.mark.parametrize(
    "centers, radii, error",
    [
        ([[0, 0, 0]], 0.0, ValueError),
        ([[0, 0, 0]], -1.0, ValueError),
        ([[0, 0, 0]], np.nan, ValueError),
        ([[0, 0, 0]], np.inf, ValueError),
        ([[0, 0, 0]], [1.0, 2.0], ValueError),
        ([[0, 0, 0]], [[1.0]], ValueError),
        ([[0, 0, np.nan]], 1.0, ValueError),
        ([0, 0, 0], 1.0, ValueError),
        ([[0, 0, 0]], "large", TypeError),
    ],
)
def test_bad_spheres_are_refused(cube, centers, radii, error):
    with pytest.raises(error):
        cube.add_spheres(centers, radii)
    assert len(cube) == 12


@pytest.mark.parametrize(
    "transform, error",
    [
        (np.eye(3), ValueError),
        (np.zeros((4, 4)), ValueError),
        (np.diag([1.0, 1, 1, 2]), ValueError),
        (np.full((4, 4), np.nan), ValueError),
        (np.diag([1e-30, 1e-30, 1e-30, 1]), ValueError),
        (np.diag([np.inf, 1, 1, 1]), ValueError),
        ("left", TypeError),
    ],
)
def test_a_bad_transform_is_refused(cube, transform, error):
    prototype = cube.add_prototype(CUBE_VERTICES, CUBE_FACES)
    with pytest.raises(error):
        cube.add_instance(prototype, transform)
    for number, wanted in ((99, IndexError), (-1, OverflowError), (2**40, OverflowError)):
        with pytest.raises(wanted):
            cube.add_instance(number, np.eye(4))
    assert len(cube) == 12


def test_origins_of_a_scene_are_finite_numbers():
    for origin in ((np.nan, 0, 0), (np.inf, 0, 0)):
        with pytest.raises(ValueError):
            phalanx.Scene(origin=origin)
    with pytest.raises((TypeError, ValueError)):
        phalanx.Scene(origin=(1, 2))


def test_columns_may_be_written_and_outlive_their_scene():
    scene = phalanx.Scene()
    scene.add_mesh(CUBE_VERTICES, CUBE_FACES)
    origins, directions = rays_between(np.random.default_rng(5), 3000)
    hits, lists = scene.intersect(origins, directions), scene.all_hits(origins, directions)
    del scene
    hits.prim_id[:] = [2**31 - 1, -(2**31), 3000] * 1000
    hits.t[:] = np.nan
    lists.prim_id[:] = 2**31 - 1
    lists.starts[:] = -5
    lists.ray_id[:] = 2**62
    for refined in (hits.refine(), lists.refine()):
        assert np.isnan(refined[1]).all()
    assert (hits.normal == 0).all()
    repr((hits, lists))


def test_rays_that_change_their_shape_before_the_normals_are_asked_for(cube):
    rays = np.concatenate([ORIGINS, DIRECTIONS], axis=1)
    hits = cube.intersect(rays)
    rays.shape = (2, 9)
    with pytest.raises(ValueError):
        hits.normal  # noqa: B018


def test_queries_keep_no_references_to_arrays(cube):
    origins = ORIGINS.copy()
    before = sys.getrefcount(origins)
    for _ in range(10):
        cube.intersect(origins, DIRECTIONS).refine()
        cube.occluded(origins, DIRECTIONS)
        cube.all_hits(origins, DIRECTIONS).refine()
        with pytest.raises(ValueError):
            cube.count(origins, DIRECTIONS[:2])
    assert sys.getrefcount(origins) == before
