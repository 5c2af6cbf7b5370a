"""Environments: what they may be set to, and what rays see of them."""

import numpy as np
import pytest

import phalanx

SIZE = (8, 6)
AHEAD = ([0, 0, 0], [1, 0, 0], [0, 1, 0], 20)


@pytest.fixture
def alone():
    """A scene with nothing in the way."""
    scene = phalanx.Scene()
    scene.add_spheres([[0, 0, 1000]], [1])
    return scene


def test_a_colour_is_behind_everything(alone):
    assert alone.environment is None
    alone.environment = (0.25, 0.5, 2)
    assert np.array_equal(alone.environment, [[0.25, 0.5, 2]] * 2)
    assert np.all(alone.render(AHEAD, SIZE) == np.float32([0.25, 0.5, 2]))
    alone.environment = None
    assert alone.environment is None
    assert np.all(alone.render(AHEAD, SIZE) == 0)


def test_an_array_is_a_picture_of_all_directions(alone):
    texels = np.zeros((4, 8, 3), np.float32)
    texels[:, 4] = texels[:, 3] = (0, 1, 0)
    texels[:, 1] = texels[:, 2] = (1, 0, 0)
    alone.environment = texels
    assert np.array_equal(alone.environment, texels)
    # Its middle is to the right, along x, and a quarter of a turn brings there what was behind.
    assert np.all(alone.render(AHEAD, SIZE) == [0, 1, 0])
    alone.environment_turn = -90
    assert alone.environment_turn == -90
    assert np.allclose(alone.render(AHEAD, (1, 1)), [1, 0, 0], atol=1e-6)


def test_files_and_the_sky(alone, tmp_path, program):
    texels = np.random.default_rng(1).random((8, 16, 3), np.float32)
    file = tmp_path / "a.pfm"
    file.write_bytes(b"PF\n16 8\n-1.0\n" + texels[::-1].astype("<f4").tobytes())
    alone.environment = file
    assert np.array_equal(alone.environment, texels)
    alone.environment = str(file)
    assert np.array_equal(alone.environment, texels)
    alone.environment = "sky"
    above, below = alone.environment
    assert above.min() > below.max()


def test_a_saved_scene_keeps_it(alone, tmp_path):
    alone.environment = np.full((2, 4, 3), 0.1)
    alone.environment_turn = 30
    picture = alone.render(AHEAD, SIZE)
    alone.save(tmp_path / "a.phx")
    again = phalanx.Scene.open(tmp_path / "a.phx")
    assert again.environment_turn == 30
    assert np.array_equal(again.environment, alone.environment)
    assert np.array_equal(again.render(AHEAD, SIZE), picture)


@pytest.mark.parametrize(
    "value, error, words",
    [
        (np.zeros((4, 8)), ValueError, r"\(height, width, 3\)"),
        (np.zeros((0, 8, 3)), ValueError, "1 to 16384"),
        (np.full((2, 4, 3), np.nan), ValueError, "finite"),
        (np.full((2, 4, 3), -1.0), ValueError, "below zero"),
        ((1, 2, -3), ValueError, "below zero"),
        ("no/such.hdr", OSError, "such.hdr"),
        (np.zeros((2, 4, 3), complex), TypeError, "complex"),
    ],
)
def test_others_are_refused(alone, value, error, words):
    alone.environment = (1, 1, 1)
    with pytest.raises(error, match=words):
        alone.environment = value
    assert np.array_equal(alone.environment, np.ones((2, 3)))


def test_turns_need_an_environment_and_a_number(alone):
    with pytest.raises(ValueError, match="no environment"):
        alone.environment_turn = 3
    alone.environment = "sky"
    with pytest.raises(ValueError, match="finite"):
        alone.environment_turn = np.inf
