"""Cases of four states: contacts, supports and nuts over decades, with frictions, starts on guards."""

import math

import numpy as np
from references import drives
from references.bodies import Bodies
from references.drives import decades, drawn, heaviest, one_of, power, sign, signed, times, uniform

from benchmarks.sweeps.families import Case, CaseFamily
from lsvib.drives.drive import DRY, Drive
from lsvib.stability.spectrum import eigenvalues

_MOST_TURNS = 6.0  # of the fastest oscillation: bounds the work of the reference

_COMMON = {
    "mass": power(-1, 1.7), "friction_coefficient": uniform(0.02, 0.5), "axial_force": signed(power(-1, 2.5)),
    "input_speed": signed(power(0, 2)), "support_damping": power(-5, -2),
    "translation_damping": times(one_of(0, 1), power(0, 3.5)), "slide_friction": power(-2, 2.5),
    "bearing_friction": power(-4, 0),
}  # fmt: skip
_FRICTIONS = ((), ("slide_friction",), ("bearing_friction",), ("slide_friction", "bearing_friction"))
_STARTS = ("anywhere", "slip", "second", "both", "contact", "steady")


def contact(rng) -> Case:
    """k_c and c_c from 1e3 to 1e14, c_c / k_c up to 80 min: the engine refuses a contact that creeps more slowly."""
    stiffness = decades(rng, 3, 14)
    damping = decades(rng, 3, min(14, math.log10(stiffness) + 3.7))
    mass, force = rng.choice([5.0, 10.2, 11.0, 15.0]), rng.choice([100.0, 10.0, -50.0])
    drive = drives.threads_drive(mass=mass, axial_force=force, contact_stiffness=stiffness, contact_damping=damping)
    # So many radians of the contact where it vibrates, else of the drive.
    rate = math.sqrt(0.4 * stiffness)
    vibrates = damping < 4.0 * stiffness / rate
    duration = min(0.01, rng.uniform(5, 40) / rate) if vibrates else 0.01
    start = (rng.uniform(-0.2, 0.2), rng.uniform(-120, 60), 0.0, 0.0)
    return Case(CaseFamily.CONTACT, math.log10(stiffness), drive, start, duration)


def support(rng) -> Case:
    """k_1 from 1e2 to 1e12, c_1 = 0 and to 1e8, m_1 from 1e-2 to 1e3."""
    physics, values = _FRICTIONS[rng.integers(4)], dict(Drive()) | drawn(rng, _COMMON)
    level = rng.uniform(2, 12)
    values |= {
        "screw_mass": decades(rng, -2, 3),
        "support_stiffness": 10.0**level,
        "axial_support_damping": rng.integers(2) * decades(rng, -2, 8),
    }
    share = decades(rng, -3, -0.01)
    if "slide_friction" in physics:  # only up to this mass is the motion determined
        values["screw_mass"] = min(values["screw_mass"], share * heaviest(values, values["screw_inertia"]))
    drive = drives.support_drive(values)
    shift = drive.axial_force / drive.support_stiffness
    own = (shift * rng.uniform(-3, 3), 1e-3 * rng.uniform(-50, 50))
    return _case(rng, CaseFamily.SUPPORT, physics, level, drive, own)


def nut(rng) -> Case:
    """k_2 from 1e-3 to 1e5, c_2 = 0 and to 1, I_2 from 1e-8 to 1e-2."""
    physics, values = _FRICTIONS[rng.integers(4)], dict(Drive()) | drawn(rng, _COMMON)
    level = rng.uniform(-3, 5)
    values |= {
        "nut_inertia": decades(rng, -8, -2),
        "nut_stiffness": 10.0**level,
        "nut_damping": rng.integers(2) * decades(rng, -8, 0),
    }
    share = decades(rng, -3, -0.01)
    if "bearing_friction" in physics:
        inertia = 1 / (1 / values["screw_inertia"] + 1 / values["nut_inertia"])
        values["mass"] = min(values["mass"], share * heaviest(values, inertia))
    drive = drives.nut_drive(values)
    own = (rng.uniform(-0.3, 0.3), drive.input_speed * rng.uniform(-3, 3))
    return _case(rng, CaseFamily.NUT, physics, level, drive, own)


def _case(rng, family: CaseFamily, physics: tuple[str, ...], level: float, drive, own: tuple[float, float]) -> Case:
    model = "support" if family == CaseFamily.SUPPORT else "nut"
    drive = drive.replace(**{name: 0.0 for name in DRY if name not in physics})
    rates = np.concatenate([eigenvalues(dict(drive), law) for law in (1, -1)])
    swing = math.sqrt(drive.screw_inertia / drive.coupling_stiffness)
    duration = math.tau * swing * rng.uniform(0.3, 3.0)
    duration = min(duration, _MOST_TURNS * math.tau / (np.abs(rates.imag).max() or 1e-9))
    state = [0.3 * rng.uniform(-1, 1), drive.input_speed * rng.uniform(-3, 3), *own]
    start = _on_a_guard(rng.choice(_STARTS), model, drive, physics, state, sign(rng))
    return Case(family, level, drive, tuple(map(float, start)), float(duration), physics)


def _on_a_guard(where: str, model: str, drive, physics: tuple[str, ...], state: list[float], side: int) -> list[float]:
    """Move a state to where slip, the second body, both, or the contact force are zero, or to steady sliding."""
    rest = -drive.input_speed
    u, w, place, rate = state
    if where == "steady":
        return [0.0, 0.0, 0.0, 0.0]
    if where == "both":
        return [u, rest, place, 0.0]
    if where == "slip":
        return [u, rest, place, rate] if model == "support" else [u, w, place, drive.input_speed + w]
    if where == "second" and physics:
        reach = drive.pitch_radius * math.tan(drive.lead_angle)
        return [u, w, place, -reach * (drive.input_speed + w)] if model == "support" else [u, rest, place, rate]
    if where == "contact":
        laws, moves = Bodies(drive), dict.fromkeys(("slip", "bearing", "slide"), side)
        row = laws.forces(moves | {"contact": -side}, laws.p["friction_coefficient"])["N"]
        own = np.array([0.0, w, place, rate]) + laws.steady
        u = -float(laws.values([row], own)[0] / row[0])
        return [u, w, place, rate] if abs(u) < 1e3 else state
    return state
