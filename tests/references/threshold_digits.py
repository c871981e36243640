"""Thresholds with 40 digits from Newton's laws and the closed forms of the references; nothing of the library solves.

``gap(name, values, hint)`` vanishes at a threshold; ``values`` are parameters by name, one of them perhaps with many
digits. For thresholds that depend on a motion the gap is the force of the threshold less that of the drive, found
by one-dimensional root finding or by fixed points; ``hint`` is the time [s], of ``stick`` the rate w [rad/s], near
which the root lies.
"""

from mpmath import mp, mpf

from references.rigid_digits import GUARD_DIGITS, RigidTrueDrive, RigidTrueFlow

from .newton import eigenvalues, solved, steady_law

DIGITS = 40
WORK = DIGITS + GUARD_DIGITS


class Named(dict):
    """Parameters by name that iterate as pairs, as drives do."""

    def __iter__(self):
        return iter(self.items())


def root(function, guess):
    """Root of a function next to a guess that is good to some 16 digits, by secants, to all digits."""
    low = mpf(guess)
    high = low * (1 + mpf(10) ** -16) if low else mpf(10) ** -16
    at_low, at_high = function(low), function(high)
    for _ in range(30):
        if at_high == at_low or abs(high - low) <= mpf(10) ** -28 * abs(high):
            break  # what is left is smaller by the step before
        low, at_low, high = high, at_high, high - at_high * (high - low) / (at_high - at_low)
        at_high = function(high)
    return high


def gap(name, values, hint=()):
    """What is left of a threshold's condition for a rigid drive, by Newton's laws."""
    return _GAPS[name](RigidTrueDrive(values, DIGITS), *hint)


def _row(d):
    return d.Q_terms(mpf(1), mpf(1))[:2]


def _mirrored(d):
    """Ω and R so that Ω > 0."""
    sense = mp.sign(d.Omega)
    return d.Omega * sense, d.R * sense


def _slip(d, law):
    """Flow of slip about the equilibrium of its law, from (y, w)."""
    speed, _ = _mirrored(d)

    def flow(y):
        found = RigidTrueFlow(d, law, mpf(0), -speed)
        found.y0, found.u_eq = y, mpf(0)
        return found

    return flow


def _net(d):
    speed, force = _mirrored(d)
    return force - d.p * d.cx * speed


def _end_of_rest(d, law):
    """T_r = −k z reaches r ξ₊ R (R > 0) or r ξ₋ R, from the equilibrium of a law; T_r there is C_s Ω + r ξ_s R."""
    speed, force = _mirrored(d)
    end = d.r * d.xi(1 if force > 0 else -1) * force
    return (d.C(law) * speed + d.r * d.xi(law) * force - end) / d.k


def _touches(law):
    """Largest Q (law −) or smallest Q (law +) of slip from the end of rest, near a time."""

    def found(d, time):
        flow, (q_u, q_w) = _slip(d, law)(_end_of_rest(d, law)), _row(d)
        guard = q_u, q_w, mpf(0)
        at = min(flow.extrema(guard, 2 * mpf(time)), key=lambda t: abs(t - time))
        u, w = flow.state(at)
        return q_u * u + q_w * w + d.Gamma(law) * _net(d)

    return found


def _stick(d, rate):
    """Slip without rest at R̃ = 1 N: fixed point of the return to Q = 0 near a rate; then w_min R̃ + Ω."""
    given = {key: getattr(d, name) for key, name in _NAMES.items()} | {"lead_angle": mp.atan(d.tan)}
    force = d.p * d.cx * abs(d.Omega) + 1
    scaled = RigidTrueDrive({**given, "input_speed": abs(d.Omega), "axial_force": force}, DIGITS)
    q = *_row(scaled), scaled.Gamma(1) * scaled.R_tilde

    def turn(w):
        u, slowest = -(q[1] * w + q[2]) / q[0], mpf(0)
        for contact in (1, -1):
            flow = RigidTrueFlow(scaled, contact, u, w)
            end = flow.first_root(q, contact, True, 20 / mp.sqrt(flow.b), DIGITS)
            slowest = min([slowest, *(flow.state(t)[1] for t in flow.extrema((mpf(0), mpf(1), mpf(0)), end))])
            u, w = flow.state(end)
        return w, slowest

    return _net(d) * turn(root(lambda w: turn(w)[0] - w, rate))[1] + abs(d.Omega)


_NAMES = {
    "pitch_radius": "r", "screw_inertia": "I", "coupling_stiffness": "k", "support_damping": "c",
    "friction_coefficient": "mu", "mass": "m", "translation_damping": "cx",
}  # fmt: skip


def _fold(d, time):
    """Slip from (x, −Ω) seizes as it is back at x, and the map of seizures has the slope 1 there, by its neighbours."""
    q_u, q_w = _row(d)

    def back(t):
        """The slip whose deflection is x again at t: u(t) = x is linear in x."""
        flow = _slip(d, -1)
        zero, one = flow(mpf(0)).state(t)[0], flow(mpf(1)).state(t)[0]
        x = zero / (1 - (one - zero))
        return x, flow(x).state(t)[1], flow(x)

    def slope(t):
        x, w, flow = back(t)
        u_by_x = flow.homogeneous(mpf(1), mpf(0), t)
        w_by_x = flow.homogeneous(mpf(0), -flow.b, t)
        q_rate = q_u * w + q_w * flow.second(x, w)
        return u_by_x - w * (q_u * u_by_x + q_w * w_by_x) / q_rate - 1

    x, w, _ = back(root(slope, time))
    return q_u * x + q_w * w + d.Gamma(-1) * _net(d)


_GAPS = {
    "onset": lambda d: d.R_tilde,
    "kinematic_constraint": lambda d: d.Gamma(1),
    "negative_damping": lambda d: d.C(1),
    "stick": _stick,
    "detach": _touches(1),
    "global_stability": _touches(-1),
    "fold": _fold,  # one of the two of global stability
}


def jam(model, values):
    """Determinant of the equations of motion under law +: it vanishes where the threads jam (support, nut)."""

    def determinant(laws):
        return laws.equations({"slip": 1, "contact": 1}, laws.p["friction_coefficient"])[1].det()

    return solved(determinant, model, values.items())


def growth(model, values):
    """Largest real part of an eigenvalue of steady sliding [1/s]."""
    drive = Named(values)
    return max(mp.re(z) for z in eigenvalues(model, drive, steady_law(drive)))


def net_force(values):
    """Force on the contact [N] in steady sliding."""
    return solved(lambda laws: laws.axial, "rigid", values.items())
