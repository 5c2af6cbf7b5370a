#!/usr/bin/env python3
"""Times of Embree's trees that follow a moving mesh: its refit, and its rebuild over instances.

    python perf/calls/embree_moving.py MESH LIBRARY [THREADS]

Beside the binary `moving` of this folder, which does the same with phalanx. Needs numpy and
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
DYNAMIC, MEDIUM, REFIT = 1, 1, 3


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
    start = time.perf_counter()
    work()
    return (time.perf_counter() - start) * 1e3


def main():
    mesh = trimesh.load(sys.argv[1], force="mesh", process=False)
    vertices, faces = np.float32(mesh.vertices), np.uint32(mesh.faces)
    threads = int(sys.argv[3]) if len(sys.argv) > 3 else 0
    rtc = library(sys.argv[2])
    device = rtc.rtcNewDevice(f"threads={threads}".encode())
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))

    def scene_of(quality):
        scene = rtc.rtcNewScene(pointer(device))
        rtc.rtcSetSceneFlags(pointer(scene), DYNAMIC if quality == REFIT else 0)
        rtc.rtcSetSceneBuildQuality(pointer(scene), MEDIUM)
        geometry = rtc.rtcNewGeometry(pointer(device), TRIANGLES)
        rtc.rtcSetGeometryBuildQuality(pointer(geometry), quality)
        filled(rtc, geometry, INDEX, UINT3, faces)
        array = filled(rtc, geometry, VERTEX, FLOAT3, vertices)
        rtc.rtcCommitGeometry(pointer(geometry))
        rtc.rtcAttachGeometry(pointer(scene), pointer(geometry))
        return scene, geometry, array

    builds = []
    for _ in range(5):
        scene, _, _ = scene_of(MEDIUM)
        builds.append(milliseconds(lambda: rtc.rtcCommitScene(pointer(scene))))
    build = statistics.median(builds)

    scene, geometry, array = scene_of(REFIT)
    rtc.rtcCommitScene(pointer(scene))

    def refit():
        rtc.rtcUpdateGeometryBuffer(pointer(geometry), VERTEX, 0)
        rtc.rtcCommitGeometry(pointer(geometry))
        rtc.rtcCommitScene(pointer(scene))

    refits = []
    for k in range(ROUNDS):
        array[:, 1] += size * 0.002 * np.sin(k) * np.sin(array[:, 0] / size * 20)
        refits.append(milliseconds(refit))

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
    refit_ms = statistics.median(refits)
    print(f"{sys.argv[1]}, {len(faces)} triangles, {threads} threads")
    print(f"build {build:8.2f} ms, refit {refit_ms:8.2f}, refit / build {refit_ms / build:.3f}")
    print(f"{INSTANCES} instances moved {statistics.median(moves[1:]):8.3f} ms")


main()
