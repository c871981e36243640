"""A race under the friction law of the powered seat: ``python -m benchmarks.rivals.friction_law``.

Prints, for the engine, heyoka and CVODE from event to event in Python, the relative error of a period against 33 digits
and the processor time that one takes. The rivals follow slip alone, to θ′ = 0; rest is a straight line.
"""

import math
import time
from collections.abc import Callable

from references.friction_law_digits import simulate

from lsvib.engine.motion import follow
from lsvib.models.drive import Drive
from lsvib.models.rigid import rigid_automaton

DRIVE = Drive(friction="powered_seat", axial_force=100.0)
RADIUS, TANGENT = DRIVE.pitch_radius, math.tan(DRIVE.lead_angle)
LEVER, REACH = RADIUS / math.cos(DRIVE.lead_angle), RADIUS * TANGENT
TOLERANCES = (1e-8, 1e-12, 2.2e-16)
Periods = Callable[[int], float]  # the time [s] that so many periods take, from a release on


def coefficient(speed, exp):
    """The law at a sliding speed [m/s]."""
    rise = DRIVE.stribeck_rise * exp(-speed / DRIVE.stribeck_speed)
    return DRIVE.friction_coefficient + rise + DRIVE.friction_slope * speed


def twist(speed: float) -> float:
    """Deflection of the coupling [rad] that carries friction at a speed of the screw [rad/s] and its damping."""
    mu, force = coefficient(LEVER * speed, math.exp), DRIVE.axial_force - REACH * DRIVE.translation_damping * speed
    torque = RADIUS * (mu - TANGENT) / (1 + mu * TANGENT) * force + DRIVE.support_damping * speed
    return -torque / DRIVE.coupling_stiffness


RELEASE = twist(0.0)


def acceleration(z, speed, exp):
    """θ″ in slip under law + [rad/s²], by one quotient, as a series takes the least work for it."""
    mu = coefficient(LEVER * speed, exp)
    torque = -DRIVE.coupling_stiffness * z - DRIVE.support_damping * speed
    force = DRIVE.axial_force - REACH * DRIVE.translation_damping * speed
    over, under = 1 + mu * TANGENT, RADIUS * (mu - TANGENT)
    return (over * torque - under * force) / (over * DRIVE.screw_inertia - under * REACH * DRIVE.mass)


def engine() -> Periods:
    """The engine: slip in two halves with passages between them, stick and release."""
    automaton, start = rigid_automaton(DRIVE), (RELEASE - twist(DRIVE.input_speed), -DRIVE.input_speed)
    return lambda periods: float(follow(automaton, start, math.inf, max_events=4 * periods).time[-1])


def heyoka(tolerance: float) -> Periods:
    """heyoka's Taylor integrator with a terminal event."""
    import heyoka as hy

    z, speed = hy.make_vars("z", "v")
    field = [(z, speed - DRIVE.input_speed), (speed, acceleration(z, speed, hy.exp))]
    stop = hy.t_event(speed + 1e-14, direction=hy.event_direction.negative, cooldown=0.0)  # slip begins on θ′ = 0
    arc = hy.taylor_adaptive(field, [RELEASE, 0.0], t_events=[stop], tol=tolerance)
    state = arc.state

    def run(periods: int) -> float:
        """Follow so many periods."""
        now = 0.0
        for _ in range(periods):
            arc.time, state[0], state[1] = now, RELEASE, 0.0
            arc.propagate_until(now + 1.0)
            now = arc.time + (state[0] - RELEASE) / DRIVE.input_speed
        return now

    return run


def cvode(tolerance: float) -> Periods:
    """CVODE's Adams methods with its root finding."""
    from sksundae.cvode import CVODE

    def field(_, x, rate):
        rate[0], rate[1] = x[1] - DRIVE.input_speed, acceleration(x[0], x[1], math.exp)

    def stop(_, x, value):
        value[0] = x[1]

    stop.terminal, stop.direction = [True], [-1]

    def run(periods: int) -> float:
        """Follow so many periods."""
        now = 0.0
        for _ in range(periods):
            options = {"rtol": max(tolerance, 1e-14), "atol": tolerance, "max_num_steps": 20_000}
            arc = CVODE(field, method="Adams", eventsfn=stop, num_events=1, **options)
            arc.init_step(now, [RELEASE, 0.0])
            found = arc.step(now + 1.0, method="normal", tstop=now + 1.0)
            now = float(found.t) + (found.y[0] - RELEASE) / DRIVE.input_speed
        return now

    return run


def period() -> float:
    """The period [s] by the reference in 33 digits, from one release to the next."""
    start = RELEASE - twist(DRIVE.input_speed), -DRIVE.input_speed
    released = [event for event in simulate(DRIVE.model_dump(), *start, 0.05).events if event.kind == "release"]
    return float(released[1].time - released[0].time)


def compared(repeats: int = 20) -> dict[str, tuple[float, float]]:
    """Return relative error of a period and processor time of one [s], least of so many turns, by method."""
    runs = {"lsvib": (engine(), 400)}
    runs |= {f"heyoka {tolerance:.0e}": (heyoka(tolerance), 400) for tolerance in TOLERANCES}
    runs |= {f"CVODE {tolerance:.0e}": (cvode(tolerance), 20) for tolerance in TOLERANCES[:2]}
    exact, fastest = period(), dict.fromkeys(runs, math.inf)
    errors = {name: abs((run(count + 1) - run(1)) / count / exact - 1) for name, (run, count) in runs.items()}
    for _ in range(repeats):
        for name, (run, count) in runs.items():
            begin = time.process_time()
            run(count)
            fastest[name] = min(fastest[name], (time.process_time() - begin) / count)
    return {name: (errors[name], fastest[name]) for name in runs}


if __name__ == "__main__":
    for name, (error, seconds) in compared().items():
        print(f"{name:16} error {error:.1e}   {seconds * 1e6:8.1f} µs a period")
