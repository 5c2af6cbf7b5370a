"""Each script of examples/python runs as its users run it, and tells the truth."""

import importlib.util
import os
import re
import subprocess
import sys
import zlib

import numpy as np
import pytest
from conftest import ROOT

EXAMPLES = ROOT / "examples" / "python"


def run(name, *arguments, code=0):
    command = [sys.executable, str(EXAMPLES / name), *map(str, arguments)]
    settings = {**os.environ, "MPLBACKEND": "Agg"}
    done = subprocess.run(command, capture_output=True, text=True, env=settings)
    assert done.returncode == code, done.stderr
    return done.stdout


def example(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_examples_are_short_and_say_what_they_are():
    scripts = sorted(EXAMPLES.glob("*.py"))
    assert len(scripts) == 5
    for script in scripts:
        text = script.read_text(encoding="utf-8")
        # The longest one builds a street and draws it.
        lines = 180 if script.stem == "moving_lidar" else 60
        assert text.startswith('"""') and text.count("\n") <= lines, script


def test_ambient_occlusion_before_a_wall_is_that_of_the_books():
    # An endless wall of height h hides (1 - d / √(d² + h²)) / 2 of the sky at a distance of d.
    module = example("ambient_occlusion")
    wall = np.array([[0, -900, 9], [0, 900, 9], [0, 900, 0], [0, -900, 0]])
    faces = [[0, 2, 1], [0, 3, 2]]
    for d in (0.02, 3.0, 9.0, 40.0):
        ground = np.array([[d, 0, 0], [d + 0.01, 0, 0], [d, 0.01, 0]])
        free = module.ambient_occlusion(
            np.concatenate([wall, ground]), np.array([*faces, [4, 5, 6]]), rays=4096
        )
        assert free[4:] == pytest.approx([0.5 + 0.5 * d / np.hypot(d, 9)] * 3, abs=0.01), d
    assert "free sky" in run("ambient_occlusion.py", "--rays", 16)


def test_ambient_occlusion_draws(tmp_path):
    pytest.importorskip("matplotlib")
    run("ambient_occlusion.py", "--rays", 16, "--out", tmp_path / "picture.png")
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")


def test_view_factors_of_a_cube_are_those_of_the_books():
    module = example("view_factors")
    areas, factors = module.view_factors(module.box((0, 0, 0), (1, 1, 1), True), 200_000)
    assert areas == pytest.approx([1] * 6)
    # 0.1998 between opposite sides of a cube, 0.2000 between neighbours.
    wanted = np.full((6, 6), 0.20004)
    for side in range(6):
        wanted[side, [side, side ^ 1]] = 0, 0.19982
    np.testing.assert_allclose(factors, wanted, atol=0.004)
    out = run("view_factors.py", "--samples", 200_000)
    sums = [line.split()[-1] for line in out.splitlines()[1:8]]
    assert sums == ["1.0000"] * 7
    assert float(re.search(r"reciprocity: ([\d.]+)", out)[1]) < 0.1


def test_a_scan_has_the_points_of_a_ball():
    pytest.importorskip("matplotlib")
    import phalanx

    scene = phalanx.Scene()
    scene.add_spheres([[0, 0, 0]], 50.0)
    points = example("lidar").scan(scene, (0.0, 1.0, 0.0), up=1)
    assert len(points) == 64 * 1800
    off = np.linalg.norm(points, axis=1) - 50.0
    assert abs(off).max() < 0.15 and 0.018 < off.std() < 0.022


def test_lidar_draws(tmp_path):
    pytest.importorskip("matplotlib")
    picture = tmp_path / "picture.png"
    points = int(run("lidar.py", "--out", picture).split()[0])
    assert points > 50_000 and picture.read_bytes().startswith(b"\x89PNG")


def test_a_moving_lidar_sees_cars_where_they_are():
    module = example("moving_lidar")
    scene, cars = module.street(2.0)
    points, ids, times = module.sweep(scene, cars, 3.0)
    seen, left_behind = set(), 0
    for number, geom_id in enumerate(cars):
        corners, _ = module.mesh(module.car(module.MODELS[number % 3]))
        low, high = corners.min(axis=0) - 1e-3, corners.max(axis=0) + 1e-3

        def inside(points, seconds):
            matrix = module.pose(number, seconds)
            local = (points - matrix[:3, 3]) @ matrix[:3, :3]
            return ((local > low) & (local < high)).all(axis=1)

        for seconds in np.unique(times[ids == geom_id]):
            now = points[(ids == geom_id) & (times == seconds)]
            assert inside(now, seconds).all(), (number, seconds)
            seen.add(number)
            left_behind += np.count_nonzero(~inside(now, 3.0))
    assert 0 not in seen and len(seen) > 15 and left_behind > 50


def test_a_moving_lidar_hits_its_own_car_but_for_the_mask():
    module = example("moving_lidar")
    scene, cars = module.street()
    around = np.linspace(0, 2 * np.pi, 256)
    assert cars[0] not in module.fire(scene, 0.0, around)[1]
    scene.set_mask(cars[0], module.OWN | module.OTHERS)
    assert cars[0] in module.fire(scene, 0.0, around)[1]


def test_a_street_that_moved_equals_a_new_one():
    module = example("moving_lidar")
    scene, cars = module.street()
    around = np.linspace(0, 2 * np.pi, 256)
    before, _ = module.fire(scene, 0.0, around)
    for seconds in (1.5, 20.0, 3.25):
        module.move(scene, cars, seconds)
        new, new_cars = module.street(seconds)
        assert cars == new_cars
        for moved, wanted in zip(
            module.fire(scene, seconds, around), module.fire(new, seconds, around)
        ):
            np.testing.assert_array_equal(moved, wanted)
    assert len(before) > 10_000


def test_a_moving_lidar_draws(tmp_path):
    picture = tmp_path / "picture.png"
    out = run("moving_lidar.py", "--sweeps", 2, "--picture", picture)
    assert int(out.split()[0].replace(",", "")) > 50_000
    file = picture.read_bytes()
    assert file.startswith(b"\x89PNG") and file[16:24] == bytes([0, 0, 4, 176, 0, 0, 2, 163])
    pixels = zlib.decompress(file[file.index(b"IDAT") + 4 : -16])
    bright = np.frombuffer(pixels, np.uint8).reshape(675, 3601)[:, 1:].max(axis=0) > 128
    assert bright.mean() > 0.5


def test_same_bits_finds_a_difference(tmp_path):
    here = tmp_path / "here.txt"
    here.write_text(run("same_bits.py", "--rays", 30_000))
    assert here.read_text().count("\n") == 24
    assert run("same_bits.py", "--rays", 30_000, "--threads", 1, "--check", here)
    lines = here.read_text().splitlines()
    lines[3] = lines[3][:-1] + "x"
    here.write_text("\n".join(lines))
    run("same_bits.py", "--rays", 30_000, "--check", here, code=1)
