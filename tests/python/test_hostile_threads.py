"""Threads, signals and copies: an exception of the right type, or a defined answer."""

import copy
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


@pytest.mark.parametrize(
    "threads, error",
    [(-1, ValueError), (2**63, OverflowError), (1.5, TypeError), ("2", TypeError)],
)
def test_wrong_numbers_of_threads_are_refused(cube, threads, error):
    rays = np.zeros((4, 6))
    for query in (cube.intersect, cube.occluded, cube.count, cube.all_hits):
        with pytest.raises(error):
            query(rays, threads=threads)
    for other in (cube.build, cube.render, cube.depth):
        with pytest.raises(error):
            other(threads=threads)


@pytest.mark.parametrize("threads", [1000, 2**31, 2**63 - 1])
def test_more_threads_than_there_are_do_no_harm(cube, threads):
    origins, directions = rays_between(np.random.default_rng(6), 200_000)
    hits = cube.intersect(origins, directions, threads=threads)
    assert hits.t.tobytes() == cube.intersect(origins, directions, threads=1).t.tobytes()
    assert cube.occluded(origins, directions, threads=threads).sum() == hits.hit.sum()
    cube.build(threads=threads)


def test_a_huge_picture_is_refused(cube):
    for size in ((2**31, 2**31), (0, 5), (2**20, 2**20)):
        with pytest.raises(ValueError):
            cube.depth(size=size)
    with pytest.raises(OverflowError):
        cube.render(size=(-1, 5))
    with pytest.raises(OverflowError):
        cube.render(spp=2**40)


def test_more_rays_than_fit_memory_are_a_memory_error():
    script = """
        import resource, numpy as np, phalanx
        scene = phalanx.Scene()
        scene.add_spheres([[0, 0, 0]], 1.0)
        scene.build()
        rays = np.broadcast_to(np.float32([0, 0, 5, 0, 0, -1]), (10**12, 6))
        try:
            scene.intersect(rays)
        except MemoryError:
            print("MemoryError")
    """
    done = child(script)
    assert done.stdout.strip() == "MemoryError", done.stderr


def test_arrays_that_another_thread_changes_give_some_answer(cube):
    origins, directions = rays_between(np.random.default_rng(7), 300_000)
    noise = np.random.default_rng(8).uniform(-9, 9, size=origins.shape).astype(np.float32)
    noise[::7] = np.nan
    going = threading.Event()

    def change():
        while not going.is_set():
            np.copyto(origins, noise)
            np.copyto(directions, noise[::-1])

    changer = threading.Thread(target=change)
    changer.start()
    try:
        for _ in range(10):
            hits = cube.intersect(origins, directions)
            assert ((hits.prim_id >= -1) & (hits.prim_id < 12)).all()
            assert (hits.t[hits.hit] > 0).all() and (hits.normal**2).sum() > 0
            lists = cube.all_hits(origins, directions)
            assert ((lists.prim_id >= 0) & (lists.prim_id < 12)).all()
            lists.refine()
            cube.occluded(origins, directions)
    finally:
        going.set()
        changer.join()


def test_threads_query_a_scene_that_another_one_adds_to():
    scene = phalanx.Scene()
    scene.add_mesh(CUBE_VERTICES, CUBE_FACES)
    # The first crosses every cube, which are one within another.
    origins, directions = rays_between(np.random.default_rng(9), 2_000)
    origins[0], directions[0] = [0.2, 0.1, 9], [0, 0, -1]
    ending, answers, wrong = threading.Event(), [], []
    queries = (scene.intersect, scene.occluded, scene.count, scene.all_hits)

    def ask(query):
        while not ending.is_set():
            try:
                before = len(scene)
                answer = query(origins, directions)
                answers.append((query, before, answer, len(scene)))
            except BaseException as error:  # noqa: BLE001
                wrong.append(error)

    askers = [threading.Thread(target=ask, args=(query,)) for query in queries]
    for asker in askers:
        asker.start()
    added, end = 0, time.monotonic() + 2
    while time.monotonic() < end:
        added += 1
        scene.add_mesh(CUBE_VERTICES * (1 + added / 10_000), CUBE_FACES)
        time.sleep(0.003)
    ending.set()
    for asker in askers:
        asker.join()
    assert not wrong, wrong[:3]
    assert added > 5 and len(answers) > 5 and len(scene) == 12 * (1 + added)
    for query, before, answer, after in answers:
        if query == scene.intersect:
            assert (answer.prim_id < after).all()
            assert np.isfinite(answer.refine()[1][answer.hit]).all()
        # Answers are of the scene at one moment within the call.
        elif query == scene.count:
            assert before <= answer[0] * 6 <= after
        elif query == scene.all_hits:
            assert before <= answer.starts[1] * 6 <= after


# Rays between whole numbers: each of these arrays holds the same ones.
ARRAYS = {
    "float32": lambda rays: rays.astype(np.float32),
    "float64": lambda rays: rays.astype(np.float64),
    "half": lambda rays: rays.astype(np.float16),
    "integers": lambda rays: rays,
    "small integers": lambda rays: rays.astype(np.int8),
    "another byte order": lambda rays: rays.astype(">f4"),
    "Fortran": lambda rays: np.asfortranarray(rays, dtype=np.float32),
    "every other row": lambda rays: np.repeat(rays.astype(np.float32), 2, axis=0)[::2],
    "lists": lambda rays: rays.tolist(),
}


def test_sixteen_threads_ask_everything_of_a_scene_while_others_are_built():
    rng = np.random.default_rng(11)
    ends = rng.integers(-4, 5, size=(2, 4_000, 3))
    rays = np.concatenate([ends[0], ends[1] - ends[0]], axis=1)
    arrays = [make(rays) for make in ARRAYS.values()]

    def knot():
        scene = phalanx.Scene()
        for k in range(200):
            scene.add_mesh(CUBE_VERTICES * (1 + k / 100), CUBE_FACES)
        scene.add_spheres(rng.uniform(-3, 3, size=(50, 3)), 0.3)
        return scene

    def columns(hits):
        names = ("t", "u", "v", "prim_id", "geom_id")
        return b"".join(getattr(hits, name).tobytes() for name in names)

    camera = ([5, 4, 9], [0, 0, 0], [0, 1, 0], 40)
    queries = {
        "intersect": lambda scene, rays: columns(scene.intersect(rays)),
        "normals": lambda scene, rays: scene.intersect(rays, threads=1).normal.tobytes(),
        "refined": lambda scene, rays: scene.intersect(rays).refine()[1].tobytes(),
        "occluded": lambda scene, rays: scene.occluded(rays, tmax=0.5).tobytes(),
        "count": lambda scene, rays: scene.count(rays, threads=2).tobytes(),
        "all_hits": lambda scene, rays: columns(scene.all_hits(rays[:200])),
        "render": lambda scene, _: scene.render(camera, (40, 30)).tobytes(),
        "depth": lambda scene, _: scene.depth(camera, (40, 30)).tobytes(),
        "others": lambda scene, _: (len(scene), scene.first_prim(7), scene.bounds.tobytes()),
        "bench": lambda scene, _: len(scene.bench(["primary"], camera, (16, 16), repeat=1)["rows"]),
    }
    shared = knot()
    shared.build()
    expected = {name: query(shared, arrays[0]) for name, query in queries.items()}
    # The first of the threads builds the tree, and the others wait for it.
    shared.build("best")
    ending, wrong, answers = threading.Event(), [], []

    def guarded(work, *arguments):
        try:
            work(*arguments)
        except BaseException as error:  # noqa: BLE001
            wrong.append(error)

    def ask(thread):
        for k in range(len(queries) * len(arrays)):
            name = list(queries)[(thread + k) % len(queries)]
            if name == "bench" and k > 0:
                continue
            answer = queries[name](shared, arrays[(thread + k // len(queries)) % len(arrays)])
            answers.append(name)
            assert answer == expected[name], name

    def build_another():
        while not ending.is_set():
            knot().build()

    def change_another():
        scene = knot()
        while not ending.is_set():
            scene.add_mesh(arrays[1][:, :3], [[0, 1, 2]])
            scene.occluded(arrays[2])

    others = [threading.Thread(target=guarded, args=(w,)) for w in (build_another, change_another)]
    askers = [threading.Thread(target=guarded, args=(ask, thread)) for thread in range(16)]
    for thread in others + askers:
        thread.start()
    for asker in askers:
        asker.join()
    ending.set()
    for other in others:
        other.join()
    assert not wrong, (len(wrong), wrong[:3])
    assert set(answers) == set(queries)


def test_lists_of_hits_cannot_be_pickled_or_copied(cube):
    lists = cube.all_hits([[0.2, 0.1, 5]], [[0, 0, -1]])
    for change in (pickle.dumps, copy.copy, copy.deepcopy):
        with pytest.raises(TypeError):
            change(lists)
    assert cube.occluded([[0.2, 0.1, 5]], [[0, 0, -1]])[0]


def test_hits_are_made_by_queries_only():
    for kind in (phalanx.Hits, phalanx.AllHits):
        with pytest.raises(TypeError):
            kind()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork")
def test_a_fork_may_query_a_scene_of_its_parent(cube):
    cube.occluded([[0.2, 0.1, 5]], [[0, 0, -1]])
    done = child(
        """
        import os, numpy as np, phalanx
        scene = phalanx.Scene()
        scene.add_spheres([[0, 0, 0]], 1.0)
        rays = np.tile(np.float32([0, 0, 5, 0, 0, -1]), (100000, 1))
        assert scene.occluded(rays).all()
        pid = os.fork()
        if pid == 0:
            os._exit(0 if scene.occluded(rays).all() else 3)
        print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
        """
    )
    assert done.stdout.strip() == "0", done.stderr


# One thread, and rays for eight seconds at the rate of the first of them.
LONG = {
    "intersect": "scene.intersect(rays, threads=1)",
    "all_hits": "scene.all_hits(rays, threads=1)",
    "count": "scene.count(rays, threads=1)",
    "occluded": "scene.occluded(rays, threads=1)",
    "render": "scene.render(size=(4000, 4000), spp=4000)",
}


@pytest.mark.skipif(os.name == "nt", reason="SIGINT cannot be sent to a child on Windows")
@pytest.mark.parametrize("work", LONG)
def test_ctrl_c_stops_long_work_before_its_end(work):
    # A shell's background jobs, and what they start, ignore SIGINT unless they ask for it.
    script = f"""
        import numpy as np, phalanx, signal, time
        signal.signal(signal.SIGINT, signal.default_int_handler)
        scene = phalanx.Scene.load("standard:room:50k")
        scene.build()
        low, high = np.float32(scene.bounds)
        some = np.random.default_rng(1).random(size=(300_000, 6), dtype=np.float32)
        some[:, :3] = low + some[:, :3] * (high - low)
        some[:, 3:] = low + some[:, 3:] * (high - low) - some[:, :3]
        start = time.monotonic()
        scene.{work}(some, threads=1)
        seconds = time.monotonic() - start
        rays = np.tile(some, (min(60, 1 + int(8 / seconds)), 1))
        print("ready", flush=True)
        try:
            {LONG[work]}
            print("whole", flush=True)
        except KeyboardInterrupt:
            print("KeyboardInterrupt", flush=True)
    """
    if work == "render":
        script = script.replace("scene.render(some, threads=1)", "scene.occluded(some)")
    process = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=60)
        assert rest == "KeyboardInterrupt\n" and process.returncode == 0
    finally:
        process.kill()


def child(script):
    command = [sys.executable, "-c", textwrap.dedent(script)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120)
