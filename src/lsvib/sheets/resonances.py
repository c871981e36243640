"""The frequencies at which a drive answers in steady running, their damping, and a stepper's speeds that meet them."""

import math
from typing import NamedTuple

import numpy as np

from lsvib.sheets.draw import Draw
from lsvib.sheets.formulas import sliding_speed
from lsvib.sheets.operation import Operation
from lsvib.sheets.window import OperatingWindow
from lsvib.stability.spectrum import polynomial

PEAK = math.sqrt(0.5)  # the damping ratio from which on no frequency stands out
BESIDE = 1.25  # times beyond the window up to which a speed is said
EVERY = (1, 2, 4)  # steps after which the torque of a stepper with N_r teeth repeats, at 4 N_r n, 2 N_r n and N_r n
Mode = tuple[float, float]  # frequency |s| / 2π [Hz] and damping ratio −Re s / |s| [1] of an eigenvalue s


class Resonance(NamedTuple):
    """A small oscillation about steady running, with the lowest and highest values in the window.

    ``met``: speeds of the screw [rad/s] in or beside it at which a stepper's torque has the frequency, by steps.
    """

    frequency: float
    damping_ratio: float
    frequencies: Mode
    damping_ratios: Mode
    met: dict[int, float]


def modes(there: Operation) -> list[Mode]:
    """Return the oscillations of the whole drive at a point of operation, lowest first; friction is on its tangent."""
    (level, slope), draw = there.friction, there.draw
    start = level - slope * sliding_speed(there.speed, draw.pitch_radius, draw.lead_angle)
    straight = {**there.parameters, "friction_coefficient": start, "friction_slope": slope}
    roots = np.roots(polynomial(straight, int(there.reserves["law"])))
    pairs = sorted((root for root in roots if root.imag > 0), key=abs)
    return [(float(abs(root)) / (2 * math.pi), float(-root.real / abs(root)) + 0.0) for root in pairs]


def resonances(there: Operation) -> list[Resonance]:
    """Return the oscillations at a point of the window, or the first that has more; with the nearest at all others."""
    points = [modes(there), *map(modes, OperatingWindow(there.draw).corners)]
    return [_resonance(there.draw, mode, [own for own in points if own]) for mode in max(points, key=len)]


def _resonance(draw: Draw, mode: Mode, points: list[list[Mode]]) -> Resonance:
    near = [min(own, key=lambda one: abs(math.log(one[0] / mode[0]))) for own in points]
    frequencies, ratios = ((min(ends), max(ends)) for ends in zip(*near, strict=True))
    met, motor = dict[int, float](), draw.sheet.motor
    if motor and motor.holding_torque and mode[1] < PEAK:
        full = 2 * math.pi * mode[0] / motor.steps_per_turn / draw.entries.get("coupling.gear_ratio", 1.0)
        low, high = draw.values["speed_low"] / BESIDE, draw.values["speed_high"] * BESIDE
        met = {steps: steps * full for steps in EVERY if low <= steps * full <= high}
    return Resonance(*mode, frequencies, ratios, met)
