"""The names of the package for type checkers; ``__init__.py`` loads them on first use."""

from lsvib.api import DriveMethods
from lsvib.basins.boundary import Basin as Basin
from lsvib.basins.curves import Window as Window
from lsvib.basins.grid import Axis as Axis
from lsvib.basins.grid import Grid as Grid
from lsvib.basins.resilience import Resilience as Resilience
from lsvib.datasets.cycles import Cycles as Cycles
from lsvib.datasets.motion import simulate as simulate
from lsvib.dynamics.attractor import Attractor as Attractor
from lsvib.dynamics.attractor import SteadyState as SteadyState
from lsvib.dynamics.continuation import CycleBranch as CycleBranch
from lsvib.dynamics.cycles import Cycle as Cycle
from lsvib.errors import DivergenceError as DivergenceError
from lsvib.errors import EngineError as EngineError
from lsvib.errors import InputError as InputError
from lsvib.errors import LsvibError as LsvibError
from lsvib.errors import NoThreshold as NoThreshold
from lsvib.models import drive
from lsvib.models.scene import Scene as Scene
from lsvib.results import Condition as Condition
from lsvib.results import Quantity as Quantity
from lsvib.results import SolvedThreshold as SolvedThreshold
from lsvib.results import StabilityReport as StabilityReport
from lsvib.results import Threshold as Threshold
from lsvib.results import ThresholdSolution as ThresholdSolution
from lsvib.results import UndampedStability as UndampedStability

__all__ = [
    "Attractor",
    "Axis",
    "Basin",
    "Condition",
    "Cycle",
    "CycleBranch",
    "Cycles",
    "DivergenceError",
    "EngineError",
    "Grid",
    "InputError",
    "LsvibError",
    "NoThreshold",
    "NutDrive",
    "Quantity",
    "Resilience",
    "RigidDrive",
    "Scene",
    "SolvedThreshold",
    "StabilityReport",
    "SteadyState",
    "SupportDrive",
    "ThreadsDrive",
    "Threshold",
    "ThresholdSolution",
    "UndampedStability",
    "Window",
    "__version__",
    "simulate",
]

__version__: str

class RigidDrive(drive.RigidDrive, DriveMethods): ...
class ThreadsDrive(drive.ThreadsDrive, DriveMethods): ...
class SupportDrive(drive.SupportDrive, DriveMethods): ...
class NutDrive(drive.NutDrive, DriveMethods): ...
