"""Rates of a scene's rays as a dictionary, the record that `phalanx bench` makes."""

import json
import subprocess

import pytest

import phalanx


@pytest.fixture(scope="module")
def record():
    scene = phalanx.Scene.load("standard:room:5k")
    return scene.bench(["primary", "shadow"], size=(64, 48), threads=1, repeat=2, name="a room")


def test_rates_are_those_of_each_kind_of_rays(record):
    ours = [row for row in record["rows"] if row["engine"] == "phalanx"]
    assert {row["rays"] for row in ours} == {"primary", "shadow"}
    assert "auto" in {row["kernel"] for row in ours}
    for row in ours:
        rate = row["mrays_per_s"]
        assert 0 < rate["low"] <= rate["median"] <= rate["high"]
        assert row["threads"] == 1
    assert record["program"]["isa_compiled"] == phalanx.isa()
    assert [scene["name"] for scene in record["scenes"]] == ["a room"]


def test_the_program_reads_the_record(record, program, tmp_path):
    path = tmp_path / "room.json"
    path.write_text(json.dumps(record))
    arguments = [program, "bench", "compare", path, path]
    done = subprocess.run(arguments, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "a room" in done.stdout or "1 scene" in done.stdout, done.stdout


def test_the_camera_decides_on_the_rays():
    scene = phalanx.Scene()
    scene.add_spheres([[0, 0, 0]], 1)
    hits = [
        scene.bench(["primary"], ((0, 0, z), (0, 0, 0), (0, 1, 0), 40), (32, 32), 1, 1)["rows"][0]
        for z in (3, 30)
    ]
    assert hits[0]["hits"] > 10 * hits[1]["hits"] > 0


def test_what_cannot_be_measured_is_refused():
    scene = phalanx.Scene()
    scene.add_spheres([[0, 0, 0]], 1)
    with pytest.raises(ValueError, match="primary, shadow"):
        scene.bench(["sideways"])
    with pytest.raises(ValueError):
        scene.bench(size=(0, 4))
    with pytest.raises(ValueError, match="pixels"):
        scene.bench(size=(65536, 65536))
    with pytest.raises(ValueError):
        scene.bench(threads=-1)
    assert scene.bench([])["rows"] == []
