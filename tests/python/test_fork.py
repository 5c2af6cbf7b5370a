"""Processes that fork: threads, locks and half-made trees belong to the process that made them."""

import hashlib
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from conftest import CUBE_FACES, CUBE_VERTICES, rays_between

import phalanx
from phalanx.open3d import RaycastingScene

pytestmark = [
    pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork"),
    pytest.mark.filterwarnings("ignore:This process.*fork:DeprecationWarning"),
]

# A child that has no answer by then waits for a thread that it does not have.
SECONDS = float(os.environ.get("PHALANX_FORK_SECONDS", 60))
CAMERA = ([3, 4, 9], [0, 0, 0], [0, 1, 0], 40)


forked = False


def fork(work):
    """Forks a child that does some work and answers with a digest. Returns what waits for that, and
    ends a child that hangs."""
    global forked
    read, write = os.pipe()
    pid = os.fork()
    if pid == 0:
        code = 1
        try:
            if not forked:
                # It is ended together with its own children.
                os.setpgid(0, 0)
            forked = True
            os.write(write, work().encode())
            code = 0
        finally:
            os._exit(code)
    os.close(write)
    deadline = time.monotonic() + SECONDS

    def answer():
        done = 0
        while not done and time.monotonic() < deadline:
            done, status = os.waitpid(pid, os.WNOHANG)
            time.sleep(0.002)
        if not done:
            (os.kill if forked else os.killpg)(pid, signal.SIGKILL)
            os.waitpid(pid, 0)
        with os.fdopen(read, "rb") as pipe:
            text = pipe.read().decode()
        return text if done and status == 0 else f"it ended with {status}" if done else "it hangs"

    return answer


def digest(*arrays):
    return hashlib.sha256(b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)).hexdigest()


def columns(hits):
    return digest(hits.t, hits.u, hits.v, hits.prim_id, hits.geom_id)


def terrain(side, seed=0):
    """Vertices and faces of a rough surface of 2 (side - 1)² triangles between -3 and 3."""
    y, x = np.meshgrid(np.linspace(-3, 3, side), np.linspace(-3, 3, side), indexing="ij")
    z = np.random.default_rng(seed).normal(scale=0.3, size=x.shape)
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).reshape(-1)
    near = np.stack([corner, corner + 1, corner + side], axis=-1)
    far = np.stack([corner + side, corner + 1, corner + side + 1], axis=-1)
    return vertices, np.concatenate([near, far])


def scene_of(side, seed=0):
    scene = phalanx.Scene()
    scene.add_mesh(*terrain(side, seed))
    return scene


@pytest.fixture(scope="module")
def traced():
    """A scene that this process has built, traced and drawn."""
    scene = scene_of(150)
    prototype = scene.add_prototype(CUBE_VERTICES * 0.1, CUBE_FACES)
    scene.add_instance(prototype, np.eye(4))
    for threads in (0, 1, 2):
        scene.intersect(*RAYS, threads=threads)
    scene.render(CAMERA, (64, 48))
    return scene


RAYS = rays_between(np.random.default_rng(3), 60_000)
FEW = tuple(part[:40] for part in RAYS)


def moved(scene):
    scene = scene.__copy__()
    scene.set_vertices(0, terrain(150, seed=1)[0])
    scene.set_transform(1, np.diag([2.0, 2.0, 2.0, 1.0]))
    scene.update()
    return columns(scene.intersect(*RAYS))


def saved(scene, path):
    scene.save(path)
    return columns(phalanx.Scene.open(path).intersect(*RAYS))


def wrapped():
    scene = RaycastingScene()
    scene.add_triangles(*terrain(60))
    return digest(scene.cast_rays(np.hstack(RAYS))["t_hit"])


WORK = {
    "a batch": lambda scene, _: columns(scene.intersect(*RAYS)),
    "a batch on one thread": lambda scene, _: columns(scene.intersect(*RAYS, threads=1)),
    "a batch on three threads": lambda scene, _: columns(scene.intersect(*RAYS, threads=3)),
    "few rays": lambda scene, _: columns(scene.intersect(*FEW)),
    "occluded": lambda scene, _: digest(scene.occluded(*RAYS)),
    "count": lambda scene, _: digest(scene.count(*RAYS)),
    "all hits": lambda scene, _: columns(scene.all_hits(*RAYS)),
    "normals": lambda scene, _: digest(scene.intersect(*RAYS).normal),
    "refined": lambda scene, _: digest(*scene.intersect(*RAYS).refine()),
    "a build": lambda *_: columns(scene_of(150).intersect(*RAYS)),
    "a small build": lambda *_: columns(scene_of(3).intersect(*FEW)),
    "an update": lambda scene, _: moved(scene),
    "a picture": lambda scene, _: digest(scene.render(CAMERA, (64, 48))),
    "depth": lambda scene, _: digest(scene.depth(CAMERA, (64, 48))),
    "a standard scene": lambda *_: columns(
        phalanx.Scene.load("standard:room:20k").intersect(*RAYS)
    ),
    "a file": lambda scene, folder: saved(scene, folder / "saved.phx"),
    "a pickled scene": lambda scene, _: columns(pickle.loads(pickle.dumps(scene)).intersect(*RAYS)),
    "Open3D's class": lambda *_: wrapped(),
}


@pytest.mark.parametrize("work", WORK)
def test_a_child_answers_as_its_parent(traced, tmp_path, work):
    expected = WORK[work](traced, tmp_path)
    # The second forks again.
    assert fork(lambda: WORK[work](traced, tmp_path))() == expected
    assert fork(lambda: WORK["a build"](traced, tmp_path) + inner(traced, tmp_path, work))() == (
        WORK["a build"](traced, tmp_path) + expected
    )


def inner(scene, folder, work):
    return fork(lambda: WORK[work](scene, folder))()


def test_generations_of_forks_each_have_their_own_threads():
    def generation(depth):
        own = columns(scene_of(60).intersect(*RAYS))
        return own if depth == 0 else fork(lambda: generation(depth - 1))()

    assert generation(12) == columns(scene_of(60).intersect(*RAYS))


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="threads are counted in /proc")
def test_no_threads_pile_up(traced):
    """Neither in the parent, for each child, nor in a child, for each call."""

    def threads():
        return len(os.listdir("/proc/self/task"))

    def calls(count):
        for k in range(count):
            scene_of(20, seed=k).intersect(*FEW)
            moved(traced)
        # Those of the wide trees end by themselves.
        end = time.monotonic() + 10
        while threads() > 1 + os.cpu_count() and time.monotonic() < end:
            time.sleep(0.01)
        return str(threads())

    before = threads()
    for count in (1, 2, 12):
        assert int(fork(lambda: calls(count))()) <= 1 + os.cpu_count()
    # The parent's own may have ended meanwhile: one that built a wide tree.
    assert threads() <= before


def while_another_thread(work, pauses, child):
    """Forks while another thread does some work, after each pause, once it has begun; returns what
    waits for the children's answers."""
    begun = threading.Event()

    def run():
        begun.set()
        work()

    other = threading.Thread(target=run)
    other.start()
    begun.wait()
    answers, during = [], 0
    for pause in pauses:
        time.sleep(pause)
        during += other.is_alive()
        answers.append(fork(child))
        if not other.is_alive():
            break
    other.join()
    assert during > 0
    return answers


# What these make takes some 100 ms or more.
BIG = 350
PAUSES = [0.001, 0.004, 0.01, 0.02, 0.03, 0.04]


def test_a_fork_while_another_thread_builds():
    expected = columns(scene_of(BIG).intersect(*FEW))
    scene = scene_of(BIG)
    answers = while_another_thread(
        scene.build, PAUSES, lambda: columns(scene.intersect(*FEW)) + repr(scene)
    )
    assert {answer() for answer in answers} == {expected + repr(scene)}


def test_a_fork_while_another_thread_builds_the_wide_tree():
    expected = columns(scene_of(BIG).intersect(*FEW))
    scene = scene_of(BIG)
    # It needs the tree, but not the wide one.
    assert scene.first_prim(0) == 0
    answers = while_another_thread(scene.update, PAUSES, lambda: columns(scene.intersect(*FEW)))
    assert {answer() for answer in answers} == {expected}


def test_a_fork_while_another_thread_updates():
    vertices = terrain(BIG, seed=5)[0]
    new = scene_of(BIG)
    new.set_vertices(0, vertices)
    expected = columns(new.intersect(*FEW))
    scene = scene_of(BIG)
    scene.build()
    scene.set_vertices(0, vertices)
    answers = while_another_thread(scene.update, PAUSES, lambda: columns(scene.intersect(*FEW)))
    assert {answer() for answer in answers} == {expected}


def test_a_fork_while_another_thread_traces(traced):
    rays = [np.tile(part, (30, 1)) for part in RAYS]
    expected = WORK["a build"](traced, None) + columns(traced.intersect(*RAYS))
    answers = while_another_thread(
        lambda: traced.intersect(*rays),
        PAUSES,
        lambda: WORK["a build"](traced, None) + columns(traced.intersect(*RAYS)),
    )
    assert {answer() for answer in answers} == {expected}


def test_a_fork_while_another_thread_draws(traced):
    expected = digest(traced.render(CAMERA, (64, 48)))
    answers = while_another_thread(
        lambda: traced.render(CAMERA, (800, 600), spp=4),
        PAUSES,
        lambda: digest(traced.render(CAMERA, (64, 48))),
    )
    assert {answer() for answer in answers} == {expected}


def test_a_fork_while_another_thread_refines_the_same_hits(traced):
    rays = [np.tile(part, (10, 1)) for part in RAYS]
    expected = digest(*traced.intersect(*rays).refine())
    hits = traced.intersect(*rays)
    answers = while_another_thread(hits.refine, PAUSES, lambda: digest(*hits.refine()))
    assert {answer() for answer in answers} == {expected}


def test_a_fork_while_another_thread_builds_open3ds_class():
    def made():
        scene = RaycastingScene()
        scene.add_triangles(*terrain(BIG))
        return scene

    rays = np.hstack(FEW)
    expected = digest(made().cast_rays(rays)["t_hit"])
    scene = made()
    answers = while_another_thread(
        lambda: scene.cast_rays(rays), PAUSES, lambda: digest(scene.cast_rays(rays)["t_hit"])
    )
    assert {answer() for answer in answers} == {expected}


def test_a_fork_while_another_thread_builds_trimeshs_class():
    trimesh = pytest.importorskip("trimesh")
    from phalanx.trimesh import RayMeshIntersector

    mesh = trimesh.Trimesh(*terrain(BIG), process=False)
    expected = digest(RayMeshIntersector(mesh).intersects_first(*FEW))
    ray = RayMeshIntersector(mesh)
    make = ray._make
    ray._make = lambda: time.sleep(0.1) or make()
    answers = while_another_thread(
        lambda: ray.intersects_first(*FEW), PAUSES, lambda: digest(ray.intersects_first(*FEW))
    )
    assert {answer() for answer in answers} == {expected}


shared_scene = None


def of_shared(k):
    return columns(shared_scene.intersect(*RAYS)), columns(scene_of(40, k).intersect(*RAYS))


def of_pickled(scene):
    return columns(scene.intersect(*RAYS))


def results(pool, work, items):
    """Of a pool that is ended if it hangs."""
    try:
        return pool.map_async(work, items).get(SECONDS)
    finally:
        pool.terminate()
        pool.join()


def test_a_pool_of_forked_processes(traced):
    global shared_scene
    shared_scene = traced
    expected = [of_shared(k) for k in range(6)]
    context = multiprocessing.get_context("fork")
    assert results(context.Pool(3), of_shared, range(6)) == expected
    assert results(context.Pool(2), of_pickled, [traced] * 3) == [expected[0][0]] * 3


def test_a_pool_of_new_processes(traced):
    """Without a fork, scenes are pickled, as before."""
    context = multiprocessing.get_context("spawn")
    assert results(context.Pool(1), of_pickled, [traced]) == [columns(traced.intersect(*RAYS))]


@pytest.mark.parametrize("daemon", [True, False])
def test_a_process_and_its_child_end(daemon):
    """Threads that wait for work, or that trace, keep neither the parent nor the child alive."""
    script = f"""
        import multiprocessing, threading
        import numpy as np, phalanx
        scene = phalanx.Scene.load("standard:room:5k")
        rays = np.tile(np.float32([0, 0, 5, 0.1, 0.2, -1]), (100000, 1))

        def trace(count=1):
            for _ in range(count):
                scene.intersect(rays)
                phalanx.Scene.load("standard:room:5k").build()

        if __name__ == "__main__":
            trace()
            thread = threading.Thread(target=trace, args=(10**9 if {daemon} else 5,), daemon={daemon})
            thread.start()
            child = multiprocessing.get_context("fork").Process(target=trace)
            child.start()
            child.join()
            print(child.exitcode)
    """
    command = [sys.executable, "-W", "ignore", "-c", textwrap.dedent(script)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    assert (done.returncode, done.stdout) == (0, "0\n"), done.stderr
