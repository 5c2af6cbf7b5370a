#!/usr/bin/env python3
"""The part of run.py within its environment: renders and casts rays with Mitsuba, and compares.

    render.py picture VARIANT SCENE OUT.npz    # depths, normals, ids; a path-traced image, timed
    render.py rays VARIANT MESH OUT.npz        # rays at a mesh's vertices and edges; `ball` is one
    render.py refused VARIANT                  # what Python is told of shapes that are not done
    render.py compare-pictures ONE.npz OTHER.npz
    render.py compare-rays ONE.npz OTHER.npz

SCENE is as in run.py. Each prints one line of JSON.
"""

import argparse
import ctypes
import json
import re
import time
from pathlib import Path

import numpy as np

SIZE, SAMPLES, DEPTH = 512, 8, 5
CHANNELS = "depth:depth,uv:uv,sh:sh_normal,geo:geo_normal,prim:prim_index,shape:shape_index"
COUNT = 300_000
# Barycentric coordinates below this are those of a ray at an edge.
EDGE = 1e-3
# Rays that pass an edge by less than this angle, eight roundings of float32, may hit or miss.
ROUNDING = 2.0**-21
# Rays whose answers differ are intersected with all triangles, up to so many of each kind.
CHECKED = 100


class RayTimes(ctypes.Structure):
    _fields_ = [
        ("calls", ctypes.c_uint64),
        ("rays", ctypes.c_uint64),
        ("seconds", ctypes.c_double),
        ("clock", ctypes.c_double),
    ]


def libraries() -> list[str]:
    """Files of this process that hold an Embree or a phalanx."""
    maps = Path("/proc/self/maps").read_text()
    return sorted(set(re.findall(r"\S*/(lib(?:embree|phalanx)\S*)", maps)))


def rotations(count: int, rng) -> np.ndarray:
    """Affine maps, 4×4: turned, smaller, side by side on a grid."""
    maps = np.tile(np.eye(4), (count, 1, 1))
    side = int(np.ceil(np.sqrt(count)))
    for k in range(count):
        q, r = np.linalg.qr(rng.normal(size=(3, 3)))
        q *= np.sign(np.diag(r))
        q[:, 0] *= np.linalg.det(q)
        maps[k, :3, :3] = q * rng.uniform(0.5, 1.0) * 1.2 / side
        maps[k, :3, 3] = [k % side / side - 0.5, k // side / side - 0.5, rng.uniform(-0.2, 0.2)]
    return maps


def ellipsoids(mi) -> dict:
    """Meshes with filter functions: Mitsuba culls their back faces."""
    rng, count = np.random.default_rng(3), 60
    quaternions = rng.normal(size=(count, 4))
    columns = {
        "centers": rng.uniform(-1, 1, size=(count, 3)),
        "scales": rng.uniform(0.05, 0.25, size=(count, 3)),
        "quaternions": quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True),
        "opacities": np.ones((count, 1)),
        "sh_coeffs": np.ones((count, 3)),
    }
    tensors = {name: mi.TensorXf(rows.astype(np.float32)) for name, rows in columns.items()}
    return {"type": "ellipsoidsmesh", **tensors}


def scene_of(mi, name: str, integrator: dict, samples: int, robust: bool):
    """A scene: MESH or MESH@camera, of which `ellipsoids` is one, or COUNT*MESH for instances."""
    count, mesh = name.split("*") if "*" in name else ("0", name)
    mesh, _, camera = mesh.partition("@")
    shape = ellipsoids(mi) if mesh == "ellipsoids" else {"type": "ply", "filename": mesh}
    bounds = mi.load_dict(shape).bbox()
    middle, size = np.ravel(bounds.center()), float(np.linalg.norm(np.ravel(bounds.extents())))
    transform = mi.ScalarTransform4f
    scene = {"type": "scene", "integrator": integrator, "sky": {"type": "constant"}}
    scene["embree_use_robust_intersections"] = robust
    up, angle = [0, 1, 0], 40.0
    if int(count):
        scene["group"] = {"type": "shapegroup", "mesh": shape}
        for k, to_world in enumerate(rotations(int(count), np.random.default_rng(1))):
            unit = transform().scale(1 / size).translate([float(-x) for x in middle])
            to_world = transform(to_world.tolist()) @ unit
            scene[f"instance{k}"] = {
                "type": "instance",
                "group": {"type": "ref", "id": "group"},
                "to_world": to_world,
            }
        middle, size = np.zeros(3), 1.4
    else:
        scene["mesh"] = shape
    origin, target = middle + np.array([0.5, 0.4, 1.1]) * size, middle
    if camera:
        numbers = [float(x) for x in camera.split(",")]
        origin, target, up, angle = numbers[:3], numbers[3:6], numbers[6:9], numbers[9]
    origin = [float(x) for x in origin]
    scene["lamp"] = {"type": "point", "position": origin, "intensity": 0.3 * size**2}
    scene["sensor"] = {
        "type": "perspective",
        "fov": angle,
        "to_world": transform().look_at(origin=origin, target=[float(x) for x in target], up=up),
        "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}},
        "sampler": {"type": "independent", "sample_count": samples},
    }
    return mi.load_dict(scene)


def render(mi, scene, seed: int) -> np.ndarray:
    return np.array(mi.render(scene, seed=seed))


def picture(mi, arguments) -> dict:
    """Channels of the first hits, and an image, rendered three times: compiled, timed, split."""
    aov = {"type": "aov", "aovs": CHANNELS}
    scene = scene_of(mi, arguments.scene, aov, 1, arguments.robust)
    channels = render(mi, scene, 0)
    path = {"type": "path", "max_depth": DEPTH}
    start = time.perf_counter()
    scene = scene_of(mi, arguments.scene, path, SAMPLES, arguments.robust)
    load = time.perf_counter() - start
    render(mi, scene, 0)
    start = time.perf_counter()
    render(mi, scene, 1)
    seconds = time.perf_counter() - start
    # Once more with the clock, which takes time itself.
    timer, times = ctypes.CDLL(None), RayTimes()
    timer.ray_timer_start()
    image = render(mi, scene, 1)
    timer.ray_timer_stop(ctypes.byref(times))
    np.savez(arguments.out, channels=channels, image=image)
    return {
        "libraries": libraries(),
        "load": load,
        "render": seconds,
        "calls": times.calls,
        "rays": times.rays,
        "in_rays": times.seconds,
        "clock": times.clock,
    }


def ball() -> tuple[np.ndarray, np.ndarray]:
    """A closed mesh: an octahedron, each triangle of which is divided in four, six times."""
    points = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    points = [np.array(p, float) for p in points]
    faces = [(x, y, z) for x in (0, 1) for y in (2, 3) for z in (4, 5)]
    for _ in range(6):
        middles = {}

        def middle(a: int, b: int) -> int:
            key = min(a, b), max(a, b)
            if key not in middles:
                middles[key] = len(points)
                point = points[a] + points[b]
                points.append(point / np.linalg.norm(point))
            return middles[key]

        parts = []
        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            parts += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = parts
    return np.array(points, np.float32), np.array(faces, np.uint32)


def rays_at(vertices: np.ndarray, faces: np.ndarray, spread: float):
    """Rays, half of them at vertices of a mesh, half at points of its edges."""
    rng = np.random.default_rng(2)
    lower, upper = vertices.min(axis=0), vertices.max(axis=0)
    middle, size = (lower + upper) / 2, (upper - lower).max()
    origins = middle + rng.uniform(-spread, spread, size=(COUNT, 3)) * size
    face = faces[rng.integers(len(faces), size=COUNT)]
    share = rng.choice([0.0, 0.0, 0.25, 0.5], size=(COUNT, 1))
    targets = vertices[face[:, 0]] * (1 - share) + vertices[face[:, 1]] * share
    origins = origins.astype(np.float32)
    return origins, (targets.astype(np.float32) - origins)


def rays(mi, arguments) -> dict:
    """Closest hits of rays at vertices and edges: in one wave where the variant has waves."""
    is_ball = arguments.scene == "ball"
    if is_ball:
        vertices, faces = ball()
        mesh = mi.Mesh("ball", len(vertices), len(faces))
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"], parameters["faces"] = vertices.ravel(), faces.ravel()
        parameters.update()
    else:
        mesh = mi.load_dict({"type": "ply", "filename": arguments.scene})
        parameters = mi.traverse(mesh)
        vertices = np.array(parameters["vertex_positions"], dtype=np.float32).reshape(-1, 3)
        faces = np.array(parameters["faces"], dtype=np.uint32).reshape(-1, 3)
    robust = arguments.robust
    scene = mi.load_dict({"type": "scene", "m": mesh, "embree_use_robust_intersections": robust})
    # From within the ball, so that all rays hit; from around other meshes.
    origins, directions = rays_at(vertices, faces, 0.2 if is_ball else 1.0)
    if "scalar" in arguments.variant:
        ts, prims = np.zeros(COUNT, np.float32), np.zeros(COUNT, np.uint32)
        for k in range(COUNT):
            ray = mi.Ray3f(origins[k].tolist(), directions[k].tolist())
            hit = scene.ray_intersect_preliminary(ray)
            valid = hit.is_valid()
            ts[k], prims[k] = (hit.t, hit.prim_index) if valid else (np.inf, 0)
    else:
        ray = mi.Ray3f(mi.Point3f(origins.T), mi.Vector3f(directions.T))
        hit = scene.ray_intersect_preliminary(ray)
        ts, prims = np.array(hit.t), np.array(hit.prim_index)
        ts[~np.array(hit.is_valid())] = np.inf
    traced = {"origins": origins, "directions": directions, "t": ts, "prim": prims}
    np.savez(arguments.out, vertices=vertices, faces=faces, **traced)
    return {"libraries": libraries(), "rays": COUNT, "hits": int(np.isfinite(ts).sum())}


def refused(mi, arguments) -> dict:
    """What Python is told of shapes that are not triangle meshes."""
    answers = {}
    for kind in ("sphere", "disk", "cylinder"):
        try:
            mi.load_dict({"type": "scene", "shape": {"type": kind}})
            answers[kind] = "done"
        except RuntimeError as error:
            answers[kind] = str(error).partition("phalanx as Embree: ")[2] or str(error)
    return answers


def compare_pictures(arguments) -> dict:
    """Pixels and images of two libraries. `lost`: hits of the first that the second has not."""
    files = [np.load(arguments.one), np.load(arguments.other)]
    one, other = (file["channels"].astype(np.float64) for file in files)
    first, second = (file["image"].astype(np.float64) for file in files)
    # Beside the image's own channels, which come first: depth, uv, two normals, two ids.
    one, other = one[..., -11:], other[..., -11:]
    hit, hits = one[..., 0] > 0, other[..., 0] > 0
    both = hit & hits
    same = both & (one[..., 9:] == other[..., 9:]).all(axis=-1)
    differ = np.abs(one - other)
    on_edge = np.zeros_like(both)
    for pixels, found in ((one, hit), (other, hits)):
        u, v = pixels[..., 1], pixels[..., 2]
        on_edge |= found & (np.minimum(np.minimum(u, v), 1 - u - v) < EDGE)
    odd = (hit != hits) | (both & ~same)
    # A depth of nearly zero is as exact as coordinates are, and no more.
    relative = differ[..., 0] / np.maximum(one[..., 0], 0.01 * np.median(one[..., 0][hit]))
    nan = np.isnan(one[..., 3:9]) != np.isnan(other[..., 3:9])
    return {
        "hits": int(hit.sum()),
        "lost": int((hit & ~hits).sum()),
        "found": int((hits & ~hit).sum()),
        "other_triangle": int((both & ~same).sum()),
        "off_edges": int((odd & ~on_edge).sum()),
        "depth": float(relative[same].max()),
        "shading_normal": float(np.nanmax(differ[same][:, 3:6])),
        "geometric_normal": float(np.nanmax(differ[same][:, 6:9])),
        "nan": int(nan[same].sum()),
        "image": float(np.abs(first - second).mean() / first.mean()),
        "equal_pixels": float((first == second).all(axis=-1).mean()),
    }


def truth(data, k: int) -> tuple[float, float]:
    """The largest margin of a ray in any triangle, and the least t of its hits.

    In double precision, over all triangles. A margin is the angle between the ray and the nearest
    edge as the ray's origin sees them, negative where it passes the triangle.
    """
    a, b, c = (data["vertices"][data["faces"][:, i]].astype(np.float64) for i in range(3))
    o, d = data["origins"][k].astype(np.float64), data["directions"][k].astype(np.float64)
    e, f = b - a, c - a
    p, q = np.cross(d, f), np.cross(o - a, e)
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = (e * p).sum(axis=1)
        u, v = ((o - a) * p).sum(axis=1) / determinant, (q @ d) / determinant
        t = (f * q).sum(axis=1) / determinant
        margin = np.full(len(t), np.inf)
        for weight, edge in ((u, f), (v, e), (1 - u - v, f - e)):
            distance = weight * np.abs(determinant) / np.linalg.norm(np.cross(edge, d), axis=1)
            margin = np.minimum(margin, distance / (t * np.linalg.norm(d)))
    margin = np.where((t > 0) & np.isfinite(margin), margin, -np.inf)
    inside = margin >= 0
    return float(margin.max()), float(t[inside].min()) if inside.any() else np.inf


def compare_rays(arguments) -> dict:
    """Closest hits of two libraries; where they differ, the truth about up to CHECKED rays."""
    one, other = dict(np.load(arguments.one)), dict(np.load(arguments.other))
    hit, hits = np.isfinite(one["t"]), np.isfinite(other["t"])
    both = np.flatnonzero(hit & hits)
    relative = np.abs(one["t"][both] - other["t"][both]) / one["t"][both]
    lost, found = np.flatnonzero(hit & ~hits), np.flatnonzero(hits & ~hit)
    far = both[relative > 1e-4]
    nearest = 0
    for k in far[:CHECKED]:
        t = truth(other, k)[1]
        nearest += abs(other["t"][k] - t) < abs(one["t"][k] - t)
    margins = [[truth(one, k)[0] for k in rays[:CHECKED]] for rays in (lost, found)]
    return {
        "rays": len(hit),
        "one_misses": int((~hit).sum()),
        "other_misses": int((~hits).sum()),
        "lost": len(lost),
        "lost_wrongly": sum(margin > ROUNDING for margin in margins[0]),
        "found": len(found),
        "found_wrongly": sum(margin < -ROUNDING for margin in margins[1]),
        "far": len(far),
        "far_other_is_right": int(nearest),
        "checked": CHECKED,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("picture", "rays", "refused"):
        command = commands.add_parser(name)
        command.add_argument("variant")
        if name != "refused":
            command.add_argument("scene")
            command.add_argument("out")
            command.add_argument("--robust", action="store_true")
    for name in ("compare-pictures", "compare-rays"):
        command = commands.add_parser(name)
        command.add_argument("one")
        command.add_argument("other")
    arguments = parser.parse_args()
    if arguments.command.startswith("compare"):
        call = compare_pictures if arguments.command == "compare-pictures" else compare_rays
        print(json.dumps(call(arguments)))
        return
    import drjit as dr
    import mitsuba as mi

    mi.set_variant(arguments.variant)
    mi.set_log_level(mi.LogLevel.Error)
    assert mi.MI_ENABLE_EMBREE
    # Seconds in rays are seconds of the clock only for one thread.
    dr.set_thread_count(1)
    call = {"picture": picture, "rays": rays, "refused": refused}[arguments.command]
    print(json.dumps(call(mi, arguments)))


if __name__ == "__main__":
    main()
