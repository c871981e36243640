"""The names of the package for type checkers; ``__init__.py`` loads them on first use."""

from lsvib.api import NutDrive as NutDrive
from lsvib.api import RigidDrive as RigidDrive
from lsvib.api import SupportDrive as SupportDrive
from lsvib.api import ThreadsDrive as ThreadsDrive
from lsvib.basins.clipping import Window as Window
from lsvib.basins.exact_basin import Basin as Basin
from lsvib.basins.grid import Axis as Axis
from lsvib.basins.grid import Grid as Grid
from lsvib.basins.resilience import Resilience as Resilience
from lsvib.cycles.attractors import Attractor as Attractor
from lsvib.cycles.attractors import SteadyState as SteadyState
from lsvib.cycles.continuation import CycleBranch as CycleBranch
from lsvib.cycles.periodic import Cycle as Cycle
from lsvib.data.cycles import Cycles as Cycles
from lsvib.data.simulation import simulate as simulate
from lsvib.drives.scene import Scene as Scene
from lsvib.errors import DivergenceError as DivergenceError
from lsvib.errors import EngineError as EngineError
from lsvib.errors import InputError as InputError
from lsvib.errors import LsvibError as LsvibError
from lsvib.errors import NoThreshold as NoThreshold
from lsvib.results import Condition as Condition
from lsvib.results import Quantity as Quantity
from lsvib.results import SolvedThreshold as SolvedThreshold
from lsvib.results import StabilityReport as StabilityReport
from lsvib.results import Threshold as Threshold
from lsvib.results import ThresholdSolution as ThresholdSolution
from lsvib.results import UndampedStability as UndampedStability
from lsvib.steady_sliding.stability_table import stability_table as stability
from lsvib.steady_sliding.threshold_table import threshold_table as thresholds

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
    "stability",
    "thresholds",
]

__version__: str
