"""The exact basin of steady sliding against motions from thousands of starts, and against 40 digits.

The engine decides where a motion ends by following it to its attractor; the basin is computed from a single motion
backwards. They share the flow of a mode and nothing else. Points 1e-6 of the window off the boundary, on either side,
are labelled by both: no tolerance enters. Areas and boundary points are compared with values formed here with 40 digits
from the parameters; 1e-13 is asked, since arcs end at roots that are known to rounding.
"""

import math
from itertools import count

import numpy as np
import pytest
from mpmath import findroot, mp, mpf, quad
from references.drives import catalogue_drive, wide_drive
from references.known import BASINS
from references.rigid_digits import GUARD_DIGITS, RigidTrueDrive, RigidTrueFlow
from references.sizes import sizes

from lsvib import Drive
from lsvib.answers.map import mapper
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import PART_OF
from lsvib.drives.friction import NAMES
from lsvib.dynamics.boundary import basin
from lsvib.dynamics.curves import Arc, Window, state_on
from lsvib.errors import InputError
from lsvib.systems.attractor import Attractor, steady_state
from lsvib.systems.grid import Axis, Grid

DIGITS = 40
WINDOW = Window(-0.3, 0.3, -150.0, 150.0)
LEFT_OUT = {*PART_OF, *NAMES, "friction_coefficient"}  # of a drive that gets a law of friction, and is rigid


def starts(found, number: int, seed: int) -> list[np.ndarray]:
    """Random states of the window, and as many 1e-6 of the window off the boundary in random directions."""
    generator = np.random.default_rng(seed)
    size = np.array([WINDOW.right - WINDOW.left, WINDOW.top - WINDOW.bottom])
    states = [np.array([WINDOW.left, WINDOW.bottom]) + size * generator.random(2) for _ in range(number)]
    pieces = [piece for curve in found.clipped(WINDOW) for piece in curve]
    for _ in range(number if found.curves else 0):
        piece, angle = pieces[generator.integers(len(pieces))], 2 * math.pi * generator.random()
        share = generator.random()
        point = piece.start + share * (piece.end - piece.start)
        if isinstance(piece, Arc):
            point = state_on(found.flow, piece, share * piece.duration)
        states.append(point + 1e-6 * size * [math.cos(angle), math.sin(angle)])
    return states


@pytest.mark.parametrize("rule", ["contact_sign", "at_once"])
@pytest.mark.parametrize("scene", BASINS)
def test_every_start_ends_where_the_basin_says(scene, rule):
    found, automaton = basin(BASINS[scene][1]), automaton_of(BASINS[scene][1], resume=rule)
    assert found.boundary.name.lower() == BASINS[scene][0]
    for state in starts(found, 40, 1):
        label = steady_state(automaton, state).label
        assert label != Attractor.UNRESOLVED
        assert found.contains(state) == (label == Attractor.STEADY_SLIDING), state


def unresolved_beside(drives, count: int, away: float, **law) -> int:
    """Hold motions from next to the boundary of the first drives that have one; how many of six each are unresolved."""
    rng, judged, unresolved = np.random.default_rng(32), 0, 0
    while judged < count:
        try:
            found = basin(Drive.of(next(drives), **law))
        except InputError:  # steady sliding attracts nothing, or its basin is not covered
            continue
        arcs = [piece for curve in found.curves for piece in curve if isinstance(piece, Arc)]
        judged += bool(arcs)
        for arc in (arcs[k] for k in rng.integers(len(arcs), size=3)) if arcs else ():
            point = state_on(found.flow, arc, rng.uniform(0.01, 0.99) * arc.duration)
            for start in (point * (1 - away), point * (1 + away)):
                label = steady_state(automaton_of(found.drive), start).label
                unresolved += label == Attractor.UNRESOLVED
                settles = label == Attractor.STEADY_SLIDING
                assert label == Attractor.UNRESOLVED or found.contains(start) == settles, (found.drive, start)
    return unresolved


def test_starts_beside_the_boundary_of_random_drives():
    """Six drives over the full ranges of their parameters: next to the boundary, motions end as they should."""
    assert unresolved_beside((dict(wide_drive("rigid", 32, k, 1).drive) for k in count()), 6, 1e-5) < 3


@pytest.mark.parametrize("size", sizes([2], [4], [40]))
@pytest.mark.parametrize("law", ["powered_seat", "measured_screw"])
def test_starts_beside_the_boundary_under_measured_laws(law, size):
    """Random drives such as catalogues offer, with rigid parts: a millionth within motions settle, beyond they do not.

    The rule follows them forwards; they share the series of the flow with the boundary, which is followed backwards.
    """
    given = ({name: x for name, x in catalogue_drive("threads", 78, k)[0] if name not in LEFT_OUT} for k in count())
    assert unresolved_beside(given, size, 1e-6, friction=law) <= size


@pytest.mark.parametrize("scene", [scene for scene in BASINS if scene.startswith("friction law")])
def test_boundary_under_a_law_against_the_map_by_cells(scene):
    """The map divides lines by the events of many motions forwards; its share errs by less than the cells cut."""
    drive, number = BASINS[scene][1], 24
    found, size = basin(drive), abs(drive.input_speed) * np.array([8e-3, 5.0])
    axes = [Axis(name, -end, end, number) for name, end in zip("uw", size, strict=True)]
    cells = mapper(drive).cells(Grid(*axes), quantities=("label",))["label"] == Attractor.STEADY_SLIDING
    inside = [[found.contains((u, w)) for u in axes[0].centres()] for w in axes[1].centres()]
    assert (cells == inside).all()
    window = Window(-size[0], size[0], -size[1], size[1])
    assert found.fraction(window) == pytest.approx(cells.mean(), abs=2 / number)


def touching_motion(d: RigidTrueDrive):
    """The motion that touches Q = 0, from there backwards to Q = 0: the state where it touches, end, duration.

    On Q = 0, where p (k u + c w) = −Γ₋ R / m, the touch k w + c w′ = 0 with w′ = R / (m p) lies at w = −c R / (k m p).
    """
    w = -d.c * d.R / (d.k * d.m * d.p)
    u = (-d.Gamma(-1) * d.R / (d.m * d.p) - d.c * w) / d.k
    flow = RigidTrueFlow(d, -1, u, w)
    # Backwards Q falls first, to rise again: the last of many equal steps before its second zero.
    step = mpf("1e-4")
    steps = next(n for n in range(10, 1000) if d.Q(*flow.state(-n * step)) > 0)
    duration = findroot(lambda t: d.Q(*flow.state(-t)), ((steps - 1) * step, steps * step))
    return flow, (u, w), flow.state(-duration), duration


def test_area_against_forty_digits():
    """∫ w du by quadrature along the motion, and the straight part along Q = 0."""
    drive = BASINS["Fig. 8.14b beyond m_cr"][1]
    with mp.workdps(DIGITS + GUARD_DIGITS):
        flow, touch, start, duration = touching_motion(RigidTrueDrive(dict(drive), DIGITS))
        turned = quad(lambda t: flow.state(-t)[1] ** 2, mp.linspace(0, duration, 9))
        expected = turned + (touch[1] + start[1]) * (start[0] - touch[0]) / 2
        found = basin(drive)
        (curve,) = found.curves
        assert abs(mpf(found.area()) / expected - 1) < mpf("1e-13")
        assert abs(mpf(curve[0].duration) / duration - 1) < mpf("1e-13")
        assert all(abs(mpf(float(a)) - b) < 1e-13 * abs(b) for a, b in zip(curve[0].start, start, strict=True))


def test_repelling_cycle_of_seizures_against_forty_digits():
    """Slip from (x, −Ω) that comes back to u = x just on Q = 0; the area to the right of it in a window."""
    drive = BASINS["repelling cycle of seizures"][1]
    with mp.workdps(DIGITS + GUARD_DIGITS):
        d = RigidTrueDrive(dict(drive), DIGITS)
        found = basin(drive)
        slip = next(piece for piece in found.curves[0] if isinstance(piece, Arc))

        def misses(x, time):
            u, w = RigidTrueFlow(d, -1, x, -d.Omega).state(time)
            return u - x, d.Q(u, w) / d.Gamma(-1)

        x, time = findroot(misses, (mpf(float(slip.start[0])), mpf(slip.duration)))
        assert abs(mpf(float(slip.start[0])) / x - 1) < mpf("1e-12")  # double over 1 − 1/multiplier = 0.1
        flow = RigidTrueFlow(d, -1, x, -d.Omega)
        expected = (mpf(WINDOW.right) - x) * (WINDOW.top - WINDOW.bottom)
        expected += quad(lambda t: flow.state(t)[1] ** 2, mp.linspace(0, time, 9))
        assert abs(mpf(found.area(WINDOW)) / expected - 1) < mpf("1e-13")


def test_area_in_a_window_is_the_sum_over_its_parts():
    """Random windows cut in two at random, upright or across: clipping loses and doubles nothing."""
    generator = np.random.default_rng(4)
    for scene in ("touching slip", "repelling cycle of slip", "Fig. 8.14b beyond m_cr", "Fig. 8.14b as printed"):
        found = basin(BASINS[scene][1])
        for _ in range(25):
            left, right = np.sort(generator.uniform(-0.15, 0.15, 2))
            bottom, top = np.sort(generator.uniform(-60, 60, 2))
            u, w = generator.uniform(left, right), generator.uniform(bottom, top)
            whole = found.area(Window(left, right, bottom, top))
            upright = found.area(Window(left, u, bottom, top)) + found.area(Window(u, right, bottom, top))
            across = found.area(Window(left, right, bottom, w)) + found.area(Window(left, right, w, top))
            size = (right - left) * (top - bottom)
            assert max(abs(upright - whole), abs(across - whole)) < 1e-13 * size


@pytest.mark.parametrize("scene", ["the other way round", "repelling cycle of slip", "Fig. 8.14b beyond m_cr"])
def test_share_of_windows_of_any_width_about_the_boundary(scene):
    """Beside random points of the window: within five standard errors of their share, or refused as too narrow."""
    found, generator, refused = basin(BASINS[scene][1]), np.random.default_rng(6), 0
    points = found.line(Window(-0.3, 0.3, -150.0, 150.0))
    points = points[np.isfinite(points).all(axis=1)]
    for place in generator.choice(points, 60):
        size = np.abs(points).max(axis=0) * 10 ** generator.uniform(-12, 0, 2)
        low = place - generator.uniform(0, 1, 2) * size
        window = Window(low[0], low[0] + size[0], low[1], low[1] + size[1])
        try:
            share = found.fraction(window)
        except InputError:
            refused += 1
            continue
        assert 0 <= share <= 1
        states = generator.uniform(low, low + size, (80, 2))
        counted = np.mean([found.contains(state) for state in states])
        assert abs(counted - share) <= 5 * math.sqrt((share * (1 - share) + 1 / 80) / 80)
    assert 5 < refused < 40


def test_size_grows_with_the_force_until_nothing_bounds_it():
    """Without translation damping slip does not depend on R, so that the motion that touches Q = 0 scales with it."""
    drive = BASINS["Fig. 8.14b beyond m_cr"][1]
    areas = [basin(drive.replace(axial_force=-r)).area() / r**2 for r in (1e-3, 1.0, 10.0, 32.0)]
    np.testing.assert_allclose(areas, areas[0], rtol=1e-13)
    assert basin(drive.replace(axial_force=-33.0)).area() == math.inf
