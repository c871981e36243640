"""Small swings about steady sliding of many drives at once, straight from Newton's laws; no code of the package.

Drives are mappings of arrays (n): ``r`` [m], ``lead`` angle [rad], ``mu`` and its ``slope`` over the sliding speed
[s/m] (of the square thread), ``I``, ``k``, ``c``, ``m``, ``c_x``, with a support ``m_1``, ``k_1``, ``c_1``, with
springy threads ``k_c``, ``c_c``; ``omega`` [rad/s] and ``force`` R along x [N], both signed. SI units.
"""

import numpy as np
from scipy.integrate import solve_ivp

_LONGEST = 2000.0  # times of the fastest rate that a motion is followed
_BRINK = 1e-12  # of the largest rate: growth below it is rounding of the eigenvalues


def steady_contact(p):
    """Law s_0 of steady sliding (+1 where the threads carry nothing) and contact force N_0 [N]."""
    carried = p["force"] - p["r"] * np.tan(p["lead"]) * p["c_x"] * p["omega"]
    law = np.where(carried * p["omega"] >= 0, 1, -1)
    return law, carried / (np.cos(p["lead"]) + law * p["mu"] * np.sin(p["lead"]))


def state_matrix(p, part="rigid", slope=True):
    """State matrices (n, 2k, 2k) of [θ, θ′] or [θ, θ′, x, x′], x the shift of the screw or the place of the load.

    The accelerations and the change of the contact force are the unknowns of Newton's laws, solved for numerically.
    """
    left, right = newtons_laws(p, part, slope)
    accelerations = np.linalg.solve(left, right)[..., : right.shape[-1] // 2, :]
    size = right.shape[-1]
    matrix = np.zeros((*accelerations.shape[:-2], size, size))
    for k in range(size // 2):
        matrix[..., 2 * k, 2 * k + 1] = 1.0
        matrix[..., 2 * k + 1, :] = accelerations[..., k, :]
    return matrix


def wedges(p, part="rigid"):
    """Whether an inertia is negative (n): Newton's laws change their sign between no friction and that of the drive."""
    signs = [np.sign(np.linalg.det(newtons_laws({**p, "mu": mu}, part)[0])) for mu in (p["mu"], 0 * p["mu"])]
    return signs[0] != signs[1]


def newtons_laws(p, part="rigid", slope=True):
    """Left (n, j, j) and right (n, j, 2k) sides: laws times [accelerations, contact force] = right times state."""
    p = {key: np.asarray(value, dtype=float) for key, value in p.items()}
    law, contact = steady_contact(p)
    sine, cosine, lever = np.sin(p["lead"]), np.cos(p["lead"]), p["r"] * np.tan(p["lead"])
    push = cosine + law * p["mu"] * sine  # axial force per contact force
    arm = p["r"] * (law * p["mu"] * cosine - sine)  # torque against the screw per contact force
    # By the rate of turning the friction itself changes, |N_0| dμ: it brakes the screw and pushes the load back.
    grip = np.abs(contact) * p["slope"] * p["r"] / cosine * (1.0 if slope else 0.0)
    n = np.broadcast_shapes(*(value.shape for value in p.values()))
    if part == "rigid":  # unknowns θ″, N
        left, right = np.zeros((*n, 2, 2)), np.zeros((*n, 2, 2))
        _fill(left, [[p["I"], arm], [p["m"] * lever, push]])
        _fill(right, [[-p["k"], -p["c"] - p["r"] * cosine * grip], [0, -p["c_x"] * lever - sine * grip]])
        return left, right
    left, right = np.zeros((*n, 3, 3)), np.zeros((*n, 3, 4))
    if part == "support":  # unknowns θ″, x″ of the screw, N; the load is at x + lever θ
        _fill(left, [[p["I"], 0, arm], [p["m"] * lever, p["m"], push], [0, p["m_1"], -push]])
        rows = [
            [-p["k"], -p["c"] - p["r"] * cosine * grip, 0, 0],
            [0, -p["c_x"] * lever - sine * grip, 0, -p["c_x"]],
            [0, sine * grip, -p["k_1"], -p["c_1"]],
        ]
    else:  # unknowns θ″, x″ of the load, N, which is the force of the threads' spring and damper
        _fill(left, [[p["I"], 0, arm], [0, p["m"], push], [0, 0, 1]])
        rows = [
            [-p["k"], -p["c"] - p["r"] * cosine * grip, 0, 0],
            [0, -sine * grip, 0, -p["c_x"]],
            [-cosine * lever * p["k_c"], -cosine * lever * p["c_c"], cosine * p["k_c"], cosine * p["c_c"]],
        ]
    _fill(right, rows)
    return left, right


def _fill(matrix, rows):
    for i, row in enumerate(rows):
        for j, value in enumerate(row):
            matrix[..., i, j] = value


def growth(matrix):
    """Rate [1/s] (n) at which the swing that grows most grows; zero where it is rounding."""
    found = np.linalg.eigvals(matrix)
    fastest = found.real.max(axis=-1)
    return np.where(np.abs(fastest) > _BRINK * np.abs(found).max(axis=-1), fastest, 0.0)


def causes(p, parts=()):
    """Which causes make steady sliding unstable, arrays (n) by name, by the definitions of ``docs/assess.md``.

    ``parts``: support or contact, or both.
    """
    p = {key: np.asarray(value, dtype=float) for key, value in p.items()}
    rigid, one_way = state_matrix(p, slope=False), wedges(p)
    damping = -np.trace(rigid, axis1=-2, axis2=-1) * p["k"] / np.linalg.det(rigid)
    sloped = state_matrix(p)
    with_slope = -np.trace(sloped, axis1=-2, axis2=-1) * p["k"] / np.linalg.det(sloped)
    falls = np.broadcast_to(np.asarray(p["slope"]) < 0, one_way.shape)
    helped = np.where(falls, damping, with_slope)
    found = {
        "kinematic_constraint": one_way,
        "negative_damping": helped < 0,
        "falling_friction": falls & (with_slope < 0),
    }
    stiff = found.copy()
    if "support" in parts:
        level, full = growth(state_matrix(p, "support", slope=False)) > 0, growth(state_matrix(p, "support")) > 0
        unstable = np.where(falls, level, full)
        bare_drive = {**p, "c": 0 * p["c"], "c_x": 0 * p["c_x"], "c_1": 0 * p["c_1"]}
        bare = np.linalg.eigvals(state_matrix(bare_drive, "support", slope=False))
        flutters = bare.real.max(axis=-1) > 1e-6 * np.abs(bare).max(axis=-1)
        one_way = wedges(p, "support")
        found = {
            "kinematic_constraint": one_way,
            "negative_damping": (stiff["negative_damping"] & (unstable | one_way)),
            "mode_coupling": unstable & ~one_way & (~stiff["negative_damping"] | flutters),
            "falling_friction": np.where(
                one_way, stiff["falling_friction"], falls & full & (~level | stiff["falling_friction"])
            ),
        }
    if "contact" in parts:
        unstable = growth(state_matrix(p, "contact", slope=False)) > 0
        found["thread_contact"] = unstable & ~stiff["negative_damping"] & ~stiff["kinematic_constraint"]
        if "support" not in parts:
            for name in ("negative_damping", "kinematic_constraint"):
                found[name] = found[name] & unstable
    return found


def measured_growth(p, part="rigid", swings=3.0):
    """Logarithm of the growth of the largest swing of one drive over some swings, as computed and as measured.

    The motion that is measured is that of scipy's method of order eight on the nonlinear laws, from a small deviation
    along the swing that grows most; it is measured by the left eigenvector, so that other swings do not count.
    """
    p = {key: float(value) for key, value in p.items()}
    matrix = state_matrix(p, part)
    values, left = np.linalg.eig(matrix.T)
    at = int(np.argmax(values.real))
    right_values, right = np.linalg.eig(matrix)
    start = np.real(right[:, int(np.argmin(np.abs(right_values - values[at])))])
    small = 1e-5 * abs(p["omega"]) / max(abs(start[1::2]).max(), 1e-300)
    law, contact = (float(x) for x in steady_contact(p))
    rates = _laws(p, part, contact, law)
    span = min(2.0 / max(abs(values[at].real), 1e-300), 2 * np.pi * swings / abs(values[at]))
    span = min(span, _LONGEST / abs(values).max())  # springy threads settle slowly against their own rates
    solved = solve_ivp(rates, (0.0, span), small * start, method="DOP853", rtol=1e-8, atol=1e-12 * small)
    first, last = (abs(left[:, at] @ solved.y[:, k]) for k in (0, -1))
    return float(values[at].real * span), float(np.log(last / first))


def _laws(p, part, contact, law):
    """Rates of the deviation from steady sliding, by Newton's laws with the friction of the instant."""
    sine, cosine, lever = np.sin(p["lead"]), np.cos(p["lead"]), p["r"] * np.tan(p["lead"])
    sense = np.sign(p["omega"])
    torque_0 = p["r"] * contact * (law * p["mu"] * cosine - sine)
    axial_0 = contact * (cosine + law * p["mu"] * sine)

    def rates(_, y):
        rate = y[1] + p["omega"]
        friction = p["mu"] + p["slope"] * p["r"] * (abs(rate) - abs(p["omega"])) / cosine
        law_now = np.sign(rate) * (law * sense)  # the contact keeps its sign in a small swing
        push, arm = cosine + law_now * friction * sine, p["r"] * (law_now * friction * cosine - sine)
        torque = torque_0 - p["k"] * y[0] - p["c"] * y[1]
        if part == "rigid":
            drive = np.array([[p["I"], arm], [p["m"] * lever, push]])
            turning, _ = np.linalg.solve(drive, [torque, axial_0 - p["c_x"] * lever * y[1]])
            return [y[1], turning]
        if part == "support":
            drive = np.array([[p["I"], 0, arm], [p["m"] * lever, p["m"], push], [0, p["m_1"], -push]])
            load = axial_0 - p["c_x"] * (lever * y[1] + y[3])
            turning, shift, _ = np.linalg.solve(drive, [torque, load, -axial_0 - p["k_1"] * y[2] - p["c_1"] * y[3]])
            return [y[1], turning, y[3], shift]
        gap, opening = cosine * (y[2] - lever * y[0]), cosine * (y[3] - lever * y[1])
        force = contact + p["k_c"] * gap + p["c_c"] * opening
        moved = (axial_0 - p["c_x"] * y[3] - force * push) / p["m"]
        return [y[1], (torque - force * arm) / p["I"], y[3], moved]

    return rates
