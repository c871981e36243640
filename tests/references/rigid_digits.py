"""High-precision reference for the rigid lead-screw drive (one degree of freedom).

A yardstick, not an engine: every line aims to be checkable by eye.  All numbers are mpmath
floats; inputs are taken as the exact doubles (or mpf) given.  It imports nothing of the library.

Newton's laws, with p = r tan(lambda) so that the nut moves by p*theta, and with A = N (cos + mu_s sin)
the axial force of the contact, mu_s = mu*s, s = sgn(theta_dot) sgn(N):

    I theta_dd   = T - r xi_s A,      T = -k z - c theta_dot,  z = theta - Omega t      (8.1), (8.13)
    m p theta_dd = P - A,             P = R - c_x p theta_dot
    xi_s = (mu_s - tan)/(1 + mu_s tan),  so xi_- = -(mu + tan)/(1 - mu tan)             (5.11), (8.4)

Eliminating A gives the motion, eliminating theta_dd gives the contact force:

    Gamma_s theta_dd = T - r xi_s P,     Gamma_s = I - xi_s r p m                       (8.2), (8.13)
    A = Q / Gamma_s,                     Q = I P - m p T                                (8.3), (8.5)

With u = z - z0, w = du/dt = theta_dot - Omega, R~ = R - p c_x Omega, s0 = sgn(R~ Omega):

    z0 = -(C_0 Omega + r xi_0 R)/k,      C_s = c - xi_s r p c_x                         (8.14), (8.15)
    Gamma_s u'' + C_s u' + k u = r (xi_0 - xi_s) R~                                     (8.16)
    Q = p [m k u + (m c - I c_x) w] + Gamma_0 R~                                        (8.17)

Where R~ Omega = 0, s0 = 0, i.e. xi_0 = -tan.

Law of motion
  rest   theta_dot = theta_dd = 0.  The coupling torque T_r = -k (z0 + u) grows at k*Omega; rest holds while T_r is
         within the band between r R xi_- and r R xi_+, with static friction where that is above mu.
  Gamma_+ > 0   sgn N = sgn Q; the law changes where Q = 0; at theta_dot = 0 the band decides.
  Gamma_+ <= 0  (Painleve region, (8.21)) only law s = -1 is ever followed: theta_dot > 0 with Q < 0, theta_dot < 0
         with Q > 0.  Reaching Q = 0, or starting where Q theta_dot > 0, is a seizure: theta_dot jumps to 0 at the
         same u, with an impulse of the sign nu of theta_dot.  How motion resumes is `resume_rule`, see `resume`.



The flow u'' + 2a u' + b (u - u_eq) = 0 has a closed form.  Both guards (theta_dot and Q) are linear in (u, w), so the
derivative h of a guard obeys h'' + 2a h' + b h = 0, whose roots are known in closed form.  Between two of them the
guard is monotone, hence a sign change is a bracket with exactly one root: no event can be missed.
"""

from dataclasses import dataclass, field
from itertools import chain

from mpmath import mp, mpf


def solve(f, slope, left, right, tolerance):
    """Root of a monotone f with f(left) > 0 >= f(right): Newton kept inside a shrinking bracket.

    Where Newton's steps do not halve (along a steep exponential they stay the same) the bracket is halved instead.
    """
    tolerance = max(tolerance, right * mpf(10) ** (5 - mp.dps))  # no finer than the working digits
    x, last = (left + right) / 2, right - left
    while right - left > tolerance:
        value, d = f(x), slope(x)
        if value > 0:
            left = x
        else:
            right = x
        step = -value / d if d != 0 else right - left
        if abs(step) < tolerance / 4:  # converged? then a step of tolerance brackets it
            low, high = max(left, x + step - tolerance / 2), min(right, x + step + tolerance / 2)
            if f(low) > 0 >= f(high):
                return x + step
        if not (left < x + step < right and abs(step) <= last / 2):
            step = (left + right) / 2 - x
        x, last = x + step, abs(step)
    return (left + right) / 2


class RigidTrueFlow:
    """Closed form of Gamma u'' + C u' + k u = force from (u0, w0) under law s, (8.16)."""

    def __init__(self, drive, s, u0, w0):
        Gamma, C, k = drive.Gamma(s), drive.C(s), drive.k
        self.a, self.b = C / (2 * Gamma), k / Gamma
        self.u_eq = drive.r * (drive.xi(drive.s0) - drive.xi(s)) * drive.R_tilde / k
        self.y0, self.w0 = u0 - self.u_eq, w0
        self.disc = self.a**2 - self.b
        self.omega = mp.sqrt(abs(self.disc))
        self.rate = abs(self.a) + mp.sqrt(self.b)  # no rate of the flow is faster
        if self.disc > 0:  # the larger root first: no cancellation
            self.l1 = -self.a - (self.omega if self.a >= 0 else -self.omega)
            self.l2 = self.b / self.l1

    def homogeneous(self, h0, h1, tau):
        """h(tau) for h'' + 2a h' + b h = 0, h(0) = h0, h'(0) = h1."""
        if self.disc > 0:
            return ((h1 - self.l2 * h0) * mp.exp(self.l1 * tau) + (self.l1 * h0 - h1) * mp.exp(self.l2 * tau)) / (
                self.l1 - self.l2
            )
        decay = mp.exp(-self.a * tau)
        if self.disc == 0:
            return decay * (h0 + (h1 + self.a * h0) * tau)
        cos, sin = mp.cos_sin(self.omega * tau)
        return decay * (h0 * cos + (h1 + self.a * h0) / self.omega * sin)

    def second(self, y, w):
        return -2 * self.a * w - self.b * y

    def state(self, tau):
        u = self.u_eq + self.homogeneous(self.y0, self.w0, tau)
        return u, self.homogeneous(self.w0, self.second(self.y0, self.w0), tau)

    def slope_start(self, guard):
        """h(0), h'(0) of h = d/dt (A u + B w + const)."""
        A, B, _ = guard
        acc = self.second(self.y0, self.w0)
        jerk = self.second(self.w0, acc)
        return A * self.w0 + B * acc, A * acc + B * jerk

    def extrema(self, guard, end):
        """All tau in (0, end) where the guard is stationary, in order."""
        h0, h1 = self.slope_start(guard)
        if h0 == 0 == h1:
            return
        if self.disc < 0:  # h0 cos x + h2 sin x = 0
            x = mp.atan2(-h0, (h1 + self.a * h0) / self.omega) % mp.pi
            while x / self.omega < end:
                if x > 0:
                    yield x / self.omega
                x += mp.pi
            return
        if self.disc == 0:
            roots = [-h0 / (h1 + self.a * h0)] if h1 + self.a * h0 != 0 else []
        else:
            first, second = h1 - self.l2 * h0, self.l1 * h0 - h1
            opposite = first * second < 0
            roots = [mp.log(-second / first) / (self.l1 - self.l2)] if opposite else []
        yield from (tau for tau in roots if 0 < tau < end)

    def first_root(self, guard, side, from_zero, end, digits):
        """First tau in (0, end] where side*guard falls to 0; None if it stays positive.

        from_zero: the guard is 0 at tau = 0 and has just been left on the right side.  Its stationary point at
        tau = 0 (release from rest: zero acceleration) may come out as a tiny positive tau: it is passed over.
        """
        A, B, const = guard
        h = self.slope_start(guard)

        def value(tau):
            u, w = self.state(tau)
            return side * (A * u + B * w + const)

        if not from_zero:
            assert value(mpf(0)) > 0
        left, tiny = mpf(0), mpf(10) ** -(digits // 2 + 5) / self.rate
        for right in chain(self.extrema(guard, end), [end]):
            if from_zero and left == 0 and right < min(tiny, end):
                continue
            if value(right) <= 0:
                if from_zero and left == 0:
                    if right <= tiny:  # the end of the run, a rounding away
                        return None
                    raise ArithmeticError("a guard left zero on the wrong side")
                return solve(
                    value,
                    lambda tau: side * self.homogeneous(*h, tau),
                    left,
                    right,
                    mpf(10) ** -(digits + 5) / self.rate,
                )
            left = right
        return None


def windows(first, end):
    """Growing parts of a run, so that a guard that never falls is not searched to the end if another one does."""
    while first < end:
        yield first
        first *= 4
    yield end


FORWARD, BACKWARD = 1, -1  # signs of theta_dot
REST = (0, 0)  # a mode is (direction of theta_dot, sign of Q); rest is (0, 0)
NAMES = {
    REST: "rest", (1, 1): "slip_forward_positive", (1, -1): "slip_forward_negative",
    (-1, 1): "slip_backward_positive", (-1, -1): "slip_backward_negative",
}  # fmt: skip
GUARD_DIGITS = 15  # extra working digits beyond the dps asked for

# Two sizes of "zero".  A value is rounding below 10^-dps of its terms.  At theta_dot = 0 a torque or Q that is off by
# a fraction d starts a slip that may last only d time scales and move theta_dot by d^2, lost in rounding for
# d < 10^-(dps/2 + 3): there such a d counts as zero, i.e. as the end of the band, or as the corner Q = 0.


@dataclass
class RigidTrueEvent:
    """An event: its time, its kind, the states on both sides of it and the mode that follows."""

    time: mpf
    kind: str  # contact_reversal, stick, reversal, release, seizure
    u_before: mpf
    w_before: mpf
    u_after: mpf
    w_after: mpf
    mode_after: str

    @property
    def state(self):
        return self.u_after, self.w_after


@dataclass
class RigidTrueSegment:  # the motion between two events
    time: mpf
    u: mpf
    w: mpf
    mode: tuple


@dataclass
class RigidTruth:
    """A motion with all of its digits: its end, its events and what lies between them."""

    time: mpf
    u: mpf
    w: mpf
    mode: str
    events: list
    segments: list
    complete: bool  # False: stopped at max_events, at `time` < t_end
    drive: object = field(repr=False)


class RigidTrueDrive:
    """Constants of the drive and the two guards theta_dot and Q as functions of (u, w)."""

    def __init__(self, parameters, dps):
        self.dps, self.half_digits = dps, dps // 2 + 3
        q = {name: mpf(value) for name, value in parameters.items()}
        self.r, self.I = q["pitch_radius"], q["screw_inertia"]
        self.k, self.c = q["coupling_stiffness"], q["support_damping"]
        self.mu, self.Omega, self.m = q["friction_coefficient"], q["input_speed"], q["mass"]
        self.cx, self.R = q["translation_damping"], q["axial_force"]
        self.tan = mp.tan(q["lead_angle"])
        self.p = self.r * self.tan
        self.by_law = {}  # xi, Gamma and C of each law, formed once
        for law in (-1, 0, 1):
            xi = (self.mu * law - self.tan) / (1 + self.mu * law * self.tan)
            Gamma, C = self.I - xi * self.r * self.p * self.m, self.c - xi * self.r * self.p * self.cx
            self.by_law[law] = xi, Gamma, C
        self.R_tilde = self.R - self.p * self.cx * self.Omega
        self.s0 = int(mp.sign(self.R_tilde * self.Omega))
        self.z0 = -(self.C(self.s0) * self.Omega + self.r * self.xi(self.s0) * self.R) / self.k  # (8.14)
        self.painleve = self.Gamma(+1) <= 0  # (8.21)
        self.u_scale = abs(self.Omega) * mp.sqrt(self.Gamma(-1) / self.k)  # a size of u, for rounding
        static = q.get("static_friction_coefficient") or self.mu
        edges = [self.r * self.R * (s * static - self.tan) / (1 + s * static * self.tan) for s in (-1, +1)]
        self.band = min(edges), max(edges)

    def xi(self, s):  # (5.11)
        return self.by_law[s][0]

    def Gamma(self, s):  # (8.2)
        return self.by_law[s][1]

    def C(self, s):  # below (8.13)
        return self.by_law[s][2]

    def T_rest(self, u):
        """Torque that holds the screw at rest."""
        return -self.k * (self.z0 + u)

    def Q_terms(self, u, w):  # (8.17)
        """Return the terms of Q (8.17) in u [rad] and w [rad/s], and its constant."""
        return (
            self.p * self.m * self.k * u,
            self.p * (self.m * self.c - self.I * self.cx) * w,
            self.Gamma(self.s0) * self.R_tilde,
        )

    def Q(self, u, w):
        """The function whose zeros are those of N (8.17)."""
        return sum(self.Q_terms(u, w))

    def Q_sign(self, u, w, digits=None):
        """Sign of Q, 0 if Q is zero to the given digits (dps)."""
        terms = self.Q_terms(u, w)
        size = max(abs(term) for term in (*terms, self.p * self.m * self.k * self.u_scale))
        return int(mp.sign(sum(terms))) if abs(sum(terms)) > mpf(10) ** -(digits or self.dps) * size else 0

    def Q_sign_next(self, u, w):
        """Sign of Q just after (u, w).  On Q = 0 both laws give theta_dd = P/(m p), which fixes dQ/dt."""
        P = self.R - self.cx * self.p * (w + self.Omega)
        rate = self.m * self.k * w + (self.m * self.c - self.I * self.cx) * P / (self.m * self.p)
        return self.Q_sign(u, w) or int(mp.sign(rate))

    def acceleration(self, s, u, w):  # (8.16)
        force = self.r * (self.xi(self.s0) - self.xi(s)) * self.R_tilde
        return (force - self.C(s) * w - self.k * u) / self.Gamma(s)

    # --- which mode follows -----------------------------------------------------------------------------------
    def by_band(self, u):
        """Mode at theta_dot = 0 chosen by the band of rest torques; its ends, to within rounding, belong to it."""
        low, high = self.band
        T, rounding = self.T_rest(u), mpf(10) ** -self.half_digits * self.k * max(abs(self.z0), abs(u), self.u_scale)
        if low - rounding <= T <= high + rounding:
            return REST
        direction = FORWARD if T > high else BACKWARD
        return direction, (-direction if self.painleve else self.Q_sign_next(u, -self.Omega))

    def resume(self, u, nu, rule):
        """Mode after a seizure with impulse sign nu, at theta_dot = 0 (docs/physics.md, "After a seizure")."""
        sign = self.Q_sign(u, -self.Omega, self.half_digits)
        wanted = nu if rule == "contact_sign" else sign
        direction = -wanted  # law s = -1
        if wanted and sign == wanted and mp.sign(self.acceleration(-1, u, -self.Omega)) == direction:
            return direction, wanted  # R = 0: Q = -m p T_r decides the torque as well
        return self.by_band(u) if rule == "contact_sign" else REST

    def release(self, u):
        """End of rest: T_r reached the end of the band that it moves towards."""
        direction = int(mp.sign(self.Omega))
        if self.painleve:
            return direction, -direction
        # Without static friction Q has the sign of R; R = 0: Q = -m p T_r, so N opposes the direction.
        return direction, self.Q_sign(u, -self.Omega, self.half_digits) or -direction

    def release_torque(self):
        return self.band[1] if self.Omega > 0 else self.band[0]


def simulate(parameters, u, w, t_end, *, dps=40, resume_rule="contact_sign", max_events=10000):
    """Follow the motion from (u, w) at t = 0 to t_end; see the module docstring for the law."""
    if resume_rule not in ("contact_sign", "at_once"):
        raise ValueError(resume_rule)
    with mp.workdps(dps + GUARD_DIGITS):
        return _simulate(RigidTrueDrive(parameters, dps), mpf(u), mpf(w), mpf(t_end), resume_rule, max_events)


def _simulate(drive, u, w, t_end, rule, max_events):
    """One loop over the arcs, as long as the law of motion in the module's docstring, to be read beside it."""
    t, events, segments = mpf(0), [], []
    w_rest = -drive.Omega
    speed_guard = mpf(0), mpf(1), drive.Omega  # theta_dot = w + Omega
    Q_guard = drive.Q_terms(mpf(1), mpf(1))

    def record(kind, u, w, w_after, mode):
        events.append(RigidTrueEvent(t, kind, u, w, u, w_after, NAMES[mode]))

    # --- the mode at the start
    direction = int(mp.sign(w + drive.Omega))
    if direction == 0:
        mode = drive.by_band(u)
    else:
        mode = direction, drive.Q_sign_next(u, w)
        if drive.painleve and mode[1] == direction:  # inconsistent sector
            mode = drive.resume(u, direction, rule)
            record("seizure", u, w, w_rest, mode)
            w = w_rest
    speed_is_zero = w == w_rest

    while True:
        segments.append(RigidTrueSegment(t, u, w, mode))
        if len(events) >= max_events:
            return RigidTruth(t, u, w, NAMES[mode], events, segments, t == t_end, drive)
        left = t_end - t
        if mode == REST:
            if drive.Omega == 0:
                return RigidTruth(t_end, u, w, NAMES[mode], events, segments, True, drive)
            tau = (drive.release_torque() - drive.T_rest(u)) / (drive.k * drive.Omega)
            tau = max(tau, mpf(0))  # rounding, see by_band
            if tau > left:
                return RigidTruth(t_end, u + w * left, w, NAMES[mode], events, segments, True, drive)
            t, u = t + tau, -drive.z0 - drive.release_torque() / drive.k
            mode, speed_is_zero = drive.release(u), True
            record("release", u, w, w, mode)
            continue

        direction, contact = mode
        flow = RigidTrueFlow(drive, direction * contact, u, w)
        for end in windows(10 / flow.rate, left):
            tau_v = flow.first_root(speed_guard, direction, speed_is_zero, end, drive.dps)
            tau = end if tau_v is None else tau_v
            tau_Q = flow.first_root(Q_guard, contact, drive.Q_sign(u, w) == 0, tau, drive.dps)
            if tau_v is not None or tau_Q is not None:
                break
        tau = tau if tau_Q is None else tau_Q
        u, w = flow.state(tau)
        t = t_end if tau == left else t + tau
        if tau_v is None and tau_Q is None:
            return RigidTruth(t_end, u, w, NAMES[mode], events, segments, True, drive)
        if tau_Q is not None and not drive.painleve:
            mode = direction, -contact
            record("contact_reversal", u, w, w, mode)
            speed_is_zero = False
            continue
        if tau_Q is not None:
            mode = drive.resume(u, direction, rule)
            record("seizure", u, w, w_rest, mode)
        else:
            mode = drive.resume(u, contact, rule) if drive.painleve else drive.by_band(u)
            record("stick" if mode == REST else "reversal", u, w, w_rest, mode)
        w, speed_is_zero = w_rest, True
