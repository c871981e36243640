"""The public names of the package and where they live; lazy_loader loads each on first use."""

from .answers.cycles import Cycles as Cycles
from .api import Drive as Drive
from .api import Scene as Scene
from .api import simulate as simulate
from .dynamics.boundary import Basin as Basin
from .dynamics.curves import Window as Window
from .dynamics.cycles import Cycle as Cycle
from .dynamics.resilience import Resilience as Resilience
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
from .sheets.fit_output import fit as fit
from .sheets.output import assess as assess
from .systems.attractor import Attractor as Attractor
from .systems.attractor import SteadyState as SteadyState
from .systems.continuation import CycleBranch as CycleBranch
from .systems.grid import Axis as Axis
from .systems.grid import Grid as Grid

__version__: str
