"""Labels of many starts of the rigid drive by fixed steps: classical Runge–Kutta with switching, no closed form.

Shares no code with the engine. Newton's laws are those of ``reference.rigid``: with T = −k z − c θ′ and
P = R − c_x p θ′, Γ_s θ″ = T − r ξ_s P and Q = I P − m p T, p = r tan λ. Steps are cut at θ′ = 0 by linear
interpolation, a crossing of Q = 0 is noticed at the end of a step, so states are good to the order of the step; what
happens in the last part of the time decides the label.
"""

import numpy as np

from references.rigid_digits import RigidTrueDrive, simulate

STEADY, STICK_SLIP, SPRAG_SLIP, OTHER = range(4)


def labels(parameters, u, w, duration, step, watch):
    """Labels of starts (n) under the rule "contact_sign"; ``watch``: time at the end [s] that decides."""
    drive = RigidTrueDrive(parameters, 30)
    k, c, cx, p, r = (float(x) for x in (drive.k, drive.c, drive.cx, drive.p, drive.r))
    inertia, mass, omega, force = (float(x) for x in (drive.I, drive.m, drive.Omega, drive.R))
    xi, gamma = {s: float(drive.xi(s)) for s in (-1, 1)}, {s: float(drive.Gamma(s)) for s in (-1, 1)}
    low, high = (float(x) for x in drive.band)
    z, v = np.array(u, dtype=float) + float(drive.z0), np.array(w, dtype=float) + omega
    painleve = bool(drive.painleve)

    def contact(z, v):
        return inertia * (force - cx * p * v) + mass * p * (k * z + c * v)

    def acceleration(z, v, direction):
        torque, push = -k * z - c * v, force - cx * p * v
        law = -1.0 if painleve else direction * np.sign(contact(z, v))
        plus = (torque - r * xi[1] * push) / gamma[1]
        minus = (torque - r * xi[-1] * push) / gamma[-1]
        return np.where(law > 0, plus, minus)

    def by_band(z):
        """Direction of the slip that follows θ′ = 0, 0 for rest."""
        return np.where(-k * z > high, 1.0, np.where(-k * z < low, -1.0, 0.0))

    def seized(z, v, direction):
        """Direction after a seizure of motion in ``direction``."""
        sign = direction  # of the impulse
        at_once = (contact(z, 0 * v) * sign > 0) & (acceleration(z, 0 * v, -direction) * -sign > 0)
        return np.where(at_once, -sign, by_band(z))

    direction = np.where(v != 0, np.sign(v), by_band(z))
    last = {name: np.full(z.size, -np.inf) for name in ("seizure", "rest", "reversal")}
    sign = np.sign(contact(z, v))
    count = round(duration / step)
    for n in range(count):
        t = n * step
        moving = direction != 0
        if painleve:
            bad = moving & (contact(z, v) * direction > 0)
            if bad.any():
                after = seized(z, v, direction)
                v, direction = np.where(bad, 0.0, v), np.where(bad, after, direction)
                last["seizure"][bad] = t
                moving = direction != 0
        d = direction
        a1 = acceleration(z, v, d)
        z2, v2 = z + 0.5 * step * (v - omega), v + 0.5 * step * a1
        a2 = acceleration(z2, v2, d)
        z3, v3 = z + 0.5 * step * (v2 - omega), v + 0.5 * step * a2
        a3 = acceleration(z3, v3, d)
        z4, v4 = z + step * (v3 - omega), v + step * a3
        a4 = acceleration(z4, v4, d)
        new_z = z + step / 6 * (v + 2 * v2 + 2 * v3 + v4 - 6 * omega)
        new_v = v + step / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        stopped = moving & (new_v * direction <= 0)
        part = np.where(stopped & (new_v != v), v / np.where(new_v != v, v - new_v, 1.0), 1.0)
        new_z = np.where(stopped, z + part * (new_z - z), new_z)
        new_z = np.where(moving, new_z, z - omega * step)
        new_v = np.where(moving & ~stopped, new_v, 0.0)
        z, v = new_z, new_v
        direction = np.where(moving & ~stopped, direction, by_band(z))
        last["rest"][direction == 0] = t
        now = np.sign(contact(z, v))
        last["reversal"][(now != sign) & moving] = t
        sign = now
    recent = {name: times > duration - watch for name, times in last.items()}
    found = np.full(z.size, STEADY)
    found[recent["reversal"]] = OTHER
    found[recent["rest"]] = STICK_SLIP
    found[recent["seizure"]] = SPRAG_SLIP
    return found


def exact_label(parameters, u, w, duration, watch, rule="contact_sign"):
    """Label of one start by ``reference.rigid`` with 30 digits: by the events of the last ``watch`` [s]."""
    result = simulate(parameters, u, w, duration, dps=30, resume_rule=rule)
    kinds = {event.kind for event in result.events if event.time > duration - watch}
    if "seizure" in kinds:
        return SPRAG_SLIP
    if kinds & {"stick", "release"}:
        return STICK_SLIP
    return OTHER if kinds else STEADY
