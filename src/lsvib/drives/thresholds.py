"""The thresholds of drives by name: what each says, which drives have it, and what it is solved for by default.

Models, charts and help read this table; what computes a threshold stands in :mod:`lsvib.stability.boundaries`,
:mod:`lsvib.stability.force_thresholds` or :mod:`lsvib.stability.starting`, its equation in docs/thresholds.md.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Known:
    """A threshold in words, of forces for input_speed > 0; for input_speed < 0 all forces change sign.

    ``usual``: the parameter that it is solved for by default, empty for the axial force, of drives with parts the mass;
    ``rigid``: whether only rigid drives have it, or only others, or (None) all; ``drawn``: whether charts of rigid
    drives have it as a curve. ``constant``: whether its closed form holds only for friction that does not depend on the
    speed, and ``rest``, only for static friction that is not above that of sliding.
    """

    statement: str
    usual: str = ""
    rigid: bool | None = None
    drawn: bool = False
    constant: bool = False
    rest: bool = False


TABLE = {
    "even_speed": Known(
        "On one side the motion from rest ends in steady sliding, on the other it does not.", "input_speed", drawn=True,
        constant=True,
    ),
    "onset": Known("Steady sliding is asymptotically stable on one side, but not on the other.", drawn=True),
    "kinematic_constraint": Known(
        "Beyond it the effective inertia of law + is not positive: Painlevé's paradox, and the threads may jam.",
        "mass", drawn=True,
    ),
    "flutter": Known("A pair of eigenvalues crosses the imaginary axis while all others decay.", "mass", rigid=False),
    "negative_damping": Known(
        "Slip under law + grows where the effective damping is negative.", "support_damping", rigid=True, drawn=True,
        constant=True,
    ),
    "stick": Known(
        "Between the onset and this force, slip has an attracting cycle without rest; beyond it slip comes to rest.",
        rigid=True, drawn=True, constant=True,
    ),
    "detach": Known(
        "Between the onset and this force, slip from the end of rest reaches N = 0; beyond it the stick-slip cycle "
        "does not.", rigid=True, drawn=True, constant=True, rest=True,
    ),
    "global_stability": Known(
        "Under every smaller force all motions end in steady sliding; from this force to the onset, "
        "R = r_m tan(lead_angle) c_x Omega, some do not.", rigid=True, drawn=True, constant=True, rest=True,
    ),
}  # fmt: skip


def names(rigid: bool, drawn: bool = False) -> tuple[str, ...]:
    """Return the names of the thresholds of rigid or other drives, or of those that are ``drawn`` as curves.

    >>> names(rigid=False)
    ('even_speed', 'onset', 'kinematic_constraint', 'flutter')
    """
    return tuple(name for name, one in TABLE.items() if one.rigid in (None, rigid) and (one.drawn or not drawn))
