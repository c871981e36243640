"""Newton's laws of the drives with four states, written anew: compliant threads, axial support, rotating nut.

They import nothing of the library. The contact is described by its normal force N and the friction f along the helix,
as unknowns beside the accelerations:

    axial force of the threads on the nut  -(N cos + f sin),     torque on the screw  -r (f cos - N sin),

the screw of the support model shifts by x_1 under +(N cos + f sin), the nut of the nut model turns by theta_2 under
+r (f cos - N sin); compliant threads press with N = cos (k_c e + c_c e'), e = x - r tan(lambda) theta. Slip in the
direction d: f = d mu |N|. Rest: the relative speed stays zero and |f| <= mu |N|.

A mode is (d, q, a): direction of slip (0: rest), sign of N (with a support that of the axial contact force at rest; 0
where it plays no part), direction of the second friction - F_0 on the slide of the support model, T_0 on the screw of
the nut model - or 0 where that body is held, or None where the scene has no such friction. The friction that acts along
with the slip is T_0 in the support model and F_0 in the nut model; rest lasts while the threads hold with that friction
at either end.

After an event the mode follows whose own flow fulfils its own conditions (``lasts``, which the reference defines):
they are tried out one by one. In the Painleve region only law -1 is tried; if N = 0 there, the impact is computed from
the impulses of N and f.
"""

from itertools import product

import numpy as np
from mpmath import mp, mpf


class FourStatesLaws:
    """Parameters p (SI units, keys of the library); ``frictions`` names those of F_0 and T_0 that are there.

    State: u, w, and the deviation of x_1 or theta_2 from steady sliding, or e, with its rate. The reference derives
    from it, and says how equations are solved and functions of the state become rows, and whether a mode lasts.
    """

    def __init__(self, model, parameters, frictions=()):
        self.model = model
        self.p = p = {key: mpf(value) for key, value in parameters.items()}
        self.cos, self.sin, self.tan = (f(p["lead_angle"]) for f in (mp.cos, mp.sin, mp.tan))
        self.F0, self.T0 = (p.get(name, 0) * (name in frictions) for name in ("slide_friction", "bearing_friction"))
        self.along, self.second = (self.F0, self.T0) if model == "nut" else (self.T0, self.F0)
        self.reach, self.Omega = p["pitch_radius"] * self.tan, p["input_speed"]
        turning = 1 if self.Omega > 0 else -1
        # Steady sliding: screw at Omega, no shift of the screw, no rotation of the nut.
        axial = p["axial_force"] - p["translation_damping"] * self.reach * self.Omega - self.F0 * turning
        law = -1 if axial * turning < 0 else 1
        normal = axial / (self.cos + law * p["friction_coefficient"] * self.sin)
        torque = p["pitch_radius"] * normal * (law * p["friction_coefficient"] * self.cos - self.sin)
        self.z0 = -(torque + p["support_damping"] * self.Omega + self.T0 * turning) / p["coupling_stiffness"]
        inertia, own, self.q0 = p["screw_inertia"], p["mass"], mpf(0)
        if model == "support":
            self.q0 = axial / p["support_stiffness"]
            own = p["screw_mass"] * own / (p["screw_mass"] + own)
        elif model == "nut":
            self.q0 = torque / p["nut_stiffness"]
            inertia = inertia * p["nut_inertia"] / (inertia + p["nut_inertia"])
        xi = (p["friction_coefficient"] - self.tan) / (1 + p["friction_coefficient"] * self.tan)
        self.painleve = model != "threads" and inertia <= xi * self.tan * own * p["pitch_radius"] ** 2

    def speeds(self, x):
        """(speed of slip, speed of the second body, speed x' of the nut)."""
        if self.model == "nut":
            slip = self.Omega + x[1] - x[3]
            return slip, self.Omega + x[1], self.reach * slip
        travel = self.reach * (self.Omega + x[1]) + x[3]
        return self.Omega + x[1], travel, travel

    def bodies(self):
        """Rows of inertia and of the contact's forces over (theta'', second, N, f), and that of slip."""
        p, m, reach = self.p, self.p["mass"], self.reach
        arm = [-p["pitch_radius"] * self.sin, p["pitch_radius"] * self.cos]  # torque the threads take from the screw
        screw = [p["screw_inertia"], 0, *arm]
        if self.model == "nut":
            turning = [0, p["nut_inertia"], -arm[0], -arm[1]]
            return [screw, turning, [m * reach, -m * reach, self.cos, self.sin]], [1, -1, 0, 0]
        other = [0, p["screw_mass"], -self.cos, -self.sin] if self.model == "support" else [0, 0, 1, 0]
        return [screw, other, [m * reach, m, self.cos, self.sin]], [1, 0, 0, 0]

    def spring(self, x):
        """What acts on the second body beside the contact; of compliant threads, N itself."""
        p = self.p
        if self.model == "threads":
            return self.cos * (p["contact_stiffness"] * x[2] + p["contact_damping"] * x[3])
        if self.model == "support":
            return -p["support_stiffness"] * (self.q0 + x[2]) - p["axial_support_damping"] * x[3]
        return -p["nut_stiffness"] * (self.q0 + x[2]) - p["nut_damping"] * x[3]

    def forces(self, mode, x, along=None):
        """Solve for (theta'', second acceleration, N, f, T_0 friction, F_0 friction) at a state."""
        p, (d, q, a) = self.p, mode
        (screw, other, nut), slip = self.bodies()
        torque = -p["coupling_stiffness"] * (self.z0 + x[0]) - p["support_damping"] * (self.Omega + x[1])
        push = p["axial_force"] - p["translation_damping"] * self.speeds(x)[2]
        bearing, slide = [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]
        if self.model == "nut":
            held, fixed_along, fixed_second = [1, 0, 0, 0, 0, 0], slide, bearing
        else:
            held, fixed_along, fixed_second = [self.reach, 1, 0, 0, 0, 0], bearing, slide
        rows = [[*screw, 1, 0], [*other, 0, 0], [*nut, 0, 1]]
        rows.append([*slip, 0, 0] if d == 0 else [0, 0, -d * q * p["friction_coefficient"], 1, 0, 0])
        rows += [fixed_along, held if a == 0 else fixed_second]
        sides = [torque, self.spring(x), push, 0, self.along * d if along is None else along, self.second * (a or 0)]
        return self.solve(rows, sides)

    def field(self, mode, x):
        """The rate of the state in a mode."""
        first, second, *_ = self.forces(mode, x)
        return [x[1], first, x[3], second]

    def conditions(self, mode):
        """Rows that are positive in a mode, and for each which speed (0: slip, 1: second) it is, or None."""
        d, q, a = mode
        found = []
        if d:
            found.append((d * self.row(lambda x: self.speeds(x)[0]), 0))
            found.append((q * self.row(lambda x: self.forces(mode, x)[2]), None))
        else:
            for way in (1, -1):
                found.append((self.row(lambda x, w=way: self.room(mode, x, w, q or self.side(w))), None))
            if q and self.model == "support":
                found.append((q * self.row(lambda x: self.axial(self.forces(mode, x))), None))
        if a:
            found.append((a * self.row(lambda x: self.speeds(x)[1]), 1))
        elif a == 0:
            index = 4 if self.model == "nut" else 5
            for way in (1, -1):
                found.append((self.row(lambda x, w=way: self.second - w * self.forces(mode, x)[index]), None))
        return found

    def side(self, way):
        """The side on which the thread bears while nothing but the load pushes."""
        return 1 if self.p["axial_force"] - self.along * way > 0 else -1

    def axial(self, forces):
        """The force of the thread along the screw."""
        return forces[2] * self.cos + forces[3] * self.sin

    def room(self, mode, x, way, side):
        """How far static friction is from its limit."""
        forces = self.forces(mode, x, along=way * self.along)
        return self.p["friction_coefficient"] * side * forces[2] - way * forces[3]

    def modes(self):
        """Return the modes: direction of slip, sign of N, direction of the second friction."""
        ways = (1, -1, 0) if self.second else (None,)
        slips = [(d, q) for d, q in product((1, -1), (1, -1)) if not self.painleve or d * q < 0]
        rests = [(0, 0)] if self.model == "nut" else [(0, 1), (0, -1)]
        return [(d, q, a) for d, q in slips + rests for a in ways]

    def tie(self, x, zero):
        """Set the speeds with the indices in ``zero`` to exactly zero."""
        x = x.copy()
        if self.model == "nut":
            x[1] = -self.Omega if 1 in zero else x[1]
            x[3] = self.Omega + x[1] if 0 in zero else x[3]
        else:
            x[1] = -self.Omega if 0 in zero else x[1]
            x[3] = -self.reach * (self.Omega + x[1]) if 1 in zero else x[3]
        return x

    def choose(self, x, zero, after=None):
        """Mode at a state with the speeds ``zero`` on zero; ``after``: sign of the impulse of a seizure."""
        fits = [mode for mode in self.modes() if self.lasts(mode, x, zero)]
        if self.painleve:
            against = (-after, after, None) if after else None
            if against in fits and after * self.forces(against, x)[2] > 0:
                return against
            fits = [mode for mode in fits if mode[0] == 0] or fits
        assert len(fits) == 1, f"{len(fits)} modes last at {x}: {fits}"
        return fits[0]

    def impact(self, x):
        """State after the slip has been stopped by impulses of N and f, and the sign of that of N."""
        bodies, slip = self.bodies()
        speed = self.speeds(x)[0]
        jump = self.solve([*bodies, slip], [0, 0, 0, -speed])
        assert abs(jump[3]) <= self.p["friction_coefficient"] * abs(jump[2]), "the impact needs too much friction"
        sign = 1 if jump[2] > 0 else -1
        assert sign * speed > 0
        return self.tie(x + np.array([0, jump[0], 0, jump[1]]), {0}), sign
