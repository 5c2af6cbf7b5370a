"""The build for this CPU: the x86-64 wheel contains one for each instruction set level."""

import importlib
import os

# Highest first. The build for plain x86-64, or the only one, is the module next to this file.
_LEVELS = ("x86-64-v4", "x86-64-v3")


def _folder(level):
    return "_" + level.replace("-", "_")


def load():
    """Imports the build named by PHALANX_LEVEL, or the highest that this CPU supports."""
    from . import _phalanx as least

    # Without pathlib, which would take half of the time of `import phalanx`.
    here = os.path.dirname(__file__)
    there = [level for level in _LEVELS if os.path.isdir(os.path.join(here, _folder(level)))]
    asked = os.environ.get("PHALANX_LEVEL")
    if asked == least.isa():
        return least
    if asked:
        if asked not in there:
            names = ", ".join([*there, least.isa()])
            raise ImportError(f"PHALANX_LEVEL is {asked}, but there are builds for {names} only")
        # Checked here, because the build's first instruction may be one that the CPU lacks.
        if asked > least.cpu_level():
            cpu = least.cpu_level()
            raise ImportError(f"PHALANX_LEVEL is {asked}, which this CPU lacks: it is {cpu}")
        return importlib.import_module(f"phalanx.{_folder(asked)}._phalanx")
    # Level names sort in the order of the levels.
    fit = [level for level in there if level <= least.cpu_level()]
    return importlib.import_module(f"phalanx.{_folder(fit[0])}._phalanx") if fit else least
