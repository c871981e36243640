"""All questions that a drive answers, as its methods.

Each method does what the command of the same name does, through the same function. What it needs is loaded when it is
called: making a drive, or asking for its stability, loads no engine. The examples begin with ``import lsvib``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from lsvib.drives import drive
from lsvib.drives.automata import automaton_of
from lsvib.drives.mechanics import Coefficients, coefficients
from lsvib.drives.scene import Command, Scene
from lsvib.numbers import Progress
from lsvib.results import StabilityReport, Threshold

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from lsvib.answers.cycles import Cycles
    from lsvib.drives.description import Description
    from lsvib.dynamics.boundary import Basin
    from lsvib.dynamics.curves import Part
    from lsvib.dynamics.cycles import Cycle
    from lsvib.dynamics.resilience import Resilience
    from lsvib.systems import System
    from lsvib.systems.attractor import SteadyState
    from lsvib.systems.automaton import Automaton
    from lsvib.systems.continuation import CycleBranch
    from lsvib.systems.grid import Grid

    Values = Sequence[float] | np.ndarray  # of a parameter, in SI units

Start = Mapping[str, float] | Literal["rest"]  # coordinates of a start by name, in SI units
Terms = Sequence[str] | None  # of the equations of motion, by name

__all__ = ["Drive", "Scene", "simulate"]


class Drive(drive.Drive):
    __doc__ = drive.Drive.__doc__

    @property
    def coefficients(self) -> Coefficients:
        """Coefficients of the equations of motion (8.13)–(8.17) of the rigid drive, as balls of 150 digits.

        Slip under the friction law s = ±1 obeys Γ_s ü + C_s u̇ + k u = r_m (ξ_0 − ξ_s) R̃. The result, a
        :class:`lsvib.drives.mechanics.Coefficients`, has by s the effective inertia Γ_s [kg m²], the effective damping
        C_s [N m s/rad] and the friction factor ξ_s [1], and the load R̃ [N]. Raises ``InputError`` for Ω = 0. See also
        :meth:`stability`, which follows from them.

        >>> lsvib.Drive(mass=11).coefficients.paradox  # Γ₊ < 0
        True
        """
        return coefficients(self)

    def describe(self) -> Description:
        """Return parts, coordinates, equations of motion in SI numbers (:mod:`lsvib.drives.mechanism`) and modes.

        >>> print(*lsvib.Drive(mass=11, screw_mass=3, support_stiffness=1e6).describe().equations[:3], sep="\\n")
        3.12e-06 θ″ = − 1 z − 0.0002 θ′ − τ
        3 x_1″ = n − 1e+06 x_1
        11 x″ = 50 − n
        """
        from lsvib.drives.description import description_of

        return description_of(self)

    def system(self) -> System:
        """Return the drive as a :class:`lsvib.systems.System` in the chapter's symbols, to change and extend.

        Its states are z [rad] and w [rad/s], with θ′ = Omega + w; compliant threads add their mismatch e [m] and its
        rate v [m/s]. A start must be in a mode of its direction of slip. Raises ``InputError`` for parts and friction
        other than those of the threads, friction that depends on the speed, and a rigid drive that can seize. See also
        docs/systems.md.

        >>> lsvib.Drive(translation_damping=1000).system().steady_state("rest", {"w": -40}).period
        0.010671602920576643
        """
        from lsvib.drives.as_system import keys_of
        from lsvib.systems import System

        return System(**keys_of(self))

    def stability(self) -> StabilityReport:
        """Return the linear stability of steady sliding, u = u̇ = 0.

        With constant friction steady sliding of the rigid drive is unstable where Γ_0 < 0 or C_0 < 0 (eqs 8.18–8.21);
        in general, where the characteristic polynomial has a root with a positive real part. Signs are decided exactly.

        Returns the verdict and its kind, the eigenvalues [1/s], the conditions of instability with their margins, and
        quantities with units. Raises ``InputError`` if the contact carries no force (R̃ = 0), so that the friction law
        is not determined. See also :meth:`thresholds`, where stability changes; :meth:`resilience`, how far it reaches.

        >>> report = lsvib.Drive(mass=11).stability()
        >>> report.stable, report.kind, report.conditions["kinematic_constraint"].hold
        (False, 'saddle', True)
        """
        from lsvib.stability.conditions import stability

        return stability(self)

    def thresholds(self, unknown: str | None = None) -> dict[str, Threshold]:
        """Return all thresholds of this drive by name, each as :meth:`threshold` gives it.

        Each is solved for its usual parameter, or all for the parameter ``unknown``. A threshold that this drive does
        not have has no value but a ``reason``. Raises ``InputError`` for an unknown parameter, or if the contact
        carries no force. See also docs/thresholds.md, with their equations.

        >>> found = lsvib.Drive().thresholds()
        >>> mass = found["kinematic_constraint"]  # the critical mass (8.20)
        >>> f"{mass.value:.6f} {mass.unit}"
        '10.106965 kg'
        >>> found["stick"].reason
        'the effective damping of law + is not negative, so no axial force satisfies conditions (8.19).'
        """
        from lsvib.stability.starting import even_speed
        from lsvib.stability.threshold import all_thresholds

        return all_thresholds(self, unknown, even_speed)

    def threshold(self, name: str, unknown: str | None = None) -> Threshold:
        """Return a threshold of this drive, solved for one of its parameters, with derivatives by all others.

        Arguments: ``name``, a key of :meth:`thresholds`; ``unknown``, any parameter, by default the usual one of the
        threshold. The drive's own value of it matters only as the middle of a search. Returns the solutions and their
        derivatives [SI units], each enclosed with certainty by two doubles. Raises ``InputError`` for an unknown name,
        ``NoThreshold`` if there is no solution in the allowed range. See also docs/thresholds.md, with the equations.

        >>> drive = lsvib.Drive(mass=11, support_damping=2e-3)
        >>> critical = drive.threshold("kinematic_constraint", unknown="mass")
        >>> critical.value, critical.enclosure
        (10.106965213139869, (10.106965213139869, 10.10696521313987))
        >>> force = drive.threshold("global_stability")
        >>> f"{force.value:.12g} {force.unit}, and {force.derivatives['mass'].value:.6g} N/kg"
        '-18.3754629689 N, and -1.63148 N/kg'
        """
        from lsvib.stability.starting import even_speed
        from lsvib.stability.threshold import solve_threshold

        return solve_threshold(self, name, unknown, even_speed)

    def automaton(self, *, physics: Terms = None, resume: str = "contact_sign") -> Automaton:
        """Return the hybrid automaton of the drive: modes with linear fields, guards and resets, as tables of numbers.

        Arguments: ``physics``, the terms of the equations of motion, such as support_damping, axial_force and rest, by
        default those that are not zero, and rest (a damping or force that is not listed must be zero); ``resume``, how
        the motion continues after a seizure: contact_sign (the contact keeps the sign of the impulse) or, for the rigid
        drive, at_once (:mod:`lsvib.drives.modes`). Returns an :class:`lsvib.systems.automaton.Automaton`, shared by
        equal drives: do not change its tables. Raises ``InputError``. See also :meth:`system`, the same in equations.

        >>> lsvib.Drive().automaton().states
        ('u', 'w')
        """
        return self._automaton_and_state({"u": 0.0, "w": 0.0}, resume, physics)[0]

    def simulate(
        self,
        start: Start,
        duration: float,
        *,
        samples: int = 1001,
        resume: str = "contact_sign",
        physics: Terms = None,
        outputs: Sequence[str] = ("normal_force", "coupling_torque"),
        command: Command | Mapping[str, Any] | None = None,
    ) -> xr.Dataset:
        """Return the exact motion from a start, with its events.

        Between events the motion obeys Γ_s ü + C_s u̇ + k u = r_m (ξ_0 − ξ_s) R̃ (eq. 8.16; drives with parts have
        more such equations) and is sampled from its closed form. An event – reversal, loss of contact, seizure,
        sticking, release – is a root of a guard along the motion. There is no step size.

        Arguments:

        * ``start``: the deviation u [rad] from steady sliding, its rate w [rad/s] and the coordinates of parts, by
          name; or "rest": the screw is at rest and the coupling relaxed when the motor starts.
        * ``duration`` [s], and the number of ``samples``, equidistant in time, both ends included.
        * ``outputs``: observables to store besides the state, the mode and the events.
        * ``command``: the commanded speed in place of ``input_speed``, linear between ``speeds`` [rad/s] at ``times``
          [s]; deviations remain those from steady sliding at ``input_speed``.
        * ``resume``, ``physics``: as for :meth:`automaton`.

        Returns a dataset with u [rad], w [rad/s], the outputs and the mode over ``time`` [s], and over ``event`` the
        time, kind and impulse of each event and the states before and after it. Raises ``InputError``, and
        ``EngineError`` where events accumulate or the motion grows without bound. See also :func:`lsvib.simulate`, for
        a scene in a file; :meth:`steady_state`, where the motion ends.

        >>> drive = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
        >>> motion = drive.simulate({"u": 0.1, "w": 0.0}, 0.1)
        >>> motion.sizes["time"], motion.sizes["event"], motion.normal_force.units
        (1001, 12, 'N')
        >>> stops = drive.simulate("rest", 1.0, command={"times": [0, 0.2, 0.8], "speeds": [0, 40, 0]})
        >>> float(stops.w[-1]) == -drive.input_speed
        True
        """
        from lsvib.answers.motion import Simulation

        wanted = {"samples": samples, "resume": resume, "physics": physics, "outputs": outputs, "command": command}
        return Simulation.of(Scene.of({"drive": self, "start": start, "duration": duration, **wanted})).dataset()

    def steady_state(self, start: Start, *, resume: str = "contact_sign", physics: Terms = None) -> SteadyState:
        """Return the attractor that the motion from a start reaches.

        The Poincaré map on a section of the motion decides: a fixed point whose multipliers lie inside the unit circle
        is an attracting cycle.

        Arguments: ``start``, ``resume``, ``physics`` as for :meth:`simulate`. Returns the ``label``, an
        :class:`lsvib.Attractor`, and for a cycle its exact ``period`` [s] and ``amplitude`` [rad], half the
        peak-to-peak value of u. A motion that takes too many events is unresolved. Raises ``InputError``,
        ``EngineError``. See also :meth:`attraction`, for a grid of starts; :meth:`sweep`, for many drives;
        docs/attraction.md.

        >>> drive = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
        >>> found = drive.steady_state({"u": 0.1, "w": 0.0})
        >>> found.label.name, f"{found.amplitude:.6f} rad, {found.period:.6f} s"
        ('SPRAG_SLIP_CYCLE', '0.055997 rad, 0.010944 s')
        """
        from lsvib.systems.attractor import steady_state
        from lsvib.systems.motion import enter

        automaton, state = self._automaton_and_state(start, resume, physics)
        enter(automaton, state)  # refuses what is no state
        return steady_state(automaton, state)

    def cycles(self, *, physics: Terms = None) -> Cycles:
        """Search for the limit cycles of the drive, attracting and repelling.

        A cycle is a fixed point of a Poincaré map; its Floquet multipliers are those of the product of flows and
        saltation matrices along it (docs/cycles.md).

        Arguments: ``physics`` as for :meth:`automaton`. Returns the ``cycles``, attracting ones first, each with period
        [s], itinerary, extremes, means, work [J], impulses [N s, N m s] and multipliers with an error bound; ``proved``
        says what else is certain, ``searched`` where cycles were sought. Raises ``InputError``, ``EngineError``. See
        also :meth:`follow`, which follows one of them over a parameter.

        >>> found = lsvib.Drive(mass=11, support_damping=2e-3, axial_force=-18.37).cycles()
        >>> [(cycle.attracting, f"{cycle.multipliers[0].real:.6f}") for cycle in found.cycles]
        [(True, '0.745892'), (False, '1.557142')]
        """
        from lsvib.answers.cycles import find_cycles

        return find_cycles(self, self.automaton(physics=physics))

    def follow(
        self,
        cycle: Cycle,
        parameter: str,
        span: tuple[float, float],
        *,
        physics: Terms = None,
        points: int = 1000,
        progress: Progress | None = None,
    ) -> CycleBranch:
        """Follow a cycle of this drive over a parameter, both ways, through folds and changes of its events.

        Arguments:

        * ``cycle``: one of :meth:`cycles`.
        * ``parameter``, by name, and ``span``: its smallest and largest value [SI unit], which enclose the drive's own.
        * ``points``: at most so many each way; ``physics`` as for :meth:`automaton`.
        * ``progress``: called with the numbers of points done and of all.

        Returns the branch, found by pseudo-arclength continuation: its points, folds, changes of events and stability,
        and why it ends. Raises ``InputError``. See also :meth:`threshold`, whose values are enclosed with certainty;
        docs/cycles.md.

        >>> drive = lsvib.Drive(mass=11, support_damping=2e-3, axial_force=-18.37)
        >>> branch = drive.follow(drive.cycles().cycles[0], "axial_force", (-18.5, -18.35))
        >>> [f"{force:.10f} N" for force in branch.folds]
        ['-18.3754629689 N']
        """
        from lsvib.answers.cycles import followed

        return followed(self, cycle, parameter, span, points, lambda drive: drive.automaton(physics=physics), progress)

    def sweep(
        self, *, start: Start | None = None, workers: int = 1, progress: Progress | None = None, **over: Values
    ) -> xr.Dataset:
        """Return how the drive behaves over some of its parameters; over two, with the curves that divide the plane.

        Arguments:

        * ``over``: the values [SI units] of each parameter, by name; all their combinations are taken.
        * ``start``: as for :meth:`simulate`, of one motion of each drive. By default the motion starts beside steady
          sliding and, if it returns there, two others start far away and at rest.
        * ``workers``: the number of threads; ``progress``: called with the numbers of motions done and of all.

        Returns a dataset over the parameters with attractor, amplitude [rad], period [s], multiplier [1],
        peak_normal_force [N] and peak_normal_impulse [N s] of the motion beside steady sliding, or from ``start``;
        without a start also the ``behaviour`` and, over two parameters, points of the exact curves Γ₊ = 0, C₊ = 0 …
        that are known (docs/charts.md). Raises ``InputError``, ``EngineError``. See also :meth:`steady_state`, for one
        drive.

        >>> drive = lsvib.Drive(translation_damping=1000)
        >>> found = drive.sweep(axial_force=[10, 30, 60])
        >>> [lsvib.Attractor(int(kind)).name for kind in found.attractor]
        ['STEADY_SLIDING', 'OTHER_CYCLE', 'STICK_SLIP_CYCLE']
        >>> chart = drive.sweep(axial_force=[10, 30, 60], mass=[2, 12])
        >>> chart.behaviour.flag_meanings.split()[int(chart.behaviour.sel(axial_force=10, mass=12)) + 1]
        'vibration_from_rest'
        """
        from lsvib.answers.sweep import sweep

        return sweep(self, over, start, workers, progress)

    def attraction(
        self,
        grid: Grid | Mapping[str, Any],
        *,
        quantities: Sequence[str] = ("label",),
        workers: int = 1,
        progress: Progress | None = None,
    ) -> xr.Dataset:
        """Return a map of the attractors that motions from the cells of a grid reach.

        Arguments:

        * ``grid``: two coordinates, each (start, stop, count) in SI units, and values of others, as
          ``{"u": (-0.1, 0.1, 40), "w": (-80, 80, 30)}``; or a :class:`lsvib.Grid`.
        * ``quantities``: any of label, time [s] (stored as settling_time), seizures, first_event and doubt (why a label
          is unresolved); the label is always stored.
        * ``workers``, ``progress``: as for :meth:`sweep`; here rows of cells are counted.

        Returns a dataset over both coordinates with these quantities and, for a rigid drive, the exact boundary and
        area [rad²/s] of the region of attraction. Raises ``InputError``, ``EngineError``. See also :meth:`basin`, the
        exact boundary; :meth:`steady_state`, for one start; docs/attraction.md.

        >>> drive = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
        >>> found = drive.attraction({"u": (-0.1, 0.1, 40), "w": (-80, 80, 30)})
        >>> found.label.shape, f"{found.basin_area.item():.4f} {found.basin_area.units}"
        ((30, 40), '0.9553 rad2 s-1')
        """
        from lsvib.answers.map import map_attraction

        return map_attraction(self, grid, quantities, workers, progress)

    def basin(self) -> Basin:
        """Return the region of attraction of steady sliding of a rigid drive, with its exact boundary.

        A motion leaves the mode of steady sliding through Q = 0 (eq. 8.17) or θ′ = 0. The boundary is a repelling
        cycle, or the motion that just touches one of these lines, followed backwards in time from event to event, in
        closed form or, if friction depends on the speed, by power series (docs/basin.md).

        Returns the :class:`lsvib.Basin`: whether it contains a state (u [rad], w [rad/s]), its boundary as curves, its
        area [rad²/s], all of it or within a window. Raises ``InputError`` for drives that are not rigid, where steady
        sliding attracts nothing, and for drives that docs/basin.md lists; ``EngineError`` where the engine cannot
        follow the boundary. See also :meth:`attraction`, for every model; :meth:`resilience`.

        >>> basin = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10).basin()
        >>> basin.boundary.name, basin.contains((0.0, 0.0)), basin.contains((0.1, 0.0))
        ('TOUCHING_MOTION', True, False)
        """
        from lsvib.dynamics.boundary import basin

        return basin(self)

    def resilience(self, window: Part | None = None) -> Resilience:
        """Return the largest perturbations that steady sliding tolerates, and the share of a window that settles.

        They are the distances from (0, 0) to the boundary of the :meth:`basin` along u, along w, and in the energy
        k u² / 2 + (I + m r_m² tan² λ) w² / 2; all exact, except the energy if friction depends on the speed.

        Arguments: ``window``, the ends of u [rad] and w [rad/s], as ``{"u": (-0.3, 0.3), "w": (-150, 150)}``. Returns
        ``angle`` [rad], ``speed`` [rad/s] and ``energy`` [J], infinite where all perturbations are tolerated, zero
        where steady sliding is unstable; with a window also the ``fraction`` [1] of it that settles. Raises
        ``InputError`` and ``EngineError`` as :meth:`basin` does. See also :meth:`basin`; docs/basin.md.

        >>> drive = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
        >>> found = drive.resilience({"u": (-0.3, 0.3), "w": (-150, 150)})
        >>> f"{found.angle:.6g} rad, {found.speed:.6g} rad/s, {found.energy:.6g} J, {found.fraction:.6g}"
        '0.0223138 rad, 7.46627 rad/s, 0.000154064 J, 0.00530736'
        """
        from lsvib.dynamics.resilience import resilience

        return resilience(self, window)

    def _automaton_and_state(self, start: Start, resume: str, physics: Terms) -> tuple[Automaton, Any]:
        scene = Scene.of({"drive": self, "start": start, "duration": 1.0, "resume": resume, "physics": physics})
        return automaton_of(self, scene.resume, rest=scene.rests), scene.definition.initial_state(self, scene.start)


def simulate(scene: Scene | Mapping[str, Any] | str | Path) -> xr.Dataset:
    """Return the exact motion of a scene, with its events.

    Arguments: a :class:`lsvib.Scene`, its names and values, or the path of a YAML file with them. Returns the dataset
    of :meth:`Drive.simulate`, which has the equation of motion. Raises ``InputError``, ``EngineError``.

    >>> drive = {"mass": 11, "support_damping": 1e-3, "axial_force": -10}
    >>> motion = lsvib.simulate({"drive": drive, "start": {"u": 0.1, "w": 0}, "duration": 0.1})
    >>> motion.sizes["event"]
    12
    """
    from lsvib.answers.motion import Simulation, as_scene

    return Simulation.of(as_scene(scene, {}, {})).dataset()
