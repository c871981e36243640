"""The words of the report: every term of the theory with its plain meaning, and numbers with units."""

import math
import re

MECHANISMS = {
    "negative_damping": (
        "Negative damping",
        "Friction turns the damping of the load's travel into its opposite: each small oscillation of the screw is "
        "amplified instead of damped. It needs a self-locking thread, a load that pushes in the direction of travel, "
        "and more damping at the load than the screw's own damping can make up for.",
    ),
    "kinematic_constraint": (
        "Kinematic constraint",
        "Wedging: a load heavy against the screw's inertia, behind a self-locking thread, presses the threads together "
        "faster than the screw can yield, so that the screw seizes and lets go again and again (sprag-slip).",
    ),
    "mode_coupling": (
        "Mode coupling of the support",
        "The screw's turning and its shifting along its axis against the bearing lock into one common oscillation "
        "that draws energy from the motor through friction.",
    ),
    "falling_friction": (
        "Friction that falls with speed",
        "A little faster means a little less friction, which makes the screw faster still; if that outweighs the "
        "damping, small oscillations grow.",
    ),
    "thread_contact": (
        "Compliant thread contact",
        "Screw and nut oscillate against each other on the elasticity of the threads and draw energy through "
        "friction, although the drive would run quietly with perfectly stiff threads.",
    ),
    "from_rest": (
        "Jerks after a start from rest",
        "The screw stands until the coupling has wound up enough to break it loose, runs ahead of the motor and stands "
        "again, for ever; where friction at rest is above that of sliding this happens at low speeds.",
    ),
    "after_perturbation": (
        "Vibration after a perturbation",
        "Steady running is stable, but it is not the only motion that sustains itself: after a perturbation that is "
        "large enough, a knock for instance, the drive does not return to it, but seizes and slips again and again.",
    ),
}
"""Name and plain meaning of each mechanism."""

SHORT = {name: words[0].lower() + words[1:] for name, (words, _) in MECHANISMS.items()}
"""Their names, for the middle of a sentence."""

ATTRACTORS = {
    "steady sliding": "steady running",
    "stick slip cycle": "stick-slip: the screw stops and breaks loose again in every cycle",
    "sprag slip cycle": "sprag-slip: the screw is stopped by an impact of the threads in every cycle",
    "other cycle": "an oscillation of the speed about its mean, without standstill",
    "neutral family": "an oscillation that neither grows nor decays, as nothing damps it",
    "unbounded": "a motion that grows without limit",
    "rest": "standstill",
    "unresolved": "a motion that does not settle into a pattern within the events that were computed",
    "unknown": "unknown",
}
"""Where motions end, in plain words."""

VERDICTS = {
    "vibrates": "This drive will vibrate: at the values of the data sheet steady running is unstable somewhere in the "
    "operating window.",
    "jerks": "This drive jerks or vibrates once it is switched on: started from rest it does not become steady "
    "somewhere in the operating window, at the middle values of the data sheet.",
    "may jerk": "This drive may jerk or vibrate once it is switched on: at the middle values of the data sheet it "
    "becomes steady after a start from rest, but not for all values within the given uncertainties.",
    "may vibrate": "This drive may vibrate: at the middle values of the data sheet it runs steadily, but not for all "
    "values within the given uncertainties.",
    "steady until perturbed": "Steady running of this drive is stable, but a strong perturbation, such as a knock, can "
    "start vibration that goes on.",
    "steady without reserve": "Nothing in the data sheet makes this drive vibrate, but nothing damps it either: "
    "oscillations that something else starts do not decay.",
    "steady but for rare values": "This drive runs steadily in the operating window for every one of the drives that "
    "were drawn from the given uncertainties, but the worst combination of their values can vibrate.",
    "steady": "This drive runs steadily: nothing was found in the operating window that makes it vibrate, neither at "
    "the middle values nor in the drives drawn from the given uncertainties and at the ends of these.",
}
"""The verdict in one sentence, by its name."""


def entry_name(path: str) -> str:
    """Return an entry of the data sheet, such as coupling.gear_ratio, as a reader meets it: coupling: gear ratio."""
    return path.replace(".", ": ").replace("_", " ")


_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_PREFIXED = ("N", "m", "m/s", "Hz", "N s", "N/m", "N m/rad", "s", "N m", "W")


def shown(value: float | None, unit: str) -> str:
    """Return a quantity in SI units with a prefix where one is usual, rad and rad/s in degrees and rpm, Pa in MPa.

    ``unit`` in the spelling of datasets (``N m s rad-1``) or of people; an empty text or 1 for plain numbers.
    """
    if value is None:
        return "–"
    if math.isinf(value):
        return "any" if value > 0 else "none"
    if unit in ("rad s-1", "rad/s"):
        return f"{_figure(value * 60 / (2 * math.pi))} rpm"
    if unit == "rad":
        return f"{_figure(math.degrees(value))}°"
    if unit in ("Pa", "Pa m/s"):
        return f"{_figure(1e-6 * value)} M{unit}"
    unit = re.sub(r" (\w+)-1$", r"/\1", unit)
    unit = re.sub(r"m\^?([23])$", lambda power: "m²" if power[1] == "2" else "m³", unit)
    if unit in ("", "1"):
        return _figure(value)
    if unit in _PREFIXED and value != 0:
        size = abs(value) * (1 + 0.5 * 1e-3)  # so that 999.7 becomes 1 k
        factor, prefix = next((pair for pair in _PREFIXES if size >= pair[0]), _PREFIXES[-1])
        return f"{_figure(value / factor)} {prefix}{unit}"
    return f"{_figure(value)} {unit}"


def percent(value: float | None) -> str:
    """Return a share as a percentage, with enough digits near its ends."""
    if value is None:
        return "–"
    share, digits = 100 * value, 4
    if share <= 99 or value >= 1:
        return f"{_figure(share)} %"
    while (text := f"{share:.{digits}g}") == "100":  # only what is sure is 100 %
        digits += 1
    return f"{text} %"


def signed(value: float, places: int) -> str:
    """Return a plain number with its sign and so many decimal places."""
    return f"{value:+.{places}f}".replace("-", "−")


def change(factor: float | None) -> str:
    """Return a factor in words: 20 % larger, 3 times as large."""
    if factor is None:
        return "no change of it does"
    if factor >= 2:
        return f"{factor:.3g} times as large"
    return f"{abs(factor - 1) * 100:.3g} % {'larger' if factor > 1 else 'smaller'}"


def _figure(value: float) -> str:
    text = f"{value or 0.0:.3g}"  # zero without a sign
    mantissa, _, exponent = text.partition("e")
    if exponent and 0 < int(exponent) < 6:
        text = f"{value:.0f}"
    elif exponent:
        small = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{mantissa} × 10{small}"
    return text.replace("-", "−")
