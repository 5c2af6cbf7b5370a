"""A regression test that compares two machines: the same rays give the same bits everywhere.

    python same_bits.py > here.txt                 on one machine
    python same_bits.py --check here.txt           on the other machine

Needs only numpy. Prints a hash of each column of answers, for a million rays through three scenes.
With --check, exits with 1 if one differs. Rays are made from integers, so that no other library's
rounding is involved.
"""

import argparse
import hashlib
import pathlib
import sys

import numpy as np

import phalanx

SCENES = ("standard:room:50k", "standard:street:50k", "standard:terrain:50k")


def rays(bounds: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions, float32, (n, 3): between points of a box, on a grid of 2⁻¹⁰."""
    bits = np.random.PCG64(1).random_raw(6 * n).reshape(2, n, 3)
    share = (bits >> np.uint64(40)).astype(np.float64) / 2**24
    low, high = np.floor(bounds[0]), np.ceil(bounds[1])
    ends = np.floor((low + share * (high - low)) * 1024) / 1024
    return ends[0].astype(np.float32), (ends[1] - ends[0]).astype(np.float32)


def digests(name: str, n: int, threads: int | None = None):
    """Yields a line for each column of answers: scene, column, hash."""
    scene = phalanx.Scene.load(name)
    origins, directions = rays(scene.bounds, n)
    hits = scene.intersect(origins, directions, threads=threads)
    columns = {column: getattr(hits, column) for column in ("t", "u", "v", "prim_id", "normal")}
    columns["points"] = hits.refine()[1]
    columns["occluded"] = scene.occluded(origins, directions, tmax=0.25, threads=threads)
    columns["rays"] = np.concatenate([origins, directions], axis=1)
    for column, numbers in columns.items():
        plain = numbers.astype(numbers.dtype.newbyteorder("<")).tobytes()
        yield f"{name} {column} {hashlib.sha256(plain).hexdigest()[:32]}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rays", type=int, default=1_000_000, help="for all scenes together")
    parser.add_argument("--threads", type=int)
    parser.add_argument("--check", type=pathlib.Path, help="the output of another machine")
    args = parser.parse_args()
    lines = [x for s in SCENES for x in digests(s, args.rays // len(SCENES), args.threads)]
    print("\n".join(lines))
    if args.check:
        wanted = args.check.read_text().split("\n")
        differing = [line for line in lines if line not in wanted]
        print(f"{len(differing)} of {len(lines)} differ from {args.check}", file=sys.stderr)
        sys.exit(1 if differing else 0)
