"""arcmin: accuracy of RV (cycloidal) reducers over their life, and its limiting causes.

>>> import arcmin
>>> design = arcmin.Design.template("rv-40e")
>>> design["crankshafts.eccentricity_mm"]
1.3
>>> result = arcmin.contact(design, torque_nm=412)
>>> result.tables["contact"]["force_n"].max() == result.max_force_n
True

A design is read from its file (:class:`Design`); every analysis of the ``arcmin`` command is a function here,
with the same options, results identical to the bit and the same messages. Units are at the end of every
name.
"""

from arcmin import _analyses
from arcmin._analyses import *
from arcmin._arcmin import Design, Flank, Key, Simulation, State, Table, __version__, sample
from arcmin._errors import (
    ArcminError,
    ComputeError,
    DesignError,
    InputError,
    OptionError,
    UnknownKeyError,
)
from arcmin._explore import Explorer, explore
from arcmin._results import Result, Verdict
from arcmin._robot import RobotResult, robot
from arcmin._study import StudyResult, study

__all__ = [
    "ArcminError",
    "ComputeError",
    "Design",
    "DesignError",
    "Explorer",
    "Flank",
    "InputError",
    "Key",
    "OptionError",
    "Result",
    "RobotResult",
    "Simulation",
    "State",
    "StudyResult",
    "Table",
    "UnknownKeyError",
    "Verdict",
    "__version__",
    "explore",
    "robot",
    "sample",
    "study",
]
__all__ += _analyses.__all__
