#!/usr/bin/env python3
"""Times of Embree's scenes where things move, come and go: what the binary `edits` of this folder measures of phalanx.

    python perf/calls/embree_edits.py MESH LIBRARY [THREADS]

Medians of milliseconds of all threads' CPU time, of ten thousand instances of which some move, and of a scene of the mesh beside
which a sphere, a mesh and an instance come and go: in a DYNAMIC scene of LOW quality, which has a tree for each geometry and one
over them, and in one of MEDIUM quality. Needs numpy and trimesh; LIBRARY is Embree 4's, such as the one in embreex.libs.
"""

import ctypes
import statistics
import sys
import time

import numpy as np
import trimesh

ROUNDS, INSTANCES = 15, 10_000
TRIANGLES, SPHERES, INSTANCE = 0, 50, 121
INDEX, VERTEX = 0, 1
UINT3, FLOAT3, FLOAT4, FLOAT3X4 = 0x5003, 0x9003, 0x9004, 0x9234
DYNAMIC, LOW, MEDIUM = 1, 0, 1


def patch(side, x=0.0, y=0.0, z=0.0, n=23):
    """A wavy grid of 1,058 triangles over a square of this side."""
    u, v = np.mgrid[: n + 1, : n + 1].reshape(2, -1) / n * side
    wave = np.sin(u / side * 9) * np.cos(v / side * 7) * side * 0.1
    k = (np.mgrid[:n, :n] * [[[n + 1]], [[1]]]).sum(axis=0).reshape(-1)
    faces = [np.stack([k, k + 1, k + n + 1], 1), np.stack([k + 1, k + n + 2, k + n + 1], 1)]
    return np.stack([x + u, y + v, z + wave], 1), np.concatenate(faces)


class Embree:
    def __init__(self, path, threads):
        self.rtc = ctypes.CDLL(path)
        for name in "NewDevice NewScene NewGeometry SetNewGeometryBuffer".split():
            getattr(self.rtc, "rtc" + name).restype = ctypes.c_void_p
        self.device = self.rtc.rtcNewDevice(f"threads={threads}".encode())

    def call(self, name, *given):
        address = lambda x: ctypes.c_void_p(x) if isinstance(x, int) and x > 1 << 16 else x
        return getattr(self.rtc, "rtc" + name)(*map(address, given))

    def scene(self, quality):
        scene = self.call("NewScene", self.device)
        self.call("SetSceneFlags", scene, DYNAMIC)
        self.call("SetSceneBuildQuality", scene, quality)
        return scene

    def fill(self, geometry, kind, form, values):
        size = [ctypes.c_size_t(n) for n in (4 * values.shape[1], len(values))]
        at = self.rtc.rtcSetNewGeometryBuffer(ctypes.c_void_p(geometry), kind, 0, form, *size)
        number = ctypes.c_uint32 if form == UINT3 else ctypes.c_float
        np.ctypeslib.as_array(ctypes.cast(at, ctypes.POINTER(number)), shape=values.shape)[:] = values

    def mesh(self, vertices, faces):
        geometry = self.call("NewGeometry", self.device, TRIANGLES)
        self.fill(geometry, INDEX, UINT3, np.uint32(faces))
        self.fill(geometry, VERTEX, FLOAT3, np.float32(vertices))
        return geometry

    def sphere(self, center, radius):
        geometry = self.call("NewGeometry", self.device, SPHERES)
        self.fill(geometry, VERTEX, FLOAT4, np.float32([[*center, radius]]))
        return geometry

    def attach(self, scene, geometry):
        self.call("CommitGeometry", geometry)
        return self.call("AttachGeometry", scene, geometry)

    def place(self, instance, x, y, z):
        columns = np.float32(np.vstack([np.eye(3), [x, y, z]]))
        at = columns.ctypes.data_as(ctypes.c_void_p)
        self.call("SetGeometryTransform", instance, 0, FLOAT3X4, at)
        self.call("CommitGeometry", instance)

    def instance(self, scene, of):
        geometry = self.call("NewGeometry", self.device, INSTANCE)
        self.call("SetGeometryInstancedScene", geometry, of)
        self.place(geometry, 0, 0, 0)
        self.attach(scene, geometry)
        return geometry


def cpu(work):
    start = time.process_time()
    work()
    return (time.process_time() - start) * 1e3


def main():
    mesh = trimesh.load(sys.argv[1], force="mesh", process=False)
    embree = Embree(sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 0)
    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    print(f"{sys.argv[1]}, {len(mesh.faces)} triangles")
    for name, quality in ("LOW", LOW), ("MEDIUM", MEDIUM):
        small = embree.scene(MEDIUM)
        embree.attach(small, embree.mesh(*patch(1.0)))
        embree.call("CommitScene", small)
        scene = embree.scene(quality)
        placed = [embree.instance(scene, small) for _ in range(INSTANCES)]
        for k, one in enumerate(placed):
            embree.place(one, k % 100, k // 100, 0)
        embree.call("CommitScene", scene)
        for moved in 1, 100, INSTANCES:
            times = []
            for step in range(ROUNDS):
                chosen = range(0, INSTANCES, INSTANCES // moved)
                # The transforms are set outside of the measure, as phalanx's are.
                for k in chosen:
                    embree.place(placed[k], k % 100, k // 100, step * k % 7)
                times.append(cpu(lambda: embree.call("CommitScene", scene)))
            print(f"{name}: {INSTANCES} instances, {moved} move: {statistics.median(times):.2f}")

        scene = embree.scene(quality)
        embree.attach(scene, embree.mesh(mesh.vertices, mesh.faces))
        build = cpu(lambda: embree.call("CommitScene", scene))
        rows = {"build": [build]}
        for step in range(ROUNDS):
            come = {
                "a sphere comes": lambda: embree.sphere((0, 0, size * 0.05 * step), size * 0.05),
                "a mesh comes": lambda: embree.mesh(*patch(size * 0.1, size * 0.1 * step, 0, size)),
            }
            numbers = []
            for words, make in come.items():
                geometry = make()

                def add():
                    numbers.append(embree.attach(scene, geometry))
                    embree.call("CommitScene", scene)

                rows.setdefault(words, []).append(cpu(add))

            def add_instance():
                embree.instance(scene, small)
                embree.call("CommitScene", scene)

            rows.setdefault("an instance comes", []).append(cpu(add_instance))

            def remove():
                for number in numbers:
                    embree.call("DetachGeometry", scene, number)
                embree.call("CommitScene", scene)

            rows.setdefault("two geometries go", []).append(cpu(remove))
        for words, times in rows.items():
            print(f"{name}: {words}: {statistics.median(times):.2f}")


main()
