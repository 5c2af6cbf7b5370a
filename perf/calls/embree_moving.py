#!/usr/bin/env python3
"""Times of Embree's trees that follow a moving mesh: its refit, and its rebuild over instances.

    python perf/calls/embree_moving.py MESH LIBRARY [THREADS]

Embree takes a geometry's build quality, REFIT among them, only from scenes of LOW quality: in others it builds anew. Such a
scene has two levels, a tree for each geometry and one over them. Times are of the clock and of all threads' CPU time. Beside the binary `moving` of this folder, which does the same with phalanx. Needs numpy and
trimesh; LIBRARY is Embree 4's, such as the one in embreex.libs.
"""

import ctypes
import statistics
import sys
import time

import numpy as np
import trimesh

ROUNDS, INSTANCES = 15, 1000
TRIANGLES, INSTANCE = 0, 121
INDEX, VERTEX = 0, 1
UINT3, FLOAT3, FLOAT3X4 = 0x5003, 0x9003, 0x9234
DYNAMIC, LOW, MEDIUM, REFIT = 1, 0, 1, 3


def library(path):
    rtc = ctypes.CDLL(path)
    pointers = "NewDevice NewScene NewGeometry SetNewGeometryBuffer"
    for name in pointers.split():
        getattr(rtc, "rtc" + name).restype = ctypes.c_void_p
    return rtc


def pointer(address):
    return ctypes.c_void_p(address)


def filled(rtc, geometry, kind, form, values):
    """The buffer of a geometry, as an array that holds these values."""
    size = [ctypes.c_size_t(n) for n in (4 * values.shape[1], len(values))]
    at = rtc.rtcSetNewGeometryBuffer(pointer(geometry), kind, 0, form, *size)
    number = ctypes.c_uint32 if form == UINT3 else ctypes.c_float
    array = np.ctypeslib.as_array(ctypes.cast(at, ctypes.POINTER(number)), shape=values.shape)
    array[:] = values
    return array


def milliseconds(work):
    """Milliseconds of the clock, and of CPU time."""
    start = time.perf_counter(), time.process_time()
    work()
    end = time.perf_counter(), time.process_time()
    return [(b - a) * 1e3 for a, b in zip(start, end)]


def shown(times):
    wall, cpu = map(statistics.median, zip(*times))
    return f"{wall:8.2f} ms (CPU {cpu:.2f})"


def main():
    mesh = trimesh.load(sys.argv[1], force="mesh", process=False)
    vertices, faces = np.float32(mesh.vertices), np.uint32(mesh.faces)
    threads = int(sys.argv[3]) if len(sys.argv) > 3 else 0
    rtc = library(sys.argv[2])
    device = rtc.rtcNewDevice(f"threads={threads}".encode())
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))

    def scene_of(scene_quality, quality):
        scene = rtc.rtcNewScene(pointer(device))
        rtc.rtcSetSceneFlags(pointer(scene), 0 if scene_quality == MEDIUM else DYNAMIC)
        rtc.rtcSetSceneBuildQuality(pointer(scene), scene_quality)
        geometry = rtc.rtcNewGeometry(pointer(device), TRIANGLES)
        rtc.rtcSetGeometryBuildQuality(pointer(geometry), quality)
        filled(rtc, geometry, INDEX, UINT3, faces)
        array = filled(rtc, geometry, VERTEX, FLOAT3, vertices)
        rtc.rtcCommitGeometry(pointer(geometry))
        rtc.rtcAttachGeometry(pointer(scene), pointer(geometry))
        return scene, geometry, array

    print(f"{sys.argv[1]}, {len(faces)} triangles, {threads} threads")
    for name, *qualities in [("MEDIUM", MEDIUM, MEDIUM), ("LOW, geometry REFIT", LOW, REFIT)]:
        builds = []
        for _ in range(5):
            scene, geometry, array = scene_of(*qualities)
            builds.append(milliseconds(lambda: rtc.rtcCommitScene(pointer(scene))))
        print(f"build {name}: {shown(builds)}")

    def refit():
        rtc.rtcUpdateGeometryBuffer(pointer(geometry), VERTEX, 0)
        rtc.rtcCommitGeometry(pointer(geometry))
        rtc.rtcCommitScene(pointer(scene))

    refits = []
    for k in range(ROUNDS):
        array[:, 1] += size * 0.002 * np.sin(k) * np.sin(array[:, 0] / size * 20)
        refits.append(milliseconds(refit))
    print(f"refit {shown(refits)}")

    top = rtc.rtcNewScene(pointer(device))
    rtc.rtcSetSceneFlags(pointer(top), DYNAMIC)
    placed = []
    for _ in range(INSTANCES):
        instance = rtc.rtcNewGeometry(pointer(device), INSTANCE)
        rtc.rtcSetGeometryInstancedScene(pointer(instance), pointer(scene))
        rtc.rtcAttachGeometry(pointer(top), pointer(instance))
        placed.append(instance)

    def place(k, round):
        at = np.array([k % 32, k // 32, 0.1 * (round * k % 7)]) * size * 1.2
        columns = np.float32(np.vstack([np.eye(3), at]))
        rtc.rtcSetGeometryTransform(pointer(placed[k]), 0, FLOAT3X4, columns.ctypes.data_as(ctypes.c_void_p))

    moves = []
    for round in range(ROUNDS + 1):
        for k in range(INSTANCES):
            place(k, round)

        def commit():
            for instance in placed:
                rtc.rtcCommitGeometry(pointer(instance))
            rtc.rtcCommitScene(pointer(top))

        moves.append(milliseconds(commit))
    print(f"{INSTANCES} instances moved {shown(moves[1:])}")


main()
