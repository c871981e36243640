"""Cycles of drives with rigid threads behind a motor, in many digits, from Newton's laws of motor, screw and nut:

    J θ_m″ = K_i (Ω t − θ_m) + K_p (Ω − θ_m′) − T,    T = −k (θ − θ_m) − d (θ′ − θ_m′),    x = r tan λ θ,
    I θ″ = T − c θ′ − r ξ_s n,    m x″ = R − c_x x′ − n,    ξ_s = (s μ − tan λ) / (1 + s μ tan λ) = tan(s atan μ − λ),

n the axial contact force, s = sgn θ′ sgn n. At rest n = R, and static friction, ξ_s with μ_s, holds while T is between
r ξ₊ R and r ξ₋ R. The state is (θ − Ω t, θ′, θ_m − Ω t, θ_m′, 1), a mode (sgn θ′, sgn n). Below the critical mass,
where each state of slip has one law. Nothing of the library is imported.
"""

from functools import cache

from mpmath import mp, mpf

REST, POINTS = (0, 0), 6  # points in the time 1/|λ| of the fastest rate of a mode, at which its guards are looked at


class MotorCycle:
    """The cycle with one rest that a start from rest comes to, by Newton's method on the return to rest.

    ``period`` [s]; ``amplitude`` [rad], half of the range of θ − Ω t; ``modes`` from rest to rest.
    """

    def __init__(self, drive, returns=10):
        self.drive, self.mode = {name: mpf(value) for name, value in drive.items()}, cache(self._mode)
        x = [mpf(0)] * 4  # the coupling relaxed, and the controller has seen no error
        for _ in range(returns):
            x = self.back(*x)
        found = mp.findroot(lambda *x: [b - a for a, b in zip(x, self.back(*x), strict=True)], x)
        self.back(*found)
        self.period, self.amplitude = self.time, (max(self.extremes) - min(self.extremes)) / 2

    def _mode(self, way, side):
        """Matrix of a mode, rows that stay positive in it, a step in time, and the matrix exponential of it."""
        p, friction = self.drive, self.drive["friction_coefficient"]
        k, speed, gain = p["coupling_stiffness"], p["input_speed"], p["speed_gain"]
        d, mu = p.get("coupling_damping", 0), friction if way else p.get("static_friction_coefficient", friction)
        lever = {s: p["pitch_radius"] * mp.tan(s * mp.atan(mu) - p["lead_angle"]) for s in (1, -1)}  # r ξ_s
        torque, lead = [-k, -d, k, d, 0], p["pitch_radius"] * mp.tan(p["lead_angle"])  # dx/dθ
        motor = [k, d, -k - p["integral_gain"], -d - gain, gain * speed]
        rates = [[0, abs(way), 0, 0, -speed], [0] * 5, [0, 0, 0, 1, -speed], [f / p["motor_inertia"] for f in motor]]
        if way:
            torque[1] -= p["support_damping"]
            load = [0, -p["translation_damping"] * lead, 0, 0, p["axial_force"]]
            laws = [[p["screw_inertia"], lever[way * side]], [p["mass"] * lead, 1]]  # θ″, n
            rates[1], force = (mp.matrix(laws) ** -1 * mp.matrix([torque, load])).tolist()
            guards = [[0, way, 0, 0, 0], [side * f for f in force]]
        else:
            low, high = sorted(arm * p["axial_force"] for arm in lever.values())  # T at the ends of rest
            guards = [[k, d, -k, -d, high], [*torque[:4], -low]]
        matrix = mp.matrix([*rates, [0] * 5])
        step = 1 / (POINTS * max(map(abs, mp.eig(matrix, left=False, right=False))))
        return matrix, guards, step, mp.expm(matrix * step)

    def back(self, *x):
        """State at the next return to rest; keeps the time until then, the extremes and the modes."""
        x, self.time, self.extremes, self.modes = mp.matrix([*x, 1]), mpf(0), [], [REST]
        while REST not in self.modes[1:]:
            x, fired = self.event(x, *self.mode(*self.modes[-1]))
            self.modes.append(self.follows(x, *self.modes[-1], fired))
        return list(x)[:4]

    def event(self, x, matrix, guards, step, over):
        """State at the next event of a mode, and which of its guards has come to zero."""
        rows = [*guards, [0, 1, 0, 0, -self.drive["input_speed"]]]  # the last: θ − Ω t is extreme
        self.extremes.append(x[0])
        while True:
            after, found = over * x, []
            for k, row in enumerate(rows):
                behind, ahead = mp.fdot(row, x), mp.fdot(row, after)
                if behind > 0 >= ahead or (row is rows[-1] and behind < 0 <= ahead):
                    root = mp.findroot(lambda t, g=row, y=x: mp.fdot(g, mp.expm(matrix * t) * y), (0, step), "illinois")
                    found.append((root, k, mp.expm(matrix * root) * x))
            for stay, k, there in sorted(found, key=lambda one: one[0]):
                if k < 2:
                    self.time += stay
                    return there, k
                self.extremes.append(there[0])
            x, self.time = after, self.time + step

    def follows(self, x, way, side, fired):
        """Mode after an event; a screw that stands has no speed, and slips where static friction does not hold it."""
        if way and fired:
            return way, -side
        x[1] = mpf(0)
        high, low = (mp.fdot(row, x) for row in self.mode(*REST)[1])
        if way and min(high, low) > 0:
            return REST
        way = 1 if high < low else -1
        return next((way, s) for s in (1, -1) if mp.fdot(self.mode(way, s)[1][1], x) > 0)
