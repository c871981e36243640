r"""The rigid drive in balls and power series: slip under one law in closed form, and the limit cycle of slip.

All is written for Ω > 0; for Ω < 0 the drive is mirrored. Slip under law s is the oscillator Γ_s y″ + C_s y′ + k y = 0
about its equilibrium y = 0, where Q = q_u y + q_w w + Γ_s R̃ (8.17). With S its impulse response and C = S′ + a₁ S its
response to a unit displacement (a₀ = k / Γ, a₁ = C / Γ), every linear function of the state along it has a derivative
p S′ + q S, whose zeros are known in closed form.

The limit cycle of slip without rest, for Γ₊ > 0 > C₊ and R̃ > 0 (Sect. 8.5), has two half returns. Without θ′ = 0 the
drive is a plane system, linear on either side of Q = 0 and continuous there, and everything in it is in proportion to
R̃. Under law s, Q is an oscillator about E_s = Γ_s R̃ > 0; both laws have the same Q′ on Q = 0. A motion that leaves
Q = 0 with the slope v and comes back for the first time after τ does so with

    v = −E (1 − C) / S,        v̂ = v S′ + E a₀ S                                  (responses C, S at τ).

The cycle is a pair of times at which v̂₊ = v₋ and v̂₋ = v₊. There is exactly one if slip under law + turns and large
motions decay, π α₊ / β₊ + π α₋ / β₋ > 0, and none otherwise (docs/cycles.md).
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import count, islice, takewhile
from types import SimpleNamespace
from typing import Any

from flint import arb, arb_series

from lsvib.drives import friction, mechanics
from lsvib.drives.drive import STATIC, Drive, require_direction
from lsvib.errors import NoThreshold
from lsvib.stability.solve import bracketed_root

CLOSE = 1e-25  # relative error of a time before Newton's method, which squares it in every step


def constant(x: Any) -> arb:
    """Return a ball, or the constant term of a power series."""
    found: arb = x[0] if isinstance(x, arb_series) else x
    return found


def _oscillation(z: Any) -> tuple[Any, Any]:
    """cos √z and sin √z / √z, entire functions of z: cosh √−z and sinh √−z / √−z for negative z."""
    at = constant(z)
    if at > 0:
        root = z.sqrt()
        sine, cosine = root.sin_cos()
        return cosine, sine / root
    if at < 0:
        root = (-z).sqrt()
        grown = root.exp()
        return (grown + 1 / grown) / 2, (grown - 1 / grown) / (2 * root)
    w = -at / 4  # across zero by the hypergeometric function ₀F₁(b; w), whose derivative is ₀F₁(b + 1; w) / b
    values = [(w.hypgeom_0f1(b), w.hypgeom_0f1(b + 1) / (-4 * b)) for b in (arb(0.5), arb(1.5))]
    if not isinstance(z, arb_series):
        return values[0][0], values[1][0]
    cosine, ratio = (arb_series([value, slope * z[1]], prec=2) for value, slope in values)
    return cosine, ratio


class Slip:
    """Slip with effective inertia Γ [kg m²], damping C [N m s/rad] and stiffness k [N m/rad], balls or power series."""

    def __init__(self, inertia: Any, damping: Any, stiffness: Any) -> None:
        self.a0, self.a1 = stiffness / inertia, damping / inertia
        self.alpha = self.a1 / 2
        self.square = self.a0 - self.alpha**2
        self.turns = bool(constant(self.square) > 0)

    @property
    def beta(self) -> Any:
        """Imaginary part of the rates [1/s] if slip turns, else half of their distance."""
        return (self.square if self.turns else -self.square).sqrt()

    @property
    def rates(self) -> tuple[arb, arb]:
        """The two rates [1/s] of slip that does not turn, the slow one first."""
        return -self.alpha + self.beta, -self.alpha - self.beta

    def responses(self, time: Any) -> tuple[Any, Any, Any]:
        """Return C, S and S′ at a time [s]; one formula whether slip turns or not."""
        cosine, ratio = _oscillation(self.square * time**2)
        decay = (-self.alpha * time).exp()
        c, s = decay * cosine, decay * time * ratio
        return c + self.alpha * s, s, c - self.alpha * s

    def state(self, u: Any, w: Any, time: Any) -> tuple[Any, Any]:
        """Return (u, w) a time [s] after the deviation u [rad] from the equilibrium and the rate w [rad/s]."""
        c, s, s_rate = self.responses(time)
        return u * c + w * s, w * s_rate - self.a0 * u * s

    def stationary(self, u: arb, w: arb, row: tuple[Any, Any]) -> Iterator[arb]:
        """Yield the times [s] > 0, in order, at which row[0] · u + row[1] · w is stationary; for ever if slip turns."""
        force = -self.a0 * u - self.a1 * w
        p, q = row[0] * w + row[1] * force, -self.a0 * (row[0] * u + row[1] * w)
        if self.turns:
            phase = arb.atan2(arb(p), (self.alpha * p - q) / self.beta)
            phase = phase + arb.pi() if phase < 0 else phase
            yield from ((phase + n * arb.pi()) / self.beta for n in count(0 if phase > 0 else 1))
        else:
            slow, fast = (p * rate + q for rate in self.rates)
            if slow != 0 and fast / slow > 1:
                yield (fast / slow).log() / (2 * self.beta)

    def peak(self, u: arb, w: arb, row: tuple[Any, Any]) -> tuple[arb, arb] | None:
        """Largest value that row[0] · u + row[1] · w has at a later local maximum, and its time [s]; None if at none.

        For slip that decays: its first maximum is then the largest.
        """
        for time in islice(self.stationary(u, w, row), 2):
            place, rate = self.state(u, w, time)
            acceleration = -self.a0 * place - self.a1 * rate
            if row[0] * acceleration - row[1] * (self.a0 * rate + self.a1 * acceleration) < 0:
                return row[0] * place + row[1] * rate, time
        return None

    def recurrence(self) -> arb:
        """Time [s] at which C = 1 for the first time: motion from w′ = 0 comes back to its w. For slip that grows.

        It lies between half a turn and a whole one.
        """
        turn = 2 * arb.pi() / self.beta
        found: arb = bracketed_root(lambda time: self.responses(time)[0] - 1, turn / 2, turn, CLOSE)
        return found


class SlipDrive:
    """Constants of a rigid drive (eqs 8.13–8.17), balls or power series, mirrored if need be so that Ω > 0.

    Arguments: its parameters by name; ``sense``, sgn Ω. ``xi``, ``inertia`` Γ and ``damping`` C by law; ``lever``
    r_m tan λ [m]; ``sliding``: μ, F_0 and T_0, ``static``: the same at rest; ``contact``, the row (q_u, q_w) of Q;
    ``onset``, R_on = r_m tan λ c_x Ω [N]; ``net``, R̃ [N].
    """

    def __init__(self, p: Mapping[str, Any], sense: int) -> None:
        t, self.radius, self.stiffness = p["lead_angle"].tan(), p["pitch_radius"], p["coupling_stiffness"]
        self.lever, self.mass, self.slide = self.radius * t, p["mass"], p["translation_damping"]
        self.speed, self.force = p["input_speed"] * sense, p["axial_force"] * sense
        self.onset = self.lever * self.slide * self.speed
        self.net = self.force - self.onset
        self.tangent, self.sliding = t, [p.get(name, 0) for name, *_ in STATIC.values()]
        self.static = [p.get(name, sliding) for name, sliding in zip(STATIC, self.sliding, strict=True)]
        d = SimpleNamespace(**p, tan_lead=t)
        self.xi, self.inertia, self.damping = mechanics.by_law(d, d.friction_coefficient)
        turned = self.mass * d.support_damping - d.screw_inertia * self.slide
        self.contact = self.lever * self.mass * self.stiffness, self.lever * turned

    @classmethod
    def of(cls, drive: Drive, rest: bool = False) -> "SlipDrive":
        """Make the constants of a drive in balls, in the digits of the context.

        Raises ``NoThreshold`` where friction depends on the sliding speed, as slip has no closed form then, and for
        thresholds of motions with ``rest`` also where static friction is above that of sliding, as rest ends elsewhere.
        """
        require_direction(drive)
        if wanted := friction.refusal(drive, rest):
            raise NoThreshold(f"this threshold {wanted}.")
        return cls({name: arb(value) for name, value in drive}, 1 if drive.input_speed > 0 else -1)

    def slip(self, law: int) -> Slip:
        """Return slip under a law."""
        return Slip(self.inertia[law], self.damping[law], self.stiffness)

    def braked(self, dry: Sequence[Any]) -> tuple[int, Any]:
        """Return the law and the torque [N m] of threads, guide and bearing with ``dry``: ``static`` or ``sliding``."""
        mu, guide, bearing = dry
        force = self.force - guide
        law = 1 if constant(force) > 0 else -1
        return law, self.radius * force * mechanics.friction_factor(mu, self.tangent, law) + bearing

    @property
    def outward(self) -> Any:
        """κ = q_u − q_w c_x / m in Q′ = κ w + ρ on the line Q = 0."""
        return self.contact[0] - self.contact[1] * self.slide / self.mass

    @property
    def reach(self) -> Any:
        """r_m (ξ₊ − ξ₋) / k [rad/N]: times R, the width of the band of rest."""
        return self.radius * (self.xi[1] - self.xi[-1]) / self.stiffness

    def end_without_force(self, law: int = -1) -> Any:
        """Deflection y [rad] from the equilibrium of a law at which T_r reaches r_m ξ_s R: C_s Ω / k."""
        return self.damping[law] * self.speed / self.stiffness

    def end_of_rest(self, force: Any) -> Any:
        """Deflection y [rad] from the equilibrium of law − at which rest ends; for R > 0 T_r is r_m ξ₊ R there."""
        return self.end_without_force() - (self.reach * force if constant(force) > 0 else 0)


def half_return(slip: Slip, height: Any, time: Any) -> tuple[Any, Any]:
    """Slopes v and v̂ of a half return that takes a time [s], with the equilibrium at Q = ``height``."""
    c, s, s_rate = slip.responses(time)
    leaves = -height * (1 - c) / s
    return leaves, leaves * s_rate + height * slip.a0 * s


def leaving(slip: Slip, contact: Any, height: Any, slope: Any) -> tuple[Any, Any]:
    """State (y, w) in which a half return leaves Q = 0.

    Arguments: slip under the law; row (q_u, q_w) of Q; ``height``, Q at the equilibrium; the slope v. Q = q_u y + q_w w
    + height vanishes here and Q′ = q_u w − q_w (a₀ y + a₁ w) is v.
    """
    q_u, q_w = contact
    w = (slope - q_w * slip.a0 * height / q_u) / (q_u - q_w * slip.a1 + q_w**2 * slip.a0 / q_u)
    return -(q_w * w + height) / q_u, w


def slowest_point(drive: SlipDrive) -> tuple[arb, int, tuple[arb, arb, arb]]:
    """Return the point of the cycle at which the screw is slowest; the conditions of the module docstring must hold.

    Its rate w [rad/s] at R̃ = 1 N and its law; times [s] of the half returns under law + and law −, and from Q = 0 to
    this point. Raises ``NoThreshold`` where the digits do not hold the cycle.
    """
    plus, minus = drive.slip(1), drive.slip(-1)
    # The sizes of the two equilibria count by their ratio only.
    heights = {law: drive.inertia[law] / drive.inertia[-1] for law in (1, -1)}
    nearest = arb(10).log() * -40  # logarithm of the smallest phase beyond half a turn that is tried
    turn, back = arb.pi() / plus.beta, arb.pi() / minus.beta if minus.turns else 1 / minus.a0.sqrt()

    def short_time(logit: Any) -> Any:
        return back / (1 + (-logit).exp()) if minus.turns else back * logit.exp()

    def time_below(slope: arb) -> arb:
        """Time after which a motion that leaves Q = 0 downwards with a slope comes back."""

        def balance(logit: arb) -> Any:
            c, s, _ = minus.responses(short_time(logit))
            rise, fall = heights[-1] * (1 - c), -slope * s
            return (rise - fall) / (rise + fall)

        # Slip that turns comes back within half a turn, perhaps hardly earlier; other slip comes back at some time.
        low, high = nearest, -nearest if minus.turns else arb(1)
        while not minus.turns and balance(high) < 0:
            low, high = high, high + 1
        found: arb = short_time(bracketed_root(balance, low, high, CLOSE))
        return found

    def excess(logarithm: arb) -> Any:
        leaves, comes = half_return(plus, heights[1], turn + logarithm.exp() / plus.beta)
        _, again = half_return(minus, heights[-1], time_below(comes))
        return (again - leaves) / (abs(again) + abs(leaves))

    # Beyond this phase a motion under law + that leaves Q = 0 upwards does not come back: C = 1, so that v = 0.
    grazing = plus.recurrence() * plus.beta - arb.pi()
    low, high = nearest, (grazing * (1 - arb(1e-9))).log()
    if not excess(low) < 0 < excess(high):
        raise NoThreshold(
            "the force is not known: the rates of slip lie too far apart for the precision of the computation."
        )
    first = turn + bracketed_root(excess, low, high, CLOSE).exp() / plus.beta
    times = first, time_below(half_return(plus, heights[1], first)[1])
    slowest = []
    for law, time in zip((1, -1), times, strict=True):
        slip, height = drive.slip(law), drive.inertia[law]
        y, w = leaving(slip, drive.contact, height, half_return(slip, height, time)[0])
        instants = [arb(0), *takewhile(time.__gt__, slip.stationary(y, w, (0, 1)))]
        slowest += [(slip.state(y, w, at)[1], law, (*times, at)) for at in instants]
    return min(slowest, key=lambda point: point[0])
