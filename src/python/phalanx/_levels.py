"""The build for this CPU: the wheel for x86-64 holds one for each level of instruction sets."""

import importlib
import os

# Highest first. The build for plain x86-64, or the only one, is the module beside this file.
_LEVELS = ("x86-64-v4", "x86-64-v3")


def _folder(level):
    return "_" + level.replace("-", "_")


def load():
    """Imports the build that PHALANX_LEVEL names, or the highest that this CPU runs."""
    from . import _phalanx as least

    # Not by pathlib, which would take half of the time of `import phalanx`.
    here = os.path.dirname(__file__)
    there = [level for level in _LEVELS if os.path.isdir(os.path.join(here, _folder(level)))]
    asked = os.environ.get("PHALANX_LEVEL")
    if asked == least.isa():
        return least
    if asked:
        if asked not in there:
            names = ", ".join([*there, least.isa()])
            raise ImportError(f"PHALANX_LEVEL is {asked}, but there are builds for {names} only")
        # Not left to the build itself: its first instruction may be one that the CPU lacks.
        if asked > least.cpu_level():
            cpu = least.cpu_level()
            raise ImportError(f"PHALANX_LEVEL is {asked}, which this CPU lacks: it is {cpu}")
        return importlib.import_module(f"phalanx.{_folder(asked)}._phalanx")
    # Names of levels grow with the level.
    fit = [level for level in there if level <= least.cpu_level()]
    return importlib.import_module(f"phalanx.{_folder(fit[0])}._phalanx") if fit else least
