"""Cameras of pictures: points and vectors, or a matrix from the camera's coordinates."""

import numpy as np
import pytest

import phalanx

SIZE = (160, 120)


@pytest.fixture(scope="module")
def room():
    return phalanx.Scene.load("standard:room:5k")


def c2w_of(eye, at, up):
    """The matrix of OpenGL, Blender and NeRF: right, up, backward and position are its columns."""
    eye, at, up = (np.asarray(part, np.float64) for part in (eye, at, up))
    back = (eye - at) / np.linalg.norm(eye - at)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3] = np.stack([right, np.cross(back, right), back, eye], axis=1)
    return matrix


def inside(scene, rng):
    """A camera inside of a scene: from, at and up."""
    low, high = scene.bounds
    eye, at = low + rng.uniform(0.2, 0.8, (2, 3)) * (high - low)
    return eye, at, rng.normal(size=3)


def agree(scene, look_at, pose):
    """Whether two cameras see the same, but for pixels on edges."""
    kinds = ["primitive", "depth"]
    first, second = (scene.render(camera, SIZE, 1, aovs=kinds) for camera in (look_at, pose))
    same = first["primitive"] == second["primitive"]
    assert same.mean() > 0.99
    np.testing.assert_allclose(first["depth"][same], second["depth"][same], rtol=1e-3)
    return len(np.unique(first["primitive"]))


def test_a_matrix_is_the_camera_that_looks_at_a_point(room):
    rng = np.random.default_rng(1)
    seen = 0
    for k in range(12):
        eye, at, up = inside(room, rng)
        fov = 30.0 + 5 * k
        seen += agree(room, (eye, at, up, fov), (c2w_of(eye, at, up), fov))
    assert seen > 12 * 20


def test_the_camera_that_is_told_gives_the_same_bits(tmp_path):
    path = tmp_path / "a.obj"
    path.write_text("v 400000.1 7 2\nv 400001.3 7 2\nv 400000 8.2 2.5\nf 1 2 3\n")
    scene = phalanx.Scene.load(path)
    for size in (SIZE, (60, 200)):
        camera = scene.camera(size)
        assert len(camera) == 4
        picture = scene.render(size=size)
        assert picture.std() > 0
        np.testing.assert_array_equal(scene.render(camera, size), picture)
    parallel = (*camera, 3.5)
    assert not np.array_equal(scene.render(parallel, size), picture)


def test_a_headlight_replaces_the_lights_of_a_file(tmp_path):
    path = tmp_path / "a.test"
    path.write_text("size 40 30\ncamera 0 0 5 0 0 0 0 1 0 40\ndiffuse 1 1 1\nsphere 0 0 0 1\npoint 0 0 -9 1 1 1\n")
    dark = phalanx.Scene.load(path).render()
    scene = phalanx.Scene.load(path, headlight=True)
    behind = ((0, 0, -5), (0, 0, 0), (0, 1, 0), 40)
    for camera in (None, behind):
        assert scene.render(camera)[15, 20].min() > dark[15, 20].max() + 0.2


def test_an_exact_matrix_gives_the_same_bits(cube):
    look_at = ((0, 0, 5), (0, 0, 0), (0, 1, 0), 40)
    picture, depth = cube.render(look_at, SIZE), cube.depth(look_at, SIZE)
    pose = np.eye(4)
    pose[2, 3] = 5
    assert picture.max() > 0
    for same in (
        pose, pose[:3], pose.tolist(), pose.astype(np.float32), np.asfortranarray(pose),
        pose.astype(np.int64), pose @ np.diag([3.0, 2.0, 0.5, 1.0]), tuple(map(tuple, pose)),
    ):  # fmt: skip
        assert cube.render((same, 40), SIZE).tobytes() == picture.tobytes()
        assert cube.depth((same, 40), SIZE).tobytes() == depth.tobytes()
    opencv = pose @ np.diag([1, -1, -1, 1])
    opencv[:, 1:3] *= -1
    assert cube.render((opencv, 40), SIZE).tobytes() == picture.tobytes()


def test_points_and_vectors_may_be_arrays(cube):
    numbers = ((3, 4, 5), (0, 0.5, 0), (0, 1, 0))
    picture = cube.render((*numbers, 40), SIZE)
    for kind in (np.float32, np.float64):
        arrays = tuple(np.array(part, kind) for part in numbers)
        assert cube.render((*arrays, kind(40)), SIZE).tobytes() == picture.tobytes()


def test_a_matrix_is_in_the_coordinates_of_the_scene():
    rng = np.random.default_rng(2)
    vertices = rng.normal(size=(300, 3))
    faces = rng.integers(0, 300, (200, 3))
    for origin, unit in (((0, 0, 0), 1.0), ((528980.0, 183526.0, 40.0), 0.5), ((7, 8, 9), 100.0)):
        scene = phalanx.Scene(origin=origin)
        scene.add_mesh(vertices * unit + origin, faces)
        for _ in range(4):
            eye, at, up = origin + rng.normal(size=3) * 3 * unit, origin, rng.normal(size=3)
            agree(scene, (eye, at, up, 50.0), (c2w_of(eye, at, up), 50.0))


def test_rounded_matrices_are_taken(room):
    rng = np.random.default_rng(3)
    eye, at, up = inside(room, rng)
    for decimals in (3, 4, 6):
        room.render((np.round(c2w_of(eye, at, up), decimals), 50), (8, 8))


def bent(change):
    pose = c2w_of((3, 4, 5), (0, 0, 0), (0, 1, 0))
    change(pose)
    return pose


def with_entry(row, column, value):
    return bent(lambda pose: pose.__setitem__((row, column), value))


@pytest.mark.parametrize(
    "pose, error, words",
    [
        (np.eye(3), ValueError, r"c2w has the shape \(3, 3\), not \(4, 4\) or \(3, 4\)"),
        (np.eye(4)[0], ValueError, r"c2w has the shape \(4,\)"),
        (np.zeros((2, 3, 4)), ValueError, r"c2w has the shape \(2, 3, 4\)"),
        (np.eye(4).T[::-1], ValueError, "last row of c2w"),
        (bent(lambda pose: pose[3].fill(0)), ValueError, "last row of c2w"),
        (with_entry(0, 1, np.nan), ValueError, "not finite"),
        (with_entry(1, 3, np.inf), ValueError, "not finite"),
        (bent(lambda pose: pose[:3, 2].fill(0)), ValueError, "columns of c2w"),
        # A mirror, and what a wrong order of axes makes of a matrix.
        (np.eye(4) @ np.diag([-1, 1, 1, 1]), ValueError, "columns of c2w"),
        (np.eye(4)[:, [0, 2, 1, 3]], ValueError, "columns of c2w"),
        (bent(lambda pose: pose[:3, 0].__iadd__(0.01 * pose[:3, 1])), ValueError, "columns of c2w"),
        (bent(lambda pose: pose[:3, 1].__iadd__(0.01 * pose[:3, 2])), ValueError, "columns of c2w"),
        (bent(lambda pose: pose[:3, 2].__iadd__(0.01 * pose[:3, 0])), ValueError, "columns of c2w"),
        (np.eye(4) * 1j, TypeError, "c2w holds complex128"),
        ("north", TypeError, "c2w"),
        (None, TypeError, "c2w"),
    ],
)
def test_other_matrices_are_refused(cube, pose, error, words):
    for picture in (cube.render, cube.depth):
        with pytest.raises(error, match=words):
            picture((pose, 40), SIZE)


@pytest.mark.parametrize("fov", [0, -1, 180, np.nan, np.inf])
def test_other_angles_are_refused(cube, fov):
    with pytest.raises(ValueError, match="camera"):
        cube.render((np.eye(4), fov), SIZE)


@pytest.mark.parametrize("camera", [np.eye(4), (np.eye(4),), (1, 2, 3), [np.eye(4), 40], 7, "front"])
def test_other_cameras_are_refused(cube, camera):
    with pytest.raises(TypeError, match=r"\(from, at, up, fov\) \| .* \| \(c2w, fov\)"):
        cube.render(camera, SIZE)
