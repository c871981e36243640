"""Steady sliding straight from Newton's laws in many digits: accelerations with the contact force as an unknown.

Independent of ``lsvib.stability``: no matrices of mass, damping and stiffness, and stability
by eigenvalues of the state matrix or by Routh's array of its characteristic polynomial.
"""

import mpmath
from mpmath import mpf

DIGITS = 250  # rates of random drives lie up to 30 decades apart, and the polynomial has products of four of them

_ROUNDING = mpf(10) ** -100  # far below what doubles can come to by chance, far above DIGITS


def accelerations(model: str, drive, law: int, state: list) -> list:
    """Accelerations of the coordinates at a state [q_1, q_1′, q_2, q_2′] (two of the rigid drive); loads left out."""
    p = {key: mpf(value) for key, value in drive}
    sine, cosine = mpmath.sin(p["lead_angle"]), mpmath.cos(p["lead_angle"])
    radius, friction = p["pitch_radius"], law * p["friction_coefficient"]
    # I θ″ = T − arm N and m x″ = drag − push N
    arm, push, lead = radius * (friction * cosine - sine), cosine + friction * sine, radius * sine / cosine
    first, rate, *second = state
    torque = -p["coupling_stiffness"] * first - p["support_damping"] * rate
    inertia, mass, drag = p["screw_inertia"], p["mass"], -p["translation_damping"]
    if model == "threads":
        place, speed = second
        force = cosine * (p["contact_stiffness"] * place + p["contact_damping"] * speed)
        screw = (torque - arm * force) / inertia
        return [screw, (drag * (speed + lead * rate) - push * force) / mass - lead * screw]
    # The others tie x″ to the screw; N follows from the difference of both sides.
    if model == "rigid":
        drag *= lead * rate
        force = (drag / mass - lead * torque / inertia) / (push / mass - lead * arm / inertia)
        return [(torque - arm * force) / inertia]
    place, speed = second
    if model == "support":
        other = p["screw_mass"]
        axial = -p["support_stiffness"] * place - p["axial_support_damping"] * speed
        drag *= speed + lead * rate
        gap = drag / mass - lead * torque / inertia - axial / other
        force = gap / (push / mass - lead * arm / inertia + push / other)
        return [(torque - arm * force) / inertia, (axial + push * force) / other]
    other = p["nut_inertia"]
    twist = -p["nut_stiffness"] * place - p["nut_damping"] * speed
    drag *= lead * (rate - speed)
    gap = drag / mass - lead * (torque / inertia - twist / other)
    force = gap / (push / mass - lead * arm * (1 / inertia + 1 / other))
    return [(torque - arm * force) / inertia, (twist + arm * force) / other]


def steady_law(drive) -> int:
    """Law of steady sliding by the force on the contact; 0 if there is none."""
    p = {key: mpf(value) for key, value in drive}
    sense = mpmath.sign(p["input_speed"])
    drag = p["pitch_radius"] * mpmath.tan(p["lead_angle"]) * p["translation_damping"] * p["input_speed"]
    return int(mpmath.sign(p["axial_force"] - drag - p.get("slide_friction", 0) * sense) * sense)


def state_matrix(model: str, drive, law: int) -> list[list[mpf]]:
    """State matrix; its columns are the rates at unit states, because without loads the equations are homogeneous."""
    size = 2 if model == "rigid" else 4
    columns = []
    for j in range(size):
        state = [mpf(i == j) for i in range(size)]
        found = accelerations(model, drive, law, state)
        columns.append([x for i, value in enumerate(found) for x in (state[2 * i + 1], value)])
    return [list(row) for row in zip(*columns, strict=True)]


def eigenvalues(model: str, drive, law: int) -> list[mpmath.mpc]:
    """Eigenvalues [1/s] of the state matrix in ascending real, then imaginary part."""
    found = mpmath.eig(mpmath.matrix(state_matrix(model, drive, law)), left=False, right=False)
    return sorted(found, key=lambda z: (float(mpmath.re(z)), float(mpmath.im(z))))


def is_stable(model: str, drive, law: int) -> bool:
    """Whether all eigenvalues have negative real parts: Routh's array of the polynomial by Faddeev and LeVerrier."""
    a = state_matrix(model, drive, law)
    size, power, polynomial = len(a), [], [mpf(1)]
    for k in range(size):
        shifted = [
            [(power[i][j] if power else 0) + (polynomial[-1] if i == j else 0) for j in range(size)]
            for i in range(size)
        ]
        power = [[sum(a[i][n] * shifted[n][j] for n in range(size)) for j in range(size)] for i in range(size)]
        polynomial.append(-sum(power[i][i] for i in range(size)) / (k + 1))
    first, second = polynomial[0::2], polynomial[1::2]
    while second:
        if second[0] <= 0:
            return False
        padded = second + [mpf(0)] * (len(first) - len(second))
        terms = [(b, first[0] / second[0] * c) for b, c in zip(first[1:], padded[1:], strict=True)]
        # What is left of a difference by rounding is zero, as with a mode that no damping reaches.
        first, second = second, [b - c if abs(b - c) > _ROUNDING * (abs(b) + abs(c)) else mpf(0) for b, c in terms]
    return True
