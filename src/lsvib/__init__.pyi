"""The public names of the package and where they live; ``__init__.py`` loads each on first use."""

from lsvib.api import Drive as Drive
from lsvib.api import Scene as Scene
from lsvib.api import simulate as simulate
from lsvib.basins.boundary import Basin as Basin
from lsvib.basins.curves import Window as Window
from lsvib.basins.grid import Axis as Axis
from lsvib.basins.grid import Grid as Grid
from lsvib.basins.resilience import Resilience as Resilience
from lsvib.datasets.cycles import Cycles as Cycles
from lsvib.dynamics.attractor import Attractor as Attractor
from lsvib.dynamics.attractor import SteadyState as SteadyState
from lsvib.dynamics.continuation import CycleBranch as CycleBranch
from lsvib.dynamics.cycles import Cycle as Cycle
from lsvib.errors import DivergenceError as DivergenceError
from lsvib.errors import EngineError as EngineError
from lsvib.errors import InputError as InputError
from lsvib.errors import LsvibError as LsvibError
from lsvib.errors import NoThreshold as NoThreshold
from lsvib.figures.answers import draw as draw
from lsvib.figures.answers import open as open
from lsvib.results import Condition as Condition
from lsvib.results import Derivative as Derivative
from lsvib.results import PrintedValue as PrintedValue
from lsvib.results import Quantity as Quantity
from lsvib.results import StabilityReport as StabilityReport
from lsvib.results import Threshold as Threshold
from lsvib.results import ThresholdSolution as ThresholdSolution
from lsvib.results import UndampedStability as UndampedStability

__version__: str
