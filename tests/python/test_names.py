"""Names of objects, materials and cameras."""

import json
import pickle
import struct
import base64

import numpy as np
import phalanx
import pytest

CORNERS = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]], np.float32)


def test_names_of_a_file(tmp_path):
    path = tmp_path / "a.obj"
    path.write_text(
        "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 4 4 0\no cup\nusemtl red\nf 1 2 3\nusemtl blue\nf 2 4 3\no lid\nf 1 2 4\n"
    )
    with pytest.warns(UserWarning):
        scene = phalanx.Scene.load(path)
    hits = scene.intersect([[0.5, 0.5, 5], [3.9, 3, 5], [9, 9, 5]], [0, 0, -1])
    assert scene.prim_names(hits.prim_id) == [("cup", "red"), ("cup", "blue"), (None, None)]
    assert scene.prim_names(2) == [("lid", "blue")]
    assert scene.prim_names([[-5, 99]]) == [(None, None)] * 2
    objects, materials = scene.names
    assert list(objects.items()) == [("cup", 2), ("lid", 1)]
    assert list(materials.items()) == [("blue", 2), ("red", 1)]
    assert pickle.loads(pickle.dumps(scene)).names == scene.names
    with pytest.raises(TypeError):
        scene.prim_names(["x"])


def test_names_given():
    scene = phalanx.Scene()
    sail = scene.add_mesh(CORNERS, [[0, 1, 2]])
    leaf = scene.add_prototype(CORNERS, [[0, 1, 2]])
    left = scene.add_instance(leaf, np.eye(4))
    hits = scene.intersect([[1, 1, 5]], [0, 0, -1])
    scene.set_name(sail, "s\N{LATIN SMALL LETTER A WITH DIAERESIS}il")
    scene.set_name(left, "leaf")
    assert scene.prim_names([0, 1, 2]) == [("s\xe4il", None), (None, None), ("leaf", None)]
    assert hits.prim_id[0] == 0 and scene.intersect([[1, 1, 5]], [0, 0, -1]).prim_id[0] == 0
    scene.set_name(sail, "")
    assert scene.prim_names(0) == [(None, None)]
    with pytest.raises(IndexError):
        scene.set_name(7, "x")


def test_cameras(tmp_path):
    data = base64.b64encode(struct.pack("<9f", *CORNERS.ravel())).decode()
    lens = [{"type": "perspective", "perspective": {"yfov": fov, "znear": 1}} for fov in (0.8, 0.4)]
    path = tmp_path / "a.gltf"
    document = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}, {"camera": 0, "name": "A", "translation": [1, 1, 9]}, {"camera": 1, "translation": [1, 1, 9]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "cameras": lens,
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:;base64," + data}],
    }
    path.write_text(json.dumps(document))
    first, second = (phalanx.Scene.load(path, camera=camera) for camera in ("A", 1))
    assert first.cameras == ["A", None]
    covered = [np.isfinite(scene.depth(size=(40, 30))).sum() for scene in (first, second)]
    assert covered[1] > 2 * covered[0] > 0
    with pytest.raises(ValueError, match="no camera is called `B`"):
        phalanx.Scene.load(path, camera="B")
