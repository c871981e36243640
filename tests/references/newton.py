"""Newton's laws of steady sliding of all four drives with friction that depends on the sliding speed, linearised.

Independent of ``lsvib.stability``: nothing of the library is used but the values of a drive. The unknowns are the
accelerations and the normal force N; the friction along the helix is s mu(v) N with the sliding speed
v = r |theta' - theta_2'| / cos(lambda). Numbers are flint's balls. Under a law the linearisation is by differences,
with 80 digits, of which only the middle is kept; without, the state matrix has the rates at unit states as columns.
Stability is by eigenvalues, or by Routh's array of the characteristic polynomial.
"""

import mpmath
from flint import acb, acb_mat, arb, arb_mat, ctx
from mpmath import mpf

DIGITS = 250  # rates of random drives lie up to 30 decades apart, and the polynomial has products of four of them
FEWER = 80  # of differences
STEP = arb(10) ** -25  # of a central difference, relative to the rates of the drive


def sign(x):
    return 1 if x > 0 else -1 if x < 0 else 0


class SlidingDrive:
    """The laws of a drive of a model; ``law`` s is that of steady sliding, of which the state is the deviation."""

    def __init__(self, model, drive):
        self.model = model
        self.p = p = {key: arb(value) for key, value in drive}
        self.sin, self.cos = p["lead_angle"].sin(), p["lead_angle"].cos()
        self.reach = p["pitch_radius"] * self.sin / self.cos
        self.sense = sign(p["input_speed"])
        drag = p["translation_damping"] * self.reach * p["input_speed"] + p.get("slide_friction", 0) * self.sense
        self.axial = p["axial_force"] - drag
        self.law = sign(self.axial) * self.sense

    def friction(self, speed):
        """The coefficient at a speed of the threads [rad/s]."""
        p, v = self.p, self.p["pitch_radius"] * abs(speed) / self.cos
        value = p["friction_coefficient"] + p.get("friction_slope", 0) * v
        if p.get("stribeck_rise"):
            power = 2 if p.get("stribeck_exponent", 1) == 2 else 1
            value += p["stribeck_rise"] * (-((v / p["stribeck_speed"]) ** power)).exp()
        return value if value > 0 else arb(0)

    def steady(self):
        """The state (z, theta', second place, its rate) of steady sliding, by the balance of forces."""
        p, omega = self.p, self.p["input_speed"]
        rub = self.law * self.friction(omega)
        normal = self.axial / (self.cos + rub * self.sin)
        torque = p["pitch_radius"] * normal * (rub * self.cos - self.sin)
        load = torque + p["support_damping"] * omega + p.get("bearing_friction", 0) * self.sense
        place = {
            "rigid": lambda: [],
            "threads": lambda: [normal / (self.cos * p["contact_stiffness"]), arb(0)],
            "support": lambda: [self.axial / p["support_stiffness"], arb(0)],
            "nut": lambda: [torque / p["nut_stiffness"], arb(0)],
        }[self.model]()
        return [-load / p["coupling_stiffness"], omega, *place]

    def equations(self, state):
        """Matrix and right sides of the equations of screw, second body and nut, at a state."""
        p, radius, reach = self.p, self.p["pitch_radius"], self.reach
        z, turn, place, rate = [*state, arb(0), arb(0)][:4]
        slip = turn - rate if self.model == "nut" else turn
        travel = reach * slip + (0 if self.model == "nut" else rate)
        rub = self.law * self.friction(slip)
        arm, push = radius * (rub * self.cos - self.sin), self.cos + rub * self.sin
        torque = -p["coupling_stiffness"] * z - p["support_damping"] * turn - p.get("bearing_friction", 0) * self.sense
        force = p["axial_force"] - p["translation_damping"] * travel - p.get("slide_friction", 0) * self.sense
        screw, nut = [p["screw_inertia"], 0, arm], [p["mass"] * reach, p["mass"], push]
        if self.model == "rigid":
            other, side = [0, 1, 0], 0
        elif self.model == "threads":
            other = [0, 0, 1]
            side = self.cos * (p["contact_stiffness"] * place + p["contact_damping"] * rate)
        elif self.model == "support":
            other = [0, p["screw_mass"], -push]
            side = -p["support_stiffness"] * place - p["axial_support_damping"] * rate
        else:
            nut[1] *= -reach
            other = [0, p["nut_inertia"], -arm]
            side = -p["nut_stiffness"] * place - p["nut_damping"] * rate
        return arb_mat([screw, other, nut]), arb_mat(3, 1, [torque, side, force])

    def solved(self, state):
        """The accelerations of the screw and of the second body, and N, at a state."""
        matrix, sides = self.equations(state)
        return matrix.solve(sides).entries()

    def rates(self, state):
        first, second, _ = self.solved(state)
        return [state[1] - self.p["input_speed"], first, *state[3:], second][: len(state)]

    def eigenvalues(self):
        """Eigenvalues [1/s] of steady sliding, in ascending real part; it must be a state of rest of the laws."""
        state = self.steady()
        size = len(state)
        assert all(rate.contains(0) for rate in self.rates(state))
        jacobian = acb_mat(size, size)
        for j in range(size):
            step = STEP * (self.p["input_speed"] if j % 2 else arb(1))
            ends = []
            for way in (1, -1):
                moved = list(state)
                moved[j] += way * step
                ends.append(self.rates(moved))
            for i in range(size):
                jacobian[i, j] = acb(((ends[0][i] - ends[1][i]) / (2 * step)).mid())
        return sorted(jacobian.eig(nonstop=True), key=lambda x: (float(x.real), float(x.imag)))


def eigenvalues_by_differences(model, drive):
    """Eigenvalues [1/s] of the steady sliding of a drive, as mpmath's complex numbers."""
    with ctx.workdps(FEWER):
        found = SlidingDrive(model, drive).eigenvalues()
    with mpmath.workdps(FEWER):
        return [mpmath.mpc(*(part.str(FEWER, radius=False) for part in (x.real, x.imag))) for x in found]


_ROUNDING = mpf(10) ** -100  # far below what doubles can come to by chance, far above DIGITS
_SPARE = 60  # digits that may be lost where the accelerations are solved for


def solved(function, model: str, drive):
    """What a function of the laws of a drive is, in the digits that mpmath works with."""
    with ctx.workdps(mpmath.mp.dps + _SPARE):
        found = function(SlidingDrive(model, drive))
        return found if isinstance(found, list | int) else mpf(found.mid())


def steady_law(drive) -> int:
    """Law of steady sliding by the force on the contact; 0 if there is none."""
    return solved(lambda laws: laws.law, "rigid", drive)


def state_matrix(model: str, drive, law: int) -> list[list[mpf]]:
    """State matrix; its columns are the rates at unit states, because without loads the equations are homogeneous."""

    def rates(laws: SlidingDrive) -> list[list[mpf]]:
        laws.law, laws.sense = law, 0
        laws.p |= {"axial_force": arb(0), "input_speed": arb(0)}
        size = 2 if model == "rigid" else 4
        columns = [laws.rates([arb(int(i == j)) for i in range(size)]) for j in range(size)]
        rows = zip(*columns, strict=True)
        return [[mpf(0) if x.contains(0) else mpf(x.mid()) for x in row] for row in rows]

    return solved(rates, model, drive)


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
