#!/usr/bin/env python3
"""Rays per second from Python: phalanx, embreex, trimesh and Open3D on the same arrays.

    python perf/python_speed.py MESH [--threads 1 2] [--rounds 15] [--json FILE]

Needs numpy and trimesh, and measures beside whichever of embreex and Open3D is installed. A call is
timed as a program makes it: numpy arrays in, numpy arrays out. Tracers take turns, a call each, and
each thread count has a process of its own that is kept to as many CPUs, because Open3D takes all it
sees. embreex has one thread. The table is in perf/notes/python.md.

A million rays, float32, in each of three sets:
  primary  a camera's that looks at the whole mesh, row of pixels by row of pixels
  diffuse  from where those hit, in the order of a list of pixels, into the hemisphere by the cosine
  random   between two random points of the mesh's box
All are asked for their closest hits; the random ones, in a fifth as many rounds, also for the
number of their hits and for all of them.
"""

import argparse
import datetime
import importlib.metadata
import json
import os
import platform
import statistics
import subprocess
import sys
import time

SIDE = 1000


def load(path):
    import numpy as np
    import trimesh

    mesh = trimesh.load(path, force="mesh", process=False)
    vertices = np.ascontiguousarray(mesh.vertices, dtype=np.float32)
    return mesh, vertices, np.ascontiguousarray(mesh.faces, dtype=np.int64)


def unit(vectors):
    import numpy as np

    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def ray_sets(scene, vertices):
    """The rays of each set, (origins, directions)."""
    import numpy as np

    rng = np.random.default_rng(1)
    low, high = vertices.min(0), vertices.max(0)
    middle, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    eye = middle + np.array([0, 0.3, 1.0]) * radius * 2.2
    ahead = unit(middle - eye)
    right = unit(np.cross(ahead, [0, 1, 0]))
    up = np.cross(right, ahead)
    y, x = np.meshgrid(np.linspace(1, -1, SIDE), np.linspace(-1, 1, SIDE), indexing="ij")
    directions = ahead + 0.45 * (x[..., None] * right + y[..., None] * up)
    directions = directions.reshape(-1, 3).astype(np.float32)
    origins = np.broadcast_to(eye.astype(np.float32), directions.shape).copy()

    hits = scene.intersect(origins, directions)
    points = (origins + hits.t[:, None] * directions)[hits.hit]
    normals = hits.normal[hits.hit]
    normals *= -np.sign((normals * directions[hits.hit]).sum(1))[:, None]
    rows = np.sort(rng.integers(0, len(points), SIDE * SIDE))
    around = unit(rng.normal(size=(SIDE * SIDE, 3)))
    from_surface = (points + 1e-4 * radius * normals)[rows].astype(np.float32)
    into_hemisphere = (normals[rows] + 0.999 * around).astype(np.float32)

    ends = rng.uniform(low, high, (2, SIDE * SIDE, 3)).astype(np.float32)
    return {
        "primary": (origins, directions),
        "diffuse": (from_surface, into_hemisphere),
        "random": (ends[0], ends[1] - ends[0]),
    }


def open3d_calls(vertices, faces, threads):
    import numpy as np
    import open3d

    scene = open3d.t.geometry.RaycastingScene(nthreads=threads)
    tensor = open3d.core.Tensor
    scene.add_triangles(tensor(vertices), tensor(faces.astype(np.uint32)))
    return {
        "closest": lambda _, __, both: scene.cast_rays(tensor(both)),
        "count": lambda _, __, both: scene.count_intersections(tensor(both)),
        "all": lambda _, __, both: scene.list_intersections(tensor(both)),
    }


def embree_calls(mesh):
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    embree = RayMeshIntersector(mesh)
    bare = {"closest": lambda o, d, _: embree._scene.run(o, d, query="INTERSECT")}
    return bare, {
        "closest": lambda o, d, _: embree.intersects_first(o, d),
        "all": lambda o, d, _: embree.intersects_id(o, d, multiple_hits=True),
    }


def tracers(mesh, vertices, faces, threads):
    """What takes (origins, directions, both side by side), by tracer and query."""
    import phalanx

    scene = phalanx.Scene()
    scene.add_mesh(vertices, faces)
    scene.build("best")
    calls = {
        "phalanx": {
            "closest": lambda o, d, _: scene.intersect(o, d, threads=threads),
            "count": lambda o, d, _: scene.count(o, d, threads=threads),
            "all": lambda o, d, _: scene.all_hits(o, d, threads=threads),
        }
    }
    try:
        if threads == 1:
            calls["embreex"], calls["trimesh"] = embree_calls(mesh)
    except ImportError:
        pass
    try:
        calls["open3d"] = open3d_calls(vertices, faces, threads)
    except ImportError:
        pass
    return scene, calls


def measure(path, threads, rounds):
    """Seconds of each call, {rays: {tracer: [seconds of each round]}}."""
    import numpy as np

    mesh, vertices, faces = load(path)
    scene, calls = tracers(mesh, vertices, faces, threads)
    sets = ray_sets(scene, vertices)
    tasks = [(kind, kind, "closest", rounds) for kind in sets]
    for query in ("count", "all"):
        tasks.append((f"random, {query}", "random", query, max(rounds // 5, 1)))
    seconds = {}
    for name, kind, query, times in tasks:
        origins, directions = sets[kind]
        both = np.concatenate([origins, directions], axis=1)
        asked = {tracer: queries[query] for tracer, queries in calls.items() if query in queries}
        seconds[name] = {tracer: [] for tracer in asked}
        for _ in range(times):
            for tracer, call in asked.items():
                start = time.perf_counter()
                call(origins, directions, both)
                seconds[name][tracer].append(time.perf_counter() - start)
    return seconds


def rate(times):
    """Millions of rays a second of the median call."""
    return SIDE * SIDE / statistics.median(times) / 1e6


def table(results):
    names = list(dict.fromkeys(n for r in results for k in r["seconds"].values() for n in k))
    print("| CPUs | rays | " + " | ".join(names) + " | phalanx ÷ the fastest other |")
    print("|---:|---|" + "---:|" * (len(names) + 1))
    for result in results:
        for kind, times in result["seconds"].items():
            rates = {name: rate(times[name]) for name in names if name in times}
            others = [name for name in rates if name != "phalanx"]
            ratio = "–"
            if others:
                best = times[max(others, key=rates.get)]
                ratio = f"{statistics.median(b / a for a, b in zip(times['phalanx'], best)):.2f}"
            cells = [f"{rates[name]:.2f}" if name in rates else "–" for name in names]
            print(f"| {result['threads']} | {kind} | " + " | ".join(cells) + f" | **{ratio}** |")


def surroundings():
    """The machine, the day and the packages that a record is of."""
    versions = {}
    for package in ("phalanx-rt", "embreex", "trimesh", "open3d-cpu", "open3d", "numpy"):
        try:
            versions[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    models = [line for line in open("/proc/cpuinfo", encoding="utf-8") if "model name" in line]
    cpu = models[0].split(":")[1].strip() if models else platform.processor()
    return {"date": datetime.date.today().isoformat(), "cpu": cpu, "versions": versions}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("mesh")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--json", help="record of every call's seconds")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        print(json.dumps(measure(options.mesh, options.threads[0], options.rounds)))
        return
    results = []
    cpus = sorted(os.sched_getaffinity(0))
    for threads in options.threads:
        os.sched_setaffinity(0, cpus[-threads:])
        child = [sys.executable, __file__, options.mesh, "--child", "--threads", str(threads)]
        child += ["--rounds", str(options.rounds)]
        out = subprocess.run(child, check=True, capture_output=True, text=True).stdout
        results.append({"threads": threads, "seconds": json.loads(out.splitlines()[-1])})
    table(results)
    if options.json:
        mesh = os.path.basename(options.mesh)
        record = {"kind": "python speed", "mesh": mesh, **surroundings(), "results": results}
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(record, file)


if __name__ == "__main__":
    main()
