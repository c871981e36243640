"""What turns the screw, and whether the motor gives it: running, starting, at rest, in ramps, over a cycle of moves."""

from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.drives.mechanics import relieved_half
from lsvib.sheets.draw import Draw
from lsvib.sheets.formulas import flank_coefficient, torque
from lsvib.sheets.move import nodes

Floats = NDArray[np.float64]
Judged = tuple[Any, Any]  # values at many points and their limits, or None
Rubs = tuple[Any, Any, Any]  # friction of the square thread [1], of a collar [1], torque of the bearing [N m]

# What counts as the limit: the first that the sheet has, of two that stand together the lower one. A curve is what a
# motor gives for as long as a ramp takes.
RUNNING = ("torque_curve rated_torque", "peak_torque", "holding_torque")
RAMP = ("torque_curve peak_torque", "rated_torque", "holding_torque")
STANDING = ("holding_torque", "rated_torque", "torque_curve peak_torque")
# Rows whose limit is one of motor or brake, the first to be spoken of first.
LIMITED = ("motor_torque", "motor_starting_torque", "motor_holding_torque", "peak_torque", "rms_torque", "brake_torque")


def needed(draw: Draw, force: Any, rubs: Rubs, lifting: bool) -> Any:
    """Return the torque at the screw [N m] against or with a ``force`` [N], without damping."""
    other = relieved_half(force, draw.entries.get("nut.preload", 0.0), draw.entries.get("nut.load_share", 1.0))
    return torque(force, draw.pitch_radius, draw.lead_angle, rubs[0], lifting, rubs[1], other) + rubs[2]


def at_rest(draw: Draw) -> tuple[Any, Rubs, Any]:
    """Return friction of the flanks at rest [1], that of all that holds the screw, and that of the guide [N]."""
    values = draw.values
    slow = flank_coefficient(draw.friction_at(0.0)[0], draw.lead_angle, values["half_angle"])
    flank = values.get("static_friction_coefficient", slow)
    bearing = values.get("bearing_static_friction", values.get("bearing_friction", 0.0))
    guide = values.get("slide_static_friction", values.get("slide_friction", 0.0))
    return flank, (draw.square(flank), draw.collar, bearing), guide


def to_hold(draw: Draw, held: Any) -> Any:
    """Return the torque at the screw [N m] that holds a load at rest; not above zero where friction does."""
    _, rubs, guide = at_rest(draw)
    return -needed(draw, np.clip(np.abs(held) - guide, 0.0, None), rubs, False)


def turning(draw: Draw, speed: Any, held: Any, acceleration: Any = 0.0, damped: float = 1.0) -> Any:
    """Return the torque at the screw [N m] that turns it, below zero where it brakes; infinite where threads jam.

    ``speed`` [rad/s], the load that is ``held`` against the travel [N], ``acceleration`` of the load [m/s²], whose
    force goes through the threads as any load does; ``damped``: 0 without the dampings, which are guesses.
    """
    values, coefficient = draw.values, draw.friction_at(speed)[0]
    drag = damped * values["translation_damping"] * draw.travel * speed
    load = held + values.get("slide_friction", 0.0) + drag + values["mass"] * acceleration
    rubs = coefficient, draw.collar, values.get("bearing_friction", 0.0)
    against = np.where(coefficient * np.tan(draw.lead_angle) < 1, needed(draw, np.abs(load), rubs, True), np.inf)
    found = np.where(load > 0, against, needed(draw, np.abs(load), rubs, False))
    return found + damped * values["support_damping"] * speed + values["screw_inertia"] * acceleration / draw.travel


def before_gear(draw: Draw, torque: Any) -> Any:
    """Return the torque of the motor [N m] for one at the screw; losses of a gear help where the load drives it."""
    ratio, share = draw.entries.get("coupling.gear_ratio", 1.0), draw.entries.get("motor.gear_efficiency", 1.0)
    return np.where(torque > 0, torque / (ratio * share), torque * share / ratio)


def of_motor(draw: Draw, speed: Any, held: Any, acceleration: Any = 0.0) -> tuple[Any, Any]:
    """Return the torque of the motor [N m], and the largest either way if the dampings are not counted on."""
    own = draw.entries.get("motor.inertia", 0.0) * draw.entries.get("coupling.gear_ratio", 1.0)
    whole, bare = (
        before_gear(draw, turning(draw, speed, held, acceleration, damped)) + own * acceleration / draw.travel
        for damped in (1.0, 0.0)
    )
    return whole, np.maximum(np.abs(whole), np.abs(bare))


def limit(draw: Draw, names: tuple[str, ...], speed: Any) -> Any:
    """Return what the motor gives [N m] at a ``speed`` of the screw [rad/s], by the first of names that is given."""
    motor, own = draw.sheet.motor, {path[6:]: one for path, one in draw.entries.items() if path.startswith("motor.")}
    if motor and motor.torque_curve:
        speeds, torques = np.transpose(motor.torque_curve)
        turning, end = np.asarray(speed * draw.entries.get("coupling.gear_ratio", 1.0)), speeds[-1]
        turning = np.where(np.isclose(turning, end, rtol=1e-9), end, turning)  # rounding must not pass its end
        own["torque_curve"] = np.interp(turning, speeds, torques, right=0.0)
    found = next(filter(None, ([own[one] for one in name.split() if one in own] for name in names)), [])
    return reduce(np.minimum, found) if found else None


def judged(draw: Draw, speed: Floats, held: Floats) -> dict[str, Judged]:
    """Return the rows of motor and brake at points of the window, of steady running and of rest."""
    entries, found = draw.entries, dict[str, Judged]()
    # In a cycle of moves it is the RMS torque that a motor has to give for ever.
    top, standing = limit(draw, RAMP if draw.sheet.operation.move else RUNNING, speed), limit(draw, STANDING, 0.0)
    if top is not None or entries.keys() & {"coupling.gear_ratio", "motor.gear_efficiency"}:
        found["motor_torque"] = of_motor(draw, speed, held)[1], top
    _, rubs, guide = at_rest(draw)
    start, holding = held + guide, np.clip(-before_gear(draw, -to_hold(draw, held)), 0.0, None)
    if top is not None and draw.sheet.followed and (start > 0).any():
        starting = before_gear(draw, needed(draw, np.clip(start, 0.0, None), rubs, True))
        found["motor_starting_torque"] = np.where(start > 0, starting, np.nan), limit(draw, RAMP, 0.0)
    if standing is not None and (holding > 0).any():
        found["motor_holding_torque"] = holding, standing
    if "brake.torque" in entries:
        found["brake_torque"] = holding, entries["brake.torque"]
    behind = draw.values["screw_inertia"] + draw.values["mass"] * draw.travel**2
    if "motor.inertia" in entries and np.all(behind > 0):
        found["inertia_ratio"] = behind / entries["motor.inertia"] / entries.get("coupling.gear_ratio", 1.0) ** 2, None
    return found


@np.errstate(invalid="ignore")  # where the threads jam
def in_motion(draw: Draw, middle: bool = False) -> dict[str, Judged]:
    """Return the rows of ramps and moves, at both ends of the forces, or in the ``middle`` of them; {} without any."""
    sheet, values, entries, travel, run = draw.sheet, draw.values, draw.entries, draw.travel, draw.run
    if run is None:
        return {}
    loads = np.broadcast_arrays(*(values[f"force_{end}"] + draw.weight for end in ("low", "high")))
    pushed = np.mean(loads, axis=0).reshape(1, -1) if middle else np.reshape(loads, (2, -1))
    move, ratio = sheet.operation.move, entries.get("coupling.gear_ratio", 1.0)
    of_speed, of_most, of_ramp, of_even = nodes(move.profile if move else "trapezoid").reshape(4, -1, 1, 1)
    speeds = of_speed * run.speed / travel
    pairs = [of_motor(draw, speeds, way * pushed, of_most * run.acceleration) for way in sheet.directions]
    sizes = np.stack([size for _, size in pairs])
    powers = np.stack([np.clip(whole, 0.0, None) * ratio * speeds for whole, _ in pairs])
    behind = (values["screw_inertia"] + values["mass"] * travel**2) / ratio
    inertia, found = entries.get("motor.inertia", 0.0) * ratio + behind, dict[str, Judged]()
    if np.any(inertia > 0):  # else nothing is known of what a ramp adds
        found["acceleration_torque"] = inertia * run.acceleration / travel, None
        found["peak_torque"] = sizes, limit(draw, RAMP, speeds)
        found["motor_power"] = powers, None
    if move is None:
        return found
    even, pause = run.time - 2 * run.ramp, entries.get("operation.move.pause", 0.0)
    times = of_ramp * run.ramp + of_even * even
    square, work = (np.where(times > 0, times * one, 0.0).sum(axis=1) for one in (sizes**2, powers))
    if move.back:
        square, work = square.sum(axis=0), work.sum(axis=0)
    hold = np.clip(-before_gear(draw, -to_hold(draw, pushed)), 0.0, None)
    mean = (square + hold**2 * pause) / (run.time * (2 if move.back else 1) + pause)
    found |= {"rms_torque": (np.sqrt(mean), limit(draw, ("rated_torque",), 0.0)), "cycle_energy": (work, None)}
    found |= {"load_speed": (run.speed, None), "screw_speed": (run.speed / travel, None)}
    if move.back and "coupling.stiffness" in entries:
        both = sum(turning(draw, run.speed / travel, way * pushed) for way in (1, -1))
        found["lost_motion"] = np.abs(both) / values["coupling_stiffness"] * travel, None
    return found


def highest_speeds(draw: Draw) -> dict[str, dict[str, float]]:
    """Return by direction the speed up to which the torque curve of the motor moves all loads of the window.

    That of the screw [rad/s] and of the load [m/s], the lowest of all drives; zero where the motor cannot start, the
    end of the curve where it always moves them. Between the speeds that are looked at the torque that is needed is
    straight, as without a law of friction.
    """
    motor, ratio = draw.sheet.motor, draw.entries.get("coupling.gear_ratio", 1.0)
    if motor is None or motor.torque_curve is None:
        return {}
    points = np.array([speed for speed, _ in motor.torque_curve])
    points = np.unique(np.concatenate([points, np.linspace(0.0, points[-1], 65)])).reshape(-1, 1, 1)
    loads = np.broadcast_arrays(*(draw.values[f"force_{end}"] + draw.weight + 0.0 * ratio for end in ("low", "high")))
    pushed, found = np.reshape(loads, (1, 2, -1)), dict[str, dict[str, float]]()
    for way in draw.sheet.directions:
        spare = limit(draw, ("torque_curve",), points / ratio) - of_motor(draw, points / ratio, way * pushed)[1]
        enough, speeds = spare >= 0, points / ratio + 0.0 * pushed
        with np.errstate(divide="ignore", invalid="ignore"):  # where it stays, or the threads jam
            share = np.where(enough[1:], 1.0, spare[:-1] / (spare[:-1] - spare[1:]))
        so_far = np.logical_and.accumulate(enough)[:-1]
        speed = np.where(so_far, speeds[:-1] + share * np.diff(speeds, axis=0), 0.0).max(axis=0)
        ends = {"screw_speed": float(speed.min()), "load_speed": float((speed * draw.travel).min())}
        found["out" if way > 0 else "back"] = ends
    return found
