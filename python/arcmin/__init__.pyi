# Written by python/tools/stubs.py.

from arcmin._analyses import (
    CalibrateResult as CalibrateResult,
    CheckResult as CheckResult,
    ContactResult as ContactResult,
    LifeResult as LifeResult,
    ProfileResult as ProfileResult,
    RigResult as RigResult,
    SimulateResult as SimulateResult,
    Tao2024Result as Tao2024Result,
    WearResult as WearResult,
    calibrate as calibrate,
    check as check,
    contact as contact,
    life as life,
    profile as profile,
    rig as rig,
    simulate as simulate,
    tao2024 as tao2024,
    wear as wear,
)
from arcmin._arcmin import (
    Design as Design,
    Flank as Flank,
    Key as Key,
    Simulation as Simulation,
    State as State,
    Table as Table,
    __version__ as __version__,
    sample as sample,
)
from arcmin._errors import (
    ArcminError as ArcminError,
    ComputeError as ComputeError,
    DesignError as DesignError,
    InputError as InputError,
    OptionError as OptionError,
    UnknownKeyError as UnknownKeyError,
)
from arcmin._explore import (
    Explorer as Explorer,
    explore as explore,
)
from arcmin._results import (
    Result as Result,
    Verdict as Verdict,
)
from arcmin._robot import (
    RobotResult as RobotResult,
    robot as robot,
)
from arcmin._study import (
    StudyResult as StudyResult,
    study as study,
)

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
    "check",
    "CheckResult",
    "profile",
    "ProfileResult",
    "contact",
    "ContactResult",
    "wear",
    "WearResult",
    "calibrate",
    "CalibrateResult",
    "simulate",
    "SimulateResult",
    "rig",
    "RigResult",
    "life",
    "LifeResult",
    "tao2024",
    "Tao2024Result",
]
