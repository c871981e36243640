"""Newton's laws of the drives with axial support and with rotating nut, written anew for the references.

They import nothing else of the library. The contact is described by its normal force N and the friction f along the
helix, as unknowns beside the accelerations:

    axial force of the threads on the nut  -(N cos + f sin),     torque on the screw  -r (f cos - N sin),

the screw of the support model shifts by x_1 under +(N cos + f sin), the nut of the other turns by theta_2 under
+r (f cos - N sin). Slip in the direction d: f = d mu |N|. Rest: the relative speed stays zero and |f| <= mu |N|.

A mode is (d, q, a): direction of slip (0: rest), sign of N (of the axial contact force at rest; 0 where it plays no
part), direction of the second friction - F_0 on the slide of the support model, T_0 on the screw of the nut model - or
0 where that body is held, or None where the scene has no such friction. The friction that acts along with the slip is
T_0 in the support model and F_0 in the nut model; rest lasts while the threads hold with that friction at either end.

After an event the mode follows whose own flow fulfils its own conditions (``lasts``, which a reference defines), tried
out one by one. In the Painleve region only law -1 is tried; if N = 0 there, the impact is computed from the impulses of
N and f.
"""

from itertools import product
from math import cos, sin, tan

import numpy as np
from mpmath import mp, mpf


class TwoBodiesTrueDrive:
    """Parameters p (SI units, keys of the library); ``frictions`` names those of F_0 and T_0 that are there.

    A reference derives from it, and says by ``lasts(mode, x, zero)`` whether a mode lasts from a state on.
    """

    def __init__(self, model, parameters, frictions=(), exact=False):
        number = mpf if exact else float
        self.exact, self.model = exact, model
        self.p = p = {key: number(value) for key, value in parameters.items()}
        self.cos, self.sin, self.tan = (
            [f(p["lead_angle"]) for f in (mp.cos, mp.sin, mp.tan)]
            if exact
            else [f(p["lead_angle"]) for f in (cos, sin, tan)]
        )
        self.F0, self.T0 = (p[name] * (name in frictions) for name in ("slide_friction", "bearing_friction"))
        self.along, self.second = (self.T0, self.F0) if model == "support" else (self.F0, self.T0)
        self.reach, self.Omega = p["pitch_radius"] * self.tan, p["input_speed"]
        turning = 1 if self.Omega > 0 else -1
        # Steady sliding: screw at Omega, no shift of the screw, no rotation of the nut.
        axial = p["axial_force"] - p["translation_damping"] * self.reach * self.Omega - self.F0 * turning
        law = -1 if axial * turning < 0 else 1
        normal = axial / (self.cos + law * p["friction_coefficient"] * self.sin)
        torque = p["pitch_radius"] * normal * (law * p["friction_coefficient"] * self.cos - self.sin)
        self.z0 = -(torque + p["support_damping"] * self.Omega + self.T0 * turning) / p["coupling_stiffness"]
        self.q0 = axial / p["support_stiffness"] if model == "support" else torque / p["nut_stiffness"]
        own = p["screw_mass"] * p["mass"] / (p["screw_mass"] + p["mass"]) if model == "support" else p["mass"]
        inertia = p["screw_inertia"]
        if model == "nut":
            inertia = inertia * p["nut_inertia"] / (inertia + p["nut_inertia"])
        xi = (p["friction_coefficient"] - self.tan) / (1 + p["friction_coefficient"] * self.tan)
        self.painleve = inertia <= xi * self.tan * own * p["pitch_radius"] ** 2

    # Kinematics: state (u, w, deviation of x_1 or theta_2, its rate)
    def speeds(self, x):
        """(speed of slip, speed of the second body, speed x' of the nut)."""
        if self.model == "support":
            travel = self.reach * (self.Omega + x[1]) + x[3]
            return self.Omega + x[1], travel, travel
        slip = self.Omega + x[1] - x[3]
        return slip, self.Omega + x[1], self.reach * slip

    def forces(self, mode, x, along=None):
        """Solve for (theta'', second acceleration, N, f, T_0 friction, F_0 friction) at a state."""
        p, (d, q, a) = self.p, mode
        m, radius, cosine, sine = p["mass"], p["pitch_radius"], self.cos, self.sin
        along = self.along * d if along is None else along
        torque = -p["coupling_stiffness"] * (self.z0 + x[0]) - p["support_damping"] * (self.Omega + x[1])
        push = p["axial_force"] - p["translation_damping"] * self.speeds(x)[2]
        arm = [0, 0, -radius * sine, radius * cosine, 0, 0]  # torque that the threads take from the screw
        axial = [0, 0, cosine, sine, 0, 0]
        rows, sides = [], []

        def equation(row, side):
            rows.append([r + 0 * m for r in row])
            sides.append(side + 0 * m)

        equation([p["screw_inertia"], 0, arm[2], arm[3], 1, 0], torque)
        if self.model == "support":
            spring = -p["support_stiffness"] * (self.q0 + x[2]) - p["axial_support_damping"] * x[3]
            equation([0, p["screw_mass"], -cosine, -sine, 0, 0], spring)
            nut, slip, second = [m * self.reach, m, *axial[2:]], [1, 0, 0, 0, 0, 0], [self.reach, 1, 0, 0, 0, 0]
            fixed_along, fixed_second = [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]
        else:
            spring = -p["nut_stiffness"] * (self.q0 + x[2]) - p["nut_damping"] * x[3]
            equation([0, p["nut_inertia"], -arm[2], -arm[3], 0, 0], spring)
            nut, slip = [m * self.reach, -m * self.reach, *axial[2:]], [1, -1, 0, 0, 0, 0]
            second = [1, 0, 0, 0, 0, 0]
            fixed_along, fixed_second = [0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 1, 0]
        nut[5] = 1
        equation(nut, push)
        equation(slip if d == 0 else [0, 0, -d * q * p["friction_coefficient"], 1, 0, 0], 0)
        equation(fixed_along, along)
        equation(second if a == 0 else fixed_second, 0 if a == 0 else self.second * (a or 0))
        return self.solve(rows, sides)

    def solve(self, rows, sides):
        """Linear equations, in the numbers of this drive."""
        if self.exact:
            return list(mp.lu_solve(mp.matrix(rows), mp.matrix(sides)))
        return np.linalg.solve(np.array(rows), np.array(sides))

    def row(self, function):
        """An affine function of the state as a row."""
        constant = function([0.0] * 4)
        return np.array([function([float(i == j) for j in range(4)]) - constant for i in range(4)] + [constant])

    def field(self, mode, x):
        """The rate of the state in a mode."""
        first, second, *_ = self.forces(mode, x)
        return [x[1], first, x[3], second]

    def conditions(self, mode):
        """Rows that are positive in a mode, and for each which speed (0: slip, 1: second) it is, or None."""
        d, q, a = mode
        mu = self.p["friction_coefficient"]
        found = []
        if d:
            found += [
                (d * self.row(lambda x: self.speeds(x)[0]), 0),
                (q * self.row(lambda x: self.forces(mode, x)[2]), None),
            ]
        else:
            for way in (1, -1):
                side = q or self.side(way)
                found.append((self.row(lambda x, w=way, s=side: self.room(mode, x, w, s, mu)), None))
            if q:
                found.append((q * self.row(lambda x: self.axial(self.forces(mode, x))), None))
        if a:
            found.append((a * self.row(lambda x: self.speeds(x)[1]), 1))
        elif a == 0:
            index = 5 if self.model == "support" else 4
            for way in (1, -1):
                found.append((self.row(lambda x, w=way: self.second - w * self.forces(mode, x)[index]), None))
        return found

    def side(self, way):
        """The side on which the thread bears while nothing but the load pushes."""
        force = self.p["axial_force"] - self.along * way
        return 1 if force > 0 else -1

    def axial(self, forces):
        """The force of the thread along the screw."""
        return forces[2] * self.cos + forces[3] * self.sin

    def room(self, mode, x, way, side, mu):
        """How far static friction is from its limit."""
        forces = self.forces(mode, x, along=way * self.along)
        return mu * side * forces[2] - way * forces[3]

    def modes(self):
        """Return the modes: direction of slip, sign of Q, direction of the second friction."""
        ways = (1, -1, 0) if self.second else (None,)
        slips = [(d, q) for d, q in product((1, -1), (1, -1)) if not self.painleve or d * q < 0]
        rests = [(0, 1), (0, -1)] if self.model == "support" else [(0, 0)]
        return [(d, q, a) for d, q in slips + rests for a in ways]

    def tie(self, x, zero):
        """Set the speeds with the indices in ``zero`` to exactly zero."""
        x = x.copy()
        if self.model == "support":
            x[1] = -self.Omega if 0 in zero else x[1]
            x[3] = -self.reach * (self.Omega + x[1]) if 1 in zero else x[3]
        else:
            x[1] = -self.Omega if 1 in zero else x[1]
            x[3] = self.Omega + x[1] if 0 in zero else x[3]
        return x

    def choose(self, x, zero, after=None):
        """Mode at a state with the speeds ``zero`` on zero; ``after``: sign of the impulse of a seizure."""
        fits = [mode for mode in self.modes() if self.lasts(mode, x, zero)]
        if not self.painleve:
            assert len(fits) == 1, f"{len(fits)} modes last at {x}: {fits}"
            return fits[0]
        against = (-after, after, None) if after else None
        if against in fits and after * self.forces(against, x)[2] > 0:
            return against
        rests = [mode for mode in fits if mode[0] == 0]
        fits = rests or fits
        assert len(fits) == 1, f"{len(fits)} modes last at {x}: {fits}"
        return fits[0]

    def impact(self, x):
        """Speeds after the slip has been stopped by impulses of N and f."""
        p, m = self.p, self.p["mass"]
        arm = [-p["pitch_radius"] * self.sin, p["pitch_radius"] * self.cos]
        if self.model == "support":
            rows = [[p["screw_inertia"], 0, *arm], [0, p["screw_mass"], -self.cos, -self.sin]]
            rows += [[m * self.reach, m, self.cos, self.sin], [1, 0, 0, 0]]
        else:
            rows = [[p["screw_inertia"], 0, *arm], [0, p["nut_inertia"], -arm[0], -arm[1]]]
            rows += [[m * self.reach, -m * self.reach, self.cos, self.sin], [1, -1, 0, 0]]
        slip = self.speeds(x)[0]
        jump = self.solve(rows, [0, 0, 0, -slip])
        assert abs(jump[3]) <= p["friction_coefficient"] * abs(jump[2]) * (1 + 1e-12), (
            "the impact needs too much friction"
        )
        sign = 1 if jump[2] > 0 else -1
        assert sign * slip > 0
        after = x + np.array([0, jump[0], 0, jump[1]])
        return self.tie(after, {0}), sign
