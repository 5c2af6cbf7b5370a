"""Answers are those of the program's oracle, to the bit: `phalanx bench --dump-rays`."""

import struct
import subprocess

import numpy as np
import pytest

import phalanx

NONE = 0xFFFFFFFF


def sets_of(path):
    """The origin of a dump, and its sets: (kind, is occlusion, tmax, rays, results, t)."""
    data = path.read_bytes()
    assert data[:8] == b"PHXRAYS2"
    origin = np.frombuffer(data, "<f8", 3, 8)
    (count,) = struct.unpack_from("<I", data, 32)
    at, sets = 36, []
    for _ in range(count):
        kind, query, tmax, n = struct.unpack_from("<16sIfQ", data, at)
        at += 32
        rays = np.frombuffer(data, "<f4", 6 * n, at).reshape(n, 6)
        results = np.frombuffer(data, "<u4", n, at + 24 * n)
        t = np.frombuffer(data, "<f4", n, at + 28 * n)
        at += 32 * n
        sets.append((kind.rstrip(b"\0").decode(), query == 1, tmax, rays, results, t))
    assert at == len(data)
    return origin, sets


@pytest.mark.parametrize("name", ["room:5k", "street:50k", "balls", "terrain:5k"])
def test_answers_are_those_of_the_program_to_the_bit(program, tmp_path, name):
    path = tmp_path / "rays"
    command = [program, "bench", f"standard:{name}", "--dump-rays", path, "--size", "96x96"]
    subprocess.run(command, check=True, capture_output=True)
    origin, sets = sets_of(path)
    assert (origin == 0).all() and len(sets) >= 3
    scene = phalanx.Scene.load(f"standard:{name}")
    met = 0
    for kind, is_occlusion, tmax, rays, results, t in sets:
        if is_occlusion:
            found = scene.occluded(rays, tmax=tmax)
            np.testing.assert_array_equal(found, results == 1, err_msg=kind)
            met += found.sum()
            continue
        hits = scene.intersect(rays, tmax=tmax)
        np.testing.assert_array_equal(hits.prim_id.view(np.uint32), results, err_msg=kind)
        found = np.where(hits.hit, hits.t, np.float32(0))
        assert found.tobytes() == t.tobytes(), kind
        met += hits.hit.sum()
        # The dump has no u and v: the first of all hits, which another kernel finds, has the same.
        lists = scene.all_hits(rays[hits.hit], tmax=tmax)
        heads = lists.starts[:-1]
        for column in ("t", "u", "v", "prim_id"):
            first = getattr(lists, column)[heads]
            assert first.tobytes() == getattr(hits, column)[hits.hit].tobytes(), (kind, column)
    assert met > 5000
