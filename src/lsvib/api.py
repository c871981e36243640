"""All that can be asked of a drive: the methods that drives get when this module is loaded.

A method does what the command of the same name does, by the same function. What a question needs is loaded when it is
asked: making a drive, or asking for its stability, loads no engine.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

from lsvib.errors import InputError
from lsvib.models.drive import Drive, NutDrive, RigidDrive, SupportDrive, ThreadsDrive
from lsvib.models.mechanics import Coefficients, coefficients
from lsvib.models.model import find_model
from lsvib.numbers import Progress
from lsvib.results import SolvedThreshold, StabilityReport, Threshold

if TYPE_CHECKING:
    import xarray as xr

    from lsvib.basins.boundary import Basin
    from lsvib.basins.curves import Window
    from lsvib.basins.grid import Grid
    from lsvib.basins.resilience import Resilience
    from lsvib.datasets.cycles import Cycles
    from lsvib.dynamics.attractor import SteadyState
    from lsvib.dynamics.continuation import CycleBranch
    from lsvib.dynamics.cycles import Cycle
    from lsvib.engine.automaton import Automaton
    from lsvib.models.scene import Scene

__all__ = ["DriveMethods", "NutDrive", "RigidDrive", "SupportDrive", "ThreadsDrive", "drive_class"]

if TYPE_CHECKING:
    _Base = Drive
else:
    _Base = object  # the methods go to the class Drive itself, below


class DriveMethods(_Base):
    """What can be asked of a drive of any model."""

    @property
    def coefficients(self) -> Coefficients:
        """Coefficients of the equations of motion (8.13)–(8.17) of the rigid drive with these parameters, to 50 digits.

        >>> import lsvib
        >>> lsvib.RigidDrive(mass=11).coefficients.paradox
        True
        """
        return coefficients(self)

    def stability(self) -> StabilityReport:
        """Return the linear stability of steady sliding (eqs 8.18–8.21).

        Raises ``InputError`` if the contact carries no force.

        >>> import lsvib
        >>> report = lsvib.RigidDrive(mass=11).stability()
        >>> report.stable, report.kind, report.conditions["kinematic_constraint"].hold
        (False, 'saddle', True)
        """
        from lsvib.stability.stability_table import stability_table

        return StabilityReport.of(stability_table(self, self.model))

    def thresholds(self) -> dict[str, Threshold]:
        """Return the thresholds of this very drive by name.

        Of the rigid model the critical mass and friction and the forces of Sects 8.5 to 8.7 (all other parameters are
        this drive's), of another the boundaries of stability in mass, friction and the damping that it adds. The force
        of global stability, which a rigid drive has in the Painlevé region, loads the engine. Raises ``InputError`` if
        the contact carries no force.

        >>> import lsvib
        >>> mass = lsvib.RigidDrive().thresholds()["critical_mass"]
        >>> f"{mass.value:.6f} {mass.unit}"
        '10.106965 kg'
        """
        from lsvib.stability.threshold_table import threshold_table

        return Threshold.by_name(threshold_table(self, self.model))

    def threshold(self, name: str, unknown: str | None = None) -> SolvedThreshold:
        """Return a threshold of this drive, solved for one of its parameters, with the derivatives by all others.

        ``name``: onset, kinematic (Γ₊ = 0), of the rigid model negative_damping (C₊ = 0), stick, detach,
        global_stability, fold, cycle_birth, rest_loss, of the others flutter; docs/thresholds.md has their equations.
        ``unknown``: any parameter, by default axial_force, or mass or support_damping where the threshold is usually
        one of these; the drive's own value of it counts only as the middle of a search. Raises ``InputError`` for
        another name, ``NoThreshold`` where there is no solution in the allowed range.

        >>> import lsvib
        >>> drive = lsvib.RigidDrive(mass=11, support_damping=2e-3)
        >>> drive.threshold("kinematic_constraint", unknown="mass").value
        10.106965213139869
        >>> force = drive.threshold("global_stability")
        >>> f"{force.value:.12g} {force.unit}, and {force.derivatives['mass'].value:.6g} N/kg"
        '-18.3754629689 N, and -1.63148 N/kg'
        """
        from lsvib.stability.threshold import solve_threshold

        return solve_threshold(self, name, unknown)

    def automaton(self, *, physics: Sequence[str] | None = None, resume: str = "contact_sign") -> "Automaton":
        """Return the tables that the engine runs; made once, and shared: do not change them.

        ``physics``: the terms as in a scene, by default those that are not zero, and rest; ``resume``: the rule of
        resuming after a seizure, contact_sign or at_once (:mod:`lsvib.models.rigid`). Raises ``InputError``.

        >>> import lsvib
        >>> lsvib.RigidDrive().automaton().states
        ('angle_deviation', 'velocity_deviation')
        """
        scene = self._scene({"u": 0.0, "w": 0.0}, 1.0, physics=physics, resume=resume)
        return scene.definition.build(self, scene.terms, scene.resume)

    def simulate(
        self,
        start: Mapping[str, float],
        duration: float,
        *,
        samples: int = 1001,
        resume: str = "contact_sign",
        physics: Sequence[str] | None = None,
        outputs: Sequence[str] = ("normal_force", "coupling_torque"),
    ) -> "xr.Dataset":
        """Return the exact motion from a start, with its events.

        Arguments: ``start``, u [rad], w [rad/s], and what else the model has, by name; ``duration`` [s]; number of
        ``samples``, both ends included; ``resume`` and ``physics`` as of :meth:`automaton`; ``outputs``, observables to
        store. The dataset is that of :func:`lsvib.simulate`. Raises ``InputError``, ``EngineError``.

        >>> import lsvib
        >>> drive = lsvib.RigidDrive(mass=11, support_damping=1e-3, axial_force=-10)
        >>> motion = drive.simulate({"u": 0.1, "w": 0.0}, 0.1)
        >>> motion.sizes["time"], motion.sizes["event"], motion.normal_force.units
        (1001, 12, 'N')
        """
        from lsvib.datasets.motion import run, trajectory

        scene = self._scene(start, duration, samples=samples, resume=resume, physics=physics, outputs=outputs)
        return trajectory(scene, run(scene))

    def steady_state(
        self, start: Mapping[str, float], *, resume: str = "contact_sign", physics: Sequence[str] | None = None
    ) -> "SteadyState":
        """Return the attractor that the motion from a start reaches; arguments as of :meth:`simulate`.

        Its ``label`` is an :class:`lsvib.Attractor`; ``period`` [s] and ``amplitude`` [rad], half the peak-to-peak of
        u, are exact. Raises ``InputError``, ``EngineError``.

        >>> import lsvib
        >>> drive = lsvib.RigidDrive(mass=11, support_damping=1e-3, axial_force=-10)
        >>> found = drive.steady_state({"u": 0.1, "w": 0.0})
        >>> found.label.name, f"{found.amplitude:.6f} rad, {found.period:.6f} s"
        ('SPRAG_SLIP_CYCLE', '0.055997 rad, 0.010944 s')
        """
        from lsvib.dynamics.attractor import steady_state
        from lsvib.engine.motion import enter

        scene = self._scene(start, 1.0, resume=resume, physics=physics)
        automaton = scene.definition.build(self, scene.terms, scene.resume)
        state = scene.definition.initial_state(self, scene.start)
        enter(automaton, state)  # refuses what is no state
        return steady_state(automaton, state)

    def cycles(self, *, resume: str = "contact_sign", physics: Sequence[str] | None = None) -> "Cycles":
        """Return the cycles of the drive that are found, attracting ones first, repelling ones as well.

        Arguments as of :meth:`automaton`. Each of ``cycles`` has period, itinerary, extremes, means, work, impulses and
        Floquet multipliers with a bound of their error (see docs/cycles.md); ``proved`` says what else is certain,
        ``searched`` where cycles were looked for. Raises ``InputError``, ``EngineError``.

        >>> import lsvib
        >>> found = lsvib.RigidDrive(mass=11, support_damping=2e-3, axial_force=-18.37).cycles()
        >>> [(cycle.attracting, f"{cycle.multipliers[0].real:.6f}") for cycle in found.cycles]
        [(True, '0.745892'), (False, '1.557142')]
        """
        from lsvib.datasets.cycles import find_cycles

        return find_cycles(self, self.automaton(resume=resume, physics=physics))

    def follow(
        self,
        cycle: "Cycle",
        parameter: str,
        span: tuple[float, float],
        *,
        resume: str = "contact_sign",
        physics: Sequence[str] | None = None,
        points: int = 1000,
    ) -> "CycleBranch":
        """Follow a cycle of this drive over a parameter, both ways, through folds, as far as it goes within a span.

        Arguments: one of :meth:`cycles`; name of the parameter; its smallest and largest value [SI unit], with this
        drive's own between them; ``resume`` and ``physics`` as of :meth:`automaton`; most ``points`` each way. Raises
        ``InputError`` for a parameter or span that is not acceptable.

        >>> import lsvib
        >>> drive = lsvib.RigidDrive(mass=11, support_damping=2e-3, axial_force=-18.37)
        >>> branch = drive.follow(drive.cycles().cycles[0], "axial_force", (-18.5, -18.35))
        >>> [f"{force:.10f} N" for force in branch.folds]
        ['-18.3754629689 N']
        """
        from lsvib.datasets.cycles import followed

        return followed(
            self, cycle, parameter, span, points, lambda drive: drive.automaton(resume=resume, physics=physics)
        )

    def chart(
        self,
        x: "str | tuple[str, float, float, int]",
        y: "str | tuple[str, float, float, int]",
        *,
        resume: str = "contact_sign",
        workers: int = 1,
        progress: Progress | None = None,
    ) -> "xr.Dataset":
        """Return what the drive does over two of its parameters, with the exact curves that divide the chart.

        For rigid drives and those with compliant threads (docs/charts.md). Arguments: ``x`` and ``y``, each (parameter,
        start, stop, number of cells) in SI units, or such text as "mass=1:20:400"; ``resume`` as of :meth:`automaton`;
        number of ``workers``, which changes no label; ``progress``, called with numbers of motions done and in all.
        Raises ``InputError``, ``EngineError``.

        >>> import lsvib
        >>> found = lsvib.RigidDrive(translation_damping=1000).chart(("mass", 1, 9, 4), ("axial_force", 0, 60, 4))
        >>> names = found.label.flag_meanings.split()
        >>> [names[label + 1] for label in found.label.sel(mass=2).values]
        ['no_vibration', 'pure_slip', 'pure_slip', 'stick_slip_with_contact_reversal']
        """
        from lsvib.datasets.chart import chart

        return chart(self, x, y, resume, workers, progress)

    def sweep(
        self,
        *,
        start: Mapping[str, float] | None = None,
        resume: str = "contact_sign",
        workers: int = 1,
        progress: Progress | None = None,
        **over: Sequence[float],
    ) -> "xr.Dataset":
        """Return what the drive ends on over values of some of its parameters, as a dataset.

        Arguments: ``over``, values [SI units] of each parameter by its name, all combinations of them; ``start``,
        u [rad], w [rad/s] and what else the model has, by default next to steady sliding; ``resume`` as of
        :meth:`automaton`; number of ``workers``, threads or processes, which changes no number; ``progress``, called
        with the numbers of points done and in all. Variables: attractor, amplitude [rad], period [s], multiplier [1],
        peak_normal_force [N], peak_normal_impulse [N s]. Raises ``InputError``, ``EngineError``.

        >>> import lsvib
        >>> found = lsvib.RigidDrive(translation_damping=1000).sweep(axial_force=[10, 30, 60])
        >>> [lsvib.Attractor(int(kind)).name for kind in found.attractor]
        ['STEADY_SLIDING', 'OTHER_CYCLE', 'STICK_SLIP_CYCLE']
        """
        from lsvib.datasets.sweep import sweep

        return sweep(self, over, start, resume, workers, progress)

    def attraction(
        self,
        grid: "Grid | Mapping[str, Any]",
        *,
        quantities: Sequence[str] = ("label",),
        resume: str = "contact_sign",
        workers: int = 1,
        progress: Progress | None = None,
    ) -> "xr.Dataset":
        """Return the map of the attractors that motions reach from every cell of a grid.

        Arguments: ``grid``, two axes by coordinate, each (start, stop, count) in SI units, and values of others, as
        ``{"u": (-0.1, 0.1, 40), "w": (-80, 80, 30)}``; ``quantities`` of label, time [s] (stored as settling_time),
        seizures, first_event, doubt (why a label is unresolved; the label is always there); ``resume`` as of
        :meth:`automaton`; number of ``workers``, which changes no number; ``progress``, called with the numbers of
        rows done and in all. Raises ``InputError``, ``EngineError``.

        >>> import lsvib
        >>> drive = lsvib.RigidDrive(mass=11, support_damping=1e-3, axial_force=-10)
        >>> found = drive.attraction({"u": (-0.1, 0.1, 40), "w": (-80, 80, 30)})
        >>> found.label.shape, f"{found.basin_area.item():.4f} {found.basin_area.units}"
        ((30, 40), '0.9553 rad2 s-1')
        """
        from lsvib.datasets.map import map_attraction

        return map_attraction(self, grid, quantities, resume, workers, progress).dataset

    def _scene(self, start: Mapping[str, float], duration: float, **more: Any) -> "Scene":
        from lsvib.models.scene import Scene

        return Scene(model=self.model, drive=self, start=start, duration=duration, **more)

    def basin(self) -> "Basin":
        """Return the region of attraction of steady sliding, bounded in closed form; its areas are in rad²/s.

        Raises ``InputError`` for other models than the rigid one, where steady sliding attracts nothing, and for the
        few drives that docs/basin.md lists; ``EngineError`` where the engine cannot follow the boundary.

        >>> import lsvib
        >>> basin = lsvib.RigidDrive(mass=11, support_damping=1e-3, axial_force=-10).basin()
        >>> basin.boundary.name, basin.contains((0.0, 0.0)), basin.contains((0.1, 0.0))
        ('TOUCHING_MOTION', True, False)
        """
        from lsvib.basins.boundary import basin

        return basin(_rigid(self))

    def resilience(self, window: "Window | Mapping[str, tuple[float, float]] | None" = None) -> "Resilience":
        """Return the largest perturbations that steady sliding tolerates, and the share of a window that settles.

        All is exact, from the boundary of the basin (docs/basin.md). ``window``: ends of u [rad] and w [rad/s].
        The perturbations are in ``angle`` [rad], ``speed`` [rad/s] and ``energy`` [J]; infinite where all of them are
        tolerated, zero where steady sliding is unstable. Raises ``InputError``, ``EngineError`` as :meth:`basin` does.

        >>> import lsvib
        >>> drive = lsvib.RigidDrive(mass=11, support_damping=1e-3, axial_force=-10)
        >>> found = drive.resilience({"u": (-0.3, 0.3), "w": (-150, 150)})
        >>> f"{found.angle:.6g} rad, {found.speed:.6g} rad/s, {found.energy:.6g} J, {found.fraction:.6g}"
        '0.0223138 rad, 7.46627 rad/s, 0.000154064 J, 0.00530736'
        """
        from lsvib.basins.resilience import resilience
        from lsvib.datasets.sweep import window_of

        return resilience(_rigid(self), window_of(window))

    def resilience_sweep(
        self,
        window: "Window | Mapping[str, tuple[float, float]] | None" = None,
        *,
        progress: Progress | None = None,
        **over: Sequence[float],
    ) -> "xr.Dataset":
        """Return the perturbations that steady sliding tolerates over values of some parameters, as a dataset.

        Arguments: as of :meth:`resilience`; ``over``, values [SI units] of each parameter by its name, all combinations
        of them; ``progress``, called with the numbers of points done and in all. Variables: fatal_angle [rad],
        fatal_speed [rad/s], fatal_energy [J], with a window basin_fraction [1]; nan where the basin
        is not covered. Raises ``InputError``.

        >>> import lsvib
        >>> drive = lsvib.RigidDrive(mass=11, support_damping=1e-3)
        >>> found = drive.resilience_sweep(axial_force=[-40, -20, -10])
        >>> [f"{energy:.3g}" for energy in found.fatal_energy.values]
        ['inf', '0.000616', '0.000154']
        """
        from lsvib.datasets.sweep import resilience_sweep, window_of

        return resilience_sweep(_rigid(self), over, window_of(window), progress)


def drive_class(model: str) -> type[DriveMethods]:
    """Return the class of the drives of a model; raises ``InputError`` if there is none of that name."""
    return cast(type[DriveMethods], find_model(model).drive)


def _rigid(drive: Drive) -> RigidDrive:
    """Return a drive that is rigid; raises ``InputError`` for other ones."""
    if not isinstance(drive, RigidDrive):
        raise InputError(
            f"the basin has a closed form for the rigid drive only; attraction maps that of model {drive.model}."
        )
    return drive


for _name, _method in vars(DriveMethods).items():
    if not _name.startswith("__"):
        setattr(Drive, _name, _method)
