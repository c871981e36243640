"""What many drives end on at once is what each of them ends on alone, and what the fast map of a drive says of a start.

Tables of many drives are made in doubles that hold to 1e-12; what a motion ends on moves by that times the condition of
its cycle, a few hundred. Labels agree but for starts on a boundary to that: none of those drawn here.
"""

from contextlib import suppress

import numpy as np
import pytest
from references.drives import LIKE_PARTS, drawn, one_of, random_drive, uniform, wide_drive
from references.known import NEAR_FOLD, NEGATIVE_DAMPING, PARADOX, REPELLING_SLIP
from references.sizes import sizes

from lsvib import Drive
from lsvib.answers.map import mapper
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import PART_OF
from lsvib.drives.many import ManyDrives, groups
from lsvib.drives.model import standing_state
from lsvib.dynamics.sweep import all_endings, ending_of, endings_at_once
from lsvib.errors import InputError
from lsvib.systems.attractor import Attractor
from lsvib.systems.grid import Axis, Grid

NEAR_THRESHOLDS = {
    "mass": uniform(1, 20), "axial_force": uniform(-60, 60), "support_damping": uniform(0, 2e-3),
    "translation_damping": one_of(0.0, 1000.0),
}  # fmt: skip


def many_of(drives) -> ManyDrives:
    names = [name for name in Drive.model_fields if name not in PART_OF]
    return ManyDrives({name: [getattr(drive, name) for drive in drives] for name in names})


def test_tables_are_those_of_one_drive():
    """Random drives over decades: every double of every table to 1e-12 of the largest in it, and every integer."""
    drives = [wide_drive("rigid", 11, k, 0).drive for k in range(150)]
    done = np.zeros(len(drives), dtype=bool)
    for group in groups(many_of(drives), np.arange(len(drives))):
        for place, member in enumerate(group.members):
            if not group.safe[place]:
                continue
            done[member], one = True, automaton_of(drives[member])
            for name, table in one.tables._asdict().items():
                other = np.asarray(getattr(group.automaton.tables, name))
                other = other[place] if other.ndim > np.ndim(table) else other
                np.testing.assert_allclose(other, table, rtol=1e-11, atol=0, err_msg=f"{name} of drive {member}")
            for name, table in one.observables.items():
                np.testing.assert_allclose(group.automaton.observables[name][place], table, rtol=1e-11, atol=0)
            assert (group.automaton.codes == one.codes).all()
            assert group.automaton.contracts == one.contracts
    assert done.mean() > 0.9


def test_endings_are_those_of_one_motion():
    """Wide drives and starts, and drives of the chapter's size around its thresholds: all numbers, bit by bit."""
    cases = [wide_drive("rigid", 12, k, 1) for k in range(60)]
    drives, starts = [case.drive for case in cases], [case.starts[0] for case in cases]
    rng = np.random.default_rng(2)
    for _ in range(60):
        drives.append(Drive.of(drawn(rng, NEAR_THRESHOLDS)))
        starts.append([rng.uniform(-0.2, 0.2), rng.uniform(-80, 80)])
    held_against_each(drives, np.array(starts), most_open=0.25, labels=3)


@pytest.mark.parametrize(
    "drive",
    [
        PARADOX, NEAR_FOLD, REPELLING_SLIP, PARADOX.replace(mass=14.0, support_damping=5e-4, axial_force=40.0),
        *(NEGATIVE_DAMPING.replace(axial_force=force) for force in (25.0, 40.0)),
    ],
)  # fmt: skip
def test_the_fast_map_and_the_rule_agree(drive):
    """10⁴ starts of a drive, by the table of sections and by the rule, each on its own."""
    grid = Grid(Axis("u", -0.12, 0.12, 100), Axis("w", -90, 70, 100))
    found = mapper(drive).cells(grid, quantities=("label",))["label"].ravel()
    w, u = (part.ravel() for part in np.meshgrid(grid.y.centres(), grid.x.centres(), indexing="ij"))
    many = ManyDrives({name: np.full(u.size, value) for name, value in drive})
    ends = all_endings(many, {"u": u, "w": w}).attractor
    resolved = (found != Attractor.UNRESOLVED) & (ends != Attractor.UNRESOLVED)
    assert resolved.mean() > 0.999
    assert (found[resolved] == ends[resolved]).all()


def with_law(rng, drive: Drive) -> Drive:
    """The drive with a rise, a slope, both or neither, and static friction or none."""
    mu, values = drive.friction_coefficient, {}
    which = rng.integers(4)
    if which in (0, 2):
        values = {"stribeck_rise": mu * rng.uniform(0.05, 0.5), "stribeck_speed": 10 ** rng.uniform(-3, -1.3)}
        values["stribeck_exponent"] = rng.choice([1.0, 2.0])
    if which in (1, 2):
        values["friction_slope"] = mu * rng.choice([-1, 1]) * 10 ** rng.uniform(-1.5, 0.5)
    if rng.random() < 0.3:
        values["static_friction_coefficient"] = (mu + values.get("stribeck_rise", 0.0)) * rng.uniform(1, 1.4)
    return Drive.of({**dict(drive), **values})


@pytest.mark.parametrize("size", sizes([50], [], [500]))
@pytest.mark.parametrize("kind", sizes(["rigid"], ["threads", "support", "nut"]))
def test_endings_under_friction_laws_are_those_of_one_motion(kind, size):
    """Random laws, in and out of the Painlevé region, from rest: labels, and all numbers to 1e-9.

    But where the threads jam: there the force grows without bound, and what is seen of it depends on the last digit of
    where the engine stops, as does the multiplier to 1e-4.
    """
    drives = []
    parts = {name: draw for name, draw in LIKE_PARTS[kind].items() if name != "slide_friction"}
    for k in range(size):
        rng = np.random.default_rng([33, k])
        drives.append(with_law(rng, random_drive(rng, **drawn(rng, parts))))
    held_against_each(drives)


@pytest.mark.parametrize("kind", LIKE_PARTS)
def test_endings_with_static_friction_everywhere_are_those_of_one_motion(kind):
    """Random slow drives from rest, with static friction in all of threads, slide and bearing, or in some."""
    drives, keys = [], ("static_friction_coefficient", "slide_static_friction", "bearing_static_friction")
    for k in range(80):
        rng = np.random.default_rng([66, k])
        drive = random_drive(rng, **drawn(rng, LIKE_PARTS[kind]))
        slide, bearing = abs(drive.axial_force) * rng.uniform((0.05, 0.02), (0.4, 0.2)) * (1, drive.pitch_radius)
        sliding = {"slide_friction": slide, "bearing_friction": bearing, "input_speed": drive.input_speed / 4}
        static = np.array([drive.friction_coefficient, slide, bearing]) * rng.choice([0, 1, 1.5], 3)
        drive = Drive.of({**dict(drive), **sliding, **dict(zip(keys, static.tolist(), strict=True))})
        with suppress(InputError):  # of a body that is held where the threads may seize
            drives.append(automaton_of(drive) and drive)
    held_against_each(drives)


def held_against_each(drives: list[Drive], starts=None, most_open: float = 0.05, labels: int = 2) -> None:
    """Each ends, among many, on what it ends on alone, by default from rest; of several labels, few left open."""
    names = sorted({name for drive in drives for name, _ in drive})
    many = ManyDrives({name: [getattr(drive, name) for drive in drives] for name in names})
    found, is_open = endings_at_once(many, None if starts is None else dict(zip("uw", starts.T, strict=True)))
    assert is_open.mean() < most_open
    assert len(set(found.attractor[~is_open].tolist())) >= labels
    for k in np.flatnonzero(~is_open):
        start = standing_state(drives[k]) if starts is None else starts[k]
        alone = ending_of(drives[k], automaton_of(drives[k]), start)
        together = found[k]
        assert tuple(together)[:2] == tuple(alone)[:2], repr(drives[k])
        numbers = [(together.amplitude, alone.amplitude), (together.period, alone.period)]
        if starts is not None or not alone.peak_normal_force > 1e6:
            numbers += zip(tuple(together)[4:], tuple(alone)[4:], strict=True)
        np.testing.assert_allclose(*zip(*numbers, strict=True), rtol=1e-9, atol=1e-9, err_msg=repr(drives[k]))
