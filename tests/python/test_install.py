"""The installed package: its page's lines, its files, its help, its builds.

Run against an installed wheel, as .ci/run does: what is imported is not this folder's.
"""

import contextlib
import doctest
import importlib.metadata
import importlib.util
import inspect
import io
import os
import pathlib
import pydoc
import re
import subprocess
import sys

import phalanx
import pytest

REPOSITORY = pathlib.Path(__file__).parents[2]
PAGE = REPOSITORY / "src/python/README.md"
CLASSES = [phalanx.Scene, phalanx.Hits, phalanx.AllHits]
MOST_IMPORT_SECONDS = 0.1
MOST_WORDS = 500


def python(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Runs some lines in a Python of their own."""
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def public_methods() -> list:
    """The documented attributes of all classes, with their names."""
    return [
        pytest.param(attribute, id=f"{owner.__name__}.{name}")
        for owner in CLASSES
        for name, attribute in vars(owner).items()
        if not name.startswith("_")
    ]


def test_the_page_is_short_and_its_lines_print_what_they_show() -> None:
    page = PAGE.read_text()
    assert len(page.split()) <= MOST_WORDS
    [(code, shown)] = re.findall(r"```python\n(.*?)```\n+```text\n(.*?)```", page, re.DOTALL)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(code, {})
    assert printed.getvalue() == shown


@pytest.mark.parametrize("first", ["", "import numpy"])
def test_import_is_quick(first: str) -> None:
    code = f"{first}\nimport time\nt = time.perf_counter()\nimport phalanx\n"
    code += "print(time.perf_counter() - t)"
    # The least of several: others use this machine, too.
    seconds = min(float(python(code).stdout) for _ in range(5))
    assert seconds <= MOST_IMPORT_SECONDS


def test_the_wheel_has_types_and_no_strangers() -> None:
    files = importlib.metadata.files("phalanx-rt")
    assert files is not None
    names = {str(file) for file in files}
    assert {"phalanx/__init__.pyi", "phalanx/py.typed", "phalanx/_phalanx.abi3.so"} <= names
    strangers = [name for name in names if not name.startswith(("phalanx/", "phalanx_rt-"))]
    assert not strangers
    assert importlib.metadata.version("phalanx-rt") == phalanx.__version__


@pytest.mark.parametrize("attribute", public_methods())
def test_attributes_are_documented_with_signatures(attribute: object) -> None:
    assert inspect.getdoc(attribute)
    if callable(attribute):
        assert "Ellipsis" not in str(inspect.signature(attribute))


@pytest.mark.parametrize("thing", [*CLASSES, phalanx.isa], ids=lambda thing: thing.__name__)
def test_help_fits_a_terminal_of_80_columns(thing: object) -> None:
    lines = pydoc.plain(pydoc.render_doc(thing, title="Help on %s")).splitlines()
    # Signatures are one line each, as pydoc writes them.
    prose = [line for line in lines if not re.search(r"\w+\(.*\)( from .*)?$", line)]
    assert [line for line in prose if len(line) > 80] == []


def test_help_of_the_package_begins_within_80_columns() -> None:
    text = pydoc.plain(pydoc.render_doc(phalanx, title="Help on %s"))
    lines = text.split("PACKAGE CONTENTS")[0].splitlines()
    assert len(lines) > 5
    assert [line for line in lines if len(line) > 80] == []


def test_examples_in_docstrings_print_what_they_show() -> None:
    runner = doctest.DocTestRunner()
    for test in doctest.DocTestFinder().find(phalanx.Scene, "Scene", globs={}):
        runner.run(test)
    assert runner.tries > 3
    assert runner.failures == 0


def test_a_level_can_be_asked_for() -> None:
    here = python("import phalanx; print(phalanx.isa())", PHALANX_LEVEL=phalanx.isa())
    assert here.stdout == f"{phalanx.isa()}\n"


def test_a_level_that_is_not_there_is_an_import_error() -> None:
    failed = python("import phalanx", PHALANX_LEVEL="x86-64-v9")
    last = failed.stderr.splitlines()[-1]
    assert last.startswith("ImportError: PHALANX_LEVEL is x86-64-v9, but there ")
    assert phalanx.isa() in last


def test_builds_are_in_folders_named_like_their_levels() -> None:
    package = pathlib.Path(phalanx.__file__).parent
    levels = [folder.name[1:].replace("_", "-") for folder in package.glob("_x86_64_v*")]
    for level in levels:
        asked = python("import phalanx; print(phalanx.isa())", PHALANX_LEVEL=level)
        assert asked.stdout == f"{level}\n" or "which this CPU lacks" in asked.stderr


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not here")
def test_the_stub_is_true(tmp_path: pathlib.Path) -> None:
    command = [sys.executable, "-m", "mypy.stubtest", "phalanx"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
