"""Known drives: named ones of the chapter and of others, and what bounds the basin of steady sliding of some."""

import math

from lsvib import Drive

PARADOX = Drive(mass=11, support_damping=1e-3, axial_force=-10)  # of figure 8.14b, beyond the critical mass
NEGATIVE_DAMPING = Drive(mass=1, translation_damping=1e3)  # of figure 8.6
NEAR_FOLD = Drive(mass=11, support_damping=2e-3, axial_force=-18.37)  # of a repelling cycle that bounds the basin
REPELLING_SLIP = Drive(mass=9.9, translation_damping=1e3, axial_force=10)  # beside an attracting stick–slip cycle
# Drive 1 of T-RO 2021 with static friction half as large again as kinetic, which jerks at 2 rpm and not at 10 rpm.
JERKING = Drive(
    pitch_radius=5.5e-3, lead_angle=math.atan(2e-3 / (2 * math.pi * 5.5e-3)), screw_inertia=2.186e-6, mass=0.276,
    axial_force=0.943, coupling_stiffness=0.0224, support_damping=2e-4, friction_coefficient=0.6,
    static_friction_coefficient=0.916, input_speed=2 * math.pi / 30,
)  # fmt: skip

BASINS = {  # scene: what bounds the basin, drive
    "Fig. 8.14b beyond m_cr": ("touching_motion", PARADOX),
    "touching slip": ("touching_slip", PARADOX.replace(support_damping=2e-3, axial_force=-17.9)),
    "repelling cycle of seizures": ("cycle", PARADOX.replace(support_damping=3e-3, axial_force=-12.3)),
    "near the fold": ("cycle", NEAR_FOLD.replace(axial_force=-18.35)),
    "repelling cycle of slip": (
        "cycle", Drive(mass=10, support_damping=2.8e-5, translation_damping=430, axial_force=-0.56)
    ),
    "Fig. 8.14b as printed": ("none", PARADOX.replace(mass=10)),
    "the other way round": (
        "touching_slip", PARADOX.replace(support_damping=2e-3, axial_force=17.9, input_speed=-40)
    ),
    "force with the motion, net force against it": (
        "touching_motion", PARADOX.replace(translation_damping=1000, axial_force=10)
    ),
    "seizures that end backward slip": (
        "touching_motion",
        Drive(mass=17.5, support_damping=1.4e-4, translation_damping=1500, axial_force=-1.9, friction_coefficient=0.26),
    ),
    "overdamped": ("none", PARADOX.replace(support_damping=1e-2, axial_force=-20)),
    "overdamped, touching slip": ("touching_slip", PARADOX.replace(support_damping=1e-2, axial_force=-1)),
    "force with the motion, no seizure": ("none", Drive(mass=10, support_damping=1e-4, axial_force=20)),
    "friction law": (
        "cycle", Drive(friction="powered_seat", mass=5, support_damping=6e-4, axial_force=90, input_speed=8)
    ),
    "friction law, the other way round": (
        "cycle", Drive(friction="powered_seat", mass=5, support_damping=6e-4, axial_force=-90, input_speed=-8)
    ),
    "friction law with a Painlevé band": (
        "cycle", Drive(friction="powered_seat", mass=9, support_damping=2e-4, axial_force=15)
    ),
    "friction law, globally stable": (
        "none", Drive(mass=5, support_damping=1e-3, axial_force=60, friction_slope=-0.05)
    ),
}  # fmt: skip
