#!/usr/bin/env python3
"""Mitsuba 3 on phalanx: its wheel, with embree_shim.cpp in the place of Embree, against the wheel.

    python3 perf/mitsuba/run.py WORK [--scene SCENE]... [--rounds 5] [--llvm FILE]

WORK is a folder to be made or used again. It gets an environment with Mitsuba's wheel, the library
(cargo build -p phalanx-capi), and two libraries of this folder: embree_shim.cpp, named
libembree3.so, and ray_timer.cpp, which stands before either Embree and times its rays.

The wheel stays as it is: its libmitsuba.so finds libembree3.so by a RUNPATH, and folders in
LD_LIBRARY_PATH come before that. Every process says which libraries it holds, and is stopped if
they are others than meant.

A SCENE is a PLY file; FILE@x,y,z,x,y,z,x,y,z,angle has a camera (from, to, up, angle of view),
20*FILE are twenty instances of it, and `ellipsoids` in the place of FILE are meshes with filter
functions. Without a scene, only rays are cast, at a ball. LLVM's variant needs a newer LLVM than
15: on Debian, `apt-get download libllvm19` and `dpkg-deb -x` will do, and --llvm names its file.

Tables go to stdout, all figures to WORK/figures.json. Needs Linux, a C++17 compiler, cargo and
Python's standard library.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
WHEELS = ["mitsuba==3.9.1", "drjit==1.5.0", "numpy==2.4.6"]
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"]
# Columns of pictures: Embree as Mitsuba sets it, Embree with RTC_SCENE_FLAG_ROBUST, phalanx.
ENGINES = ("embree", "robust", "phalanx")
PAIRS = (("embree", "phalanx"), ("robust", "phalanx"), ("embree", "robust"))


def run(*command, **options) -> str:
    """What a command prints; it ends this program if it fails."""
    command = [str(word) for word in command]
    print("+", *(Path(word).name if word[0] == "/" else word for word in command), file=sys.stderr)
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, **options)
    if done.returncode:
        sys.exit(f"{Path(command[0]).name} failed: {done.returncode}")
    return done.stdout


def prepare(work: Path) -> None:
    """The environment, the library, and the two libraries of this folder."""
    python = work / "venv/bin/python"
    if not python.exists():
        run(sys.executable, "-m", "venv", work / "venv")
    run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *WHEELS)
    run("cargo", "build", "--quiet", "--release", "-p", "phalanx-capi", cwd=ROOT)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    for folder in ("lib", "shim"):
        (work / folder).mkdir(exist_ok=True)
    shutil.copy(target / "release/libphalanx_c.so", work / "lib/libphalanx.so.0")
    link = work / "lib/libphalanx.so"
    link.unlink(missing_ok=True)
    link.symlink_to("libphalanx.so.0")
    compiler = [os.environ.get("CXX", "c++"), "-std=c++17", "-O2", "-shared", "-fPIC"]
    compiler += ["-fvisibility=hidden", "-Wl,--no-undefined", *WARNINGS]
    shim = ["-I", ROOT / "src/capi/include", HERE / "embree_shim.cpp", "-L", work / "lib"]
    shim += ["-lphalanx", "-Wl,-rpath,$ORIGIN/../lib", "-Wl,-soname,libembree3.so"]
    run(*compiler, *shim, "-o", work / "shim/libembree3.so")
    run(*compiler, HERE / "ray_timer.cpp", "-ldl", "-o", work / "libray_timer.so")


class Client:
    """Mitsuba in processes of its own."""

    def __init__(self, work: Path, llvm: str | None) -> None:
        self.work, self.llvm = work, llvm

    def ask(self, engine: str, *words) -> dict:
        """What render.py answers with that library."""
        variables = dict(os.environ, LD_BIND_NOW="1", LD_PRELOAD=str(self.work / "libray_timer.so"))
        variables.pop("LD_LIBRARY_PATH", None)
        if engine == "phalanx":
            variables["LD_LIBRARY_PATH"] = str(self.work / "shim")
        if self.llvm:
            variables["DRJIT_LIBLLVM_PATH"] = self.llvm
        python = self.work / "venv/bin/python"
        answer = json.loads(run(python, HERE / "render.py", *words, env=variables))
        meant = ["libembree3.so"] + ["libphalanx.so.0"] * (engine == "phalanx")
        if answer.get("libraries", meant) != meant:
            sys.exit(f"{engine}: not the libraries that were meant: {answer['libraries']}")
        return answer

    def trace(self, engine: str, command: str, variant: str, scene: str) -> tuple[dict, Path]:
        """The answer and the file of render.py's command."""
        out = self.work / f"{command}-{engine}.npz"
        options = ["--robust"] * (engine == "robust")
        return self.ask(engine, command, variant, scene, out, *options), out


def scene_name(scene: str) -> str:
    count, _, path = scene.rpartition("*")
    name = Path(path.partition("@")[0]).stem
    return f"{count} × {name}" if count else name


def table(head: list[str], rows: list[list[str]]) -> None:
    for row in (head, ["---"] * len(head), *rows):
        print("|", " | ".join(row), "|")
    print(flush=True)


def pictures(client: Client, variant: str, scene: str, rounds: int) -> dict:
    """Differences of pictures, and times of all rounds; libraries take turns."""
    times = {engine: [] for engine in ENGINES}
    for _ in range(rounds):
        for engine in ENGINES:
            times[engine].append(client.trace(engine, "picture", variant, scene)[0])
    files = {engine: client.work / f"picture-{engine}.npz" for engine in ENGINES}
    compared = {
        f"{one} → {other}": client.ask("embree", "compare-pictures", files[one], files[other])
        for one, other in PAIRS
    }
    return {"variant": variant, "scene": scene_name(scene), "differences": compared, "times": times}


def rays(client: Client, variant: str, scene: str) -> dict:
    files = {engine: client.trace(engine, "rays", variant, scene)[1] for engine in ENGINES}
    compared = {
        f"{one} → {other}": client.ask("embree", "compare-rays", files[one], files[other])
        for one, other in PAIRS
    }
    return {"variant": variant, "scene": scene_name(scene), "differences": compared}


def show_differences(results: list[dict]) -> None:
    head = ["scene", "variant", "libraries", "hits", "lost", "found", "other triangle"]
    head += ["… off edges", "depth", "geometric normal", "shading normal", "image"]
    rows = []
    for result in results:
        for pair, d in result["differences"].items():
            counts = ("hits", "lost", "found", "other_triangle", "off_edges")
            sizes = ("depth", "geometric_normal", "shading_normal", "image")
            row = [result["scene"], result["variant"], pair, *(f"{d[key]:,}" for key in counts)]
            rows.append(row + [f"{d[key]:.1e}" if d[key] else "0" for key in sizes])
    table(head, rows)


def show_rays(results: list[dict]) -> None:
    head = ["mesh", "libraries", "rays", "misses", "misses of the other", "lost", "… wrongly"]
    head += ["found", "… wrongly", "other distance", "… the other is right"]
    rows = []
    for result in results:
        for pair, d in result["differences"].items():
            counts = ("rays", "one_misses", "other_misses", "lost", "lost_wrongly", "found")
            row = [result["scene"], pair, *(f"{d[key]:,}" for key in counts)]
            of = min(d["far"], d["checked"])
            row += [str(d["found_wrongly"]), f"{d['far']:,}", f"{d['far_other_is_right']} of {of}"]
            rows.append(row)
    table(head, rows)


def show_times(results: list[dict]) -> None:
    head = ["scene", "variant", "library", "render, s", "in rays, s", "the rest, s"]
    head += ["share of rays", "rays", "ns a ray", "rays a call", "load and build, s"]
    rows = []
    for result in results:
        for engine, samples in result["times"].items():
            # The least of each, as other work on a machine can only add to it. Of the two readings
            # of the clock for a call, one is within its time.
            least = {key: min(s[key] for s in samples) for key in ("render", "load")}
            in_rays = min(s["in_rays"] - s["calls"] * s["clock"] / 2 for s in samples)
            total, calls, count = least["render"], samples[0]["calls"], samples[0]["rays"]
            row = [result["scene"], result["variant"], engine, f"{total:.2f}", f"{in_rays:.2f}"]
            row += [f"{total - in_rays:.2f}", f"{in_rays / total:.0%}", f"{count / 1e6:.2f} M"]
            row += [f"{1e9 * in_rays / count:.0f}", f"{count / calls:.1f}", f"{least['load']:.2f}"]
            rows.append(row)
    table(head, rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("work", type=Path)
    parser.add_argument("--scene", action="append", default=[])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--llvm")
    arguments = parser.parse_args()
    work = arguments.work.resolve()
    work.mkdir(parents=True, exist_ok=True)
    prepare(work)
    client = Client(work, arguments.llvm)
    variants = ["scalar_rgb"] + ["llvm_ad_rgb"] * bool(arguments.llvm)
    meshes = [scene for scene in arguments.scene if scene.endswith(".ply") and "*" not in scene]

    refusals = client.ask("phalanx", "refused", "scalar_rgb")
    edges = [rays(client, variants[-1], mesh) for mesh in ["ball", *meshes[:1]]]
    results = [
        pictures(client, variant, scene, arguments.rounds)
        for scene in arguments.scene
        for variant in variants
    ]
    (work / "figures.json").write_text(
        json.dumps({"refusals": refusals, "edges": edges, "pictures": results}, indent=1)
    )
    show_differences(results)
    show_times(results)
    show_rays(edges)
    table(["shape", "what Python is told"], [list(refusal) for refusal in refusals.items()])


if __name__ == "__main__":
    main()
