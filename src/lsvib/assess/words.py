"""Plain words for what the theory calls by names; every term of the report has its meaning beside it."""

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
        "faster than the screw can give way, so that the screw seizes and lets go again and again (sprag-slip).",
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
        "Springy thread contact",
        "Screw and nut oscillate against each other on the elasticity of the threads and draw energy through "
        "friction, although the drive would run quietly with perfectly stiff threads.",
    ),
    "push_needed": (
        "Vibration after a push",
        "Steady running is stable, but it is not the only motion that keeps itself going: after a push that is large "
        "enough the drive does not return to it, but seizes and slips again and again.",
    ),
}
"""Name and plain meaning of each mechanism."""

SHORT = {
    "negative_damping": "negative damping (friction amplifies the oscillation instead of damping it)",
    "kinematic_constraint": "kinematic constraint (the threads wedge and let go)",
    "mode_coupling": "mode coupling of the support (turning and shifting of the screw lock together)",
    "falling_friction": "friction that falls with speed",
    "thread_contact": "springy thread contact",
    "push_needed": "vibration after a push",
}
"""The same in a few words, for the middle of a sentence."""

CHANGES = {
    "lead": "lead of the thread",
    "pitch_diameter": "pitch diameter of the thread",
    "half_angle": "flank angle of the thread",
    "friction": "friction of the threads",
    "friction_slope": "fall or rise of friction with speed",
    "inertia": "rotating inertia",
    "coupling_stiffness": "stiffness of the coupling",
    "rotational_damping": "rotational damping of the screw",
    "translational_damping": "damping of the load's travel",
    "mass": "moved mass",
    "force": "force on the load",
    "speed": "speed",
    "contact_stiffness": "stiffness of the thread contact",
    "contact_damping": "damping of the thread contact",
    "support_stiffness": "stiffness of the axial support",
    "support_damping": "damping of the axial support",
    "screw_mass": "mass of the screw",
}
"""What an engineer can change, by the names of quantities."""

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
    "may vibrate": "This drive may vibrate: at the middle values of the data sheet it runs steadily, but not for all "
    "values within the given uncertainties.",
    "steady until pushed": "This drive runs steadily when left alone, but a strong push may start a vibration that "
    "goes on.",
    "steady without reserve": "Nothing in the data sheet makes this drive vibrate, but nothing damps it either: "
    "oscillations that something else starts do not decay.",
    "steady but for rare values": "This drive runs steadily in the whole operating window for every one of the drives "
    "that were drawn from the given uncertainties, but the worst combination of their values can vibrate.",
    "steady": "This drive runs steadily in the whole operating window, for all values within the given uncertainties.",
}
"""The verdict in one sentence, by its name."""

LEFT_OUT = (
    "Bending of the screw: two bending modes of similar frequency can squeal on their own (Nam et al., Sensors 23: "
    "6169, 2023); long, thin screws need a calculation of their own.",
    "A springy support and springy threads at once, and springy threads with friction that falls with speed: each is "
    "judged with the others as stiff, and with the friction of the running speed.",
    "Backlash of the nut, and screws or nuts that are bent, worn or out of line.",
    "Coulomb friction of the guides and bearings; it damps, so leaving it out is on the safe side for small "
    "oscillations, except where friction falls with speed: what the guides resist with is pressed through the threads "
    "as well, and the fall amplifies an oscillation the more, the larger the force on them.",
    "Static friction that is larger than kinetic friction; it makes stick-slip at very low speeds more likely.",
    "The dynamics of the motor and its controller: the motor is taken to turn at constant speed.",
    "The motion beyond the onset of vibration by friction that falls with speed: only the onset is computed.",
)
"""What the model does not know, in sentences."""


def entry_name(path: str) -> str:
    """Return an entry of the data sheet, such as coupling.gear_ratio, as a reader meets it: coupling: gear ratio."""
    return path.replace(".", ": ").replace("_", " ")
