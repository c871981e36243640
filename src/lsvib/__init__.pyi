"""The public names of the package and where they live; lazy_loader loads each on first use."""

from .api import Drive as Drive
from .api import Scene as Scene
from .api import simulate as simulate
from .basins.boundary import Basin as Basin
from .basins.curves import Window as Window
from .basins.grid import Axis as Axis
from .basins.grid import Grid as Grid
from .basins.resilience import Resilience as Resilience
from .datasets.cycles import Cycles as Cycles
from .dynamics.attractor import Attractor as Attractor
from .dynamics.attractor import SteadyState as SteadyState
from .dynamics.continuation import CycleBranch as CycleBranch
from .dynamics.drive_cycles import Cycle as Cycle
from .errors import DivergenceError as DivergenceError
from .errors import EngineError as EngineError
from .errors import InputError as InputError
from .errors import LsvibError as LsvibError
from .errors import NoThreshold as NoThreshold
from .pictures.answers import draw as draw
from .pictures.answers import open as open
from .results import Condition as Condition
from .results import Derivative as Derivative
from .results import Quantity as Quantity
from .results import StabilityReport as StabilityReport
from .results import Threshold as Threshold
from .results import ThresholdSolution as ThresholdSolution

__version__: str
