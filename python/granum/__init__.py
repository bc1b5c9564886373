"""The discrete element laboratory granum for Python: the same cases, the same bits and the same errors as the program.

>>> import granum
>>> case = granum.Case(grains={"count": 60}, preparation={"solid_fraction": "none", "unbalanced_force": 0.05})
>>> case["grains.count"]
60.0
"""

import os as _os
import sys as _sys

if "free-threading" in _sys.version:
    raise ImportError(
        "granum does not support free-threaded builds of CPython: it has not been tested with one; use the usual CPython of the same "
        "version (python3.14, not python3.14t)"
    )

from ._granum import _entered

# Before anything else, since an interpreter beside the first one of a process is refused.
_entered()

from . import calibration, campaigns, grainlearning, surrogates
from ._granum import (
    Assembly,
    Case,
    Comparison,
    Dataset,
    MaterialPoint,
    PointState,
    Recorder,
    Run,
    Simulation,
    Table,
    laboratory,
    measure,
    pair,
    paths,
    prepare,
    read,
    resume,
    run,
    schema,
    template,
    write,
)
from ._granum import __version__, _forked
from ._granum import open as open
from ._plots import compare
from ._progress import ProgressLine
from ._view import View, view
from .calibration import Posterior, calibrate
from .campaigns import Campaign, linear, log
from .errors import CaseError, Error, FileError, InternalError, Mistake, RunError, RunWarning
from .sensors import Bins, Sensor, SensorColumn

__all__ = [
    "Assembly",
    "Bins",
    "Campaign",
    "Case",
    "CaseError",
    "Comparison",
    "Dataset",
    "Error",
    "FileError",
    "InternalError",
    "MaterialPoint",
    "Mistake",
    "PointState",
    "Posterior",
    "ProgressLine",
    "Recorder",
    "Run",
    "RunError",
    "RunWarning",
    "Sensor",
    "SensorColumn",
    "Simulation",
    "Table",
    "View",
    "__version__",
    "calibrate",
    "calibration",
    "campaigns",
    "compare",
    "grainlearning",
    "laboratory",
    "linear",
    "log",
    "measure",
    "open",
    "pair",
    "paths",
    "prepare",
    "read",
    "resume",
    "run",
    "schema",
    "surrogates",
    "template",
    "view",
    "write",
]

# Threads do not survive a fork: a child that was forked while granum was at work is told so instead of waiting for them for ever.
if hasattr(_os, "register_at_fork"):
    _os.register_at_fork(after_in_child=_forked)
