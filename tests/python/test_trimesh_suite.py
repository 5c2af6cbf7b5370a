"""trimesh's own tests of rays, with our intersector in place of both of theirs.

TRIMESH names a folder with trimesh's `tests` and `models`, as a clone of its repository has.
"""

import os
import pathlib
import re
import subprocess
import sys

import pytest

pytest.importorskip("trimesh")

# The tests of rays, and of what casts rays for other ends.
FILES = ("ray", "ray_upstream", "mesh", "proximity", "thickness", "voxel", "primitives", "medial")


def test_trimeshs_own_tests_pass():
    source = os.environ.get("TRIMESH")
    if source is None:
        pytest.skip("TRIMESH names no folder with trimesh's tests and models")
    files = [f"tests/test_{name}.py" for name in FILES]
    command = [sys.executable, "-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider"]
    here = str(pathlib.Path(__file__).parent)
    paths = os.pathsep.join([here, *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [*command, "-p", "trimesh_plugin", *files],
        cwd=source,
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
    )
    print(done.stdout[-4000:])
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    passed = re.search(r"(\d+) passed", done.stdout)
    assert passed and int(passed[1]) >= 29
