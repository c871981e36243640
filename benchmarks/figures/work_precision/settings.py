"""The settings of `work_precision`."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from benchmarks.rivals.methods import MODULES
from lsvib.figures.settings import FigureSettings, Unique

SCENES = (
    "stick_slip", "graze_above", "graze_below", "sprag_slip", "sprag_graze", "stiff_contact", "near_critical",
    "long_run",
)  # fmt: skip
METHODS = (
    "exact", "rk45", "dop853", "dop853_capped", "radau", "bdf", "lsoda", "lsoda_capped", "cvode_adams", "cvode_bdf",
    "cvode_bdf_capped", "diffrax_tsit5", "diffrax_dopri8", "diffrax_dopri8_capped", "diffrax_kvaerno5", "heyoka",
    "smoothed", "rk4", "rk4_refined",
)  # fmt: skip
Controls = Annotated[list[Annotated[float, Field(ge=0, le=10)]], *Unique, Field(max_length=20)]


class Settings(FigureSettings):
    """Error against run time of the engine and of other methods."""

    timed: ClassVar = True
    needs: ClassVar = MODULES

    scenes: Annotated[list[Literal[*SCENES]], *Unique] = Field(min_length=1, description="Scenes to run.")
    shorten: float = Field(gt=0, le=1, description="Part of each scene's duration that is run [1].")
    methods: dict[Literal[*METHODS], Controls] = Field(
        description="Settings of each method, coarse to fine: relative tolerances [1], time steps [s] of rk4 and "
        "rk4_refined, widths [rad/s] of smoothed; [0] where there is nothing to set, [] to leave a method out."
    )
    repeats: int = Field(ge=1, le=1000, description="Rounds in which every method runs.")
    seconds: float = Field(ge=0, description="Run time after which a method is left out of further rounds [s].")
    limit: float = Field(gt=0, description="Run time after which a run is given up [s].")
    error_levels: Annotated[list[Annotated[float, Field(gt=0, le=1)]], *Unique] = Field(
        min_length=1, description="Errors of the final state at which run times are compared, coarse to fine [1]."
    )
    ratio_floor: float = Field(
        gt=0, description="Least ratio of run times, of general solvers that call a field in Python [1]."
    )
    compiled_floor: float = Field(gt=0, description="The same, of general solvers that compile the field [1].")
