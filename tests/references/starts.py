"""Starts and stops of a screw that is known, step by step, and what a recorder shows of them."""

import math

import numpy as np

FINE, STEP = 160, 0.04  # steps of the integrator a sample; seconds a sample


def commanded(rate, top, senses=(1,), rest=0.9, even=4.0, tail=0.7, down=True, **_):
    """The commanded speed: for each sense rest, a ramp up, even turning and a ramp down; then rest. Each fine step."""
    dt, parts = STEP / FINE, []
    for sense in senses:
        up = np.arange(0, top, rate * dt)
        parts += [np.zeros(int(rest / dt)), sense * up, np.full(int(even / dt), sense * top), sense * up[::-1] * down][
            : 3 + down
        ]
    return np.concatenate([*parts, np.zeros(int(tail / dt))])


def motion(
    command, inertia, kinetic, static, gain, lag, *, load=0.0, drag=0.0, rise=0.0, fades=1.0, swing=0.0, most=1e9
):
    """Speed and torque of J dω/dt = T − friction − load, T of a PI controller up to ``most``, at each fine step.

    ``gain`` [N m s/rad] of the speed's error, summed up over ``lag`` [s]. A screw at rest breaks loose at ``static``;
    friction that turns falls from kinetic (1 + rise) over the speed ``fades`` and swings in a turn.
    """
    dt, speed, angle, total, rows, loose = STEP / FINE, 0.0, 0.0, 0.0, [], []
    for wanted in command.tolist():
        total += gain / lag * (wanted - speed) * dt
        total = min(max(total, -most), most)
        torque = min(max(gain * (wanted - speed) + total, -most), most)
        net = torque - load
        if speed == 0 and abs(net) <= static:
            rows.append((0.0, torque))
            continue
        if speed == 0:
            loose.append(torque)
        sense = math.copysign(1.0, speed or net)
        rubs = kinetic * (1 + rise * math.exp(-abs(speed) / fades)) * (1 + swing * math.sin(angle))
        after = speed + dt / inertia * (net - sense * rubs - drag * speed)
        speed = 0.0 if after * sense < 0 else after
        angle += speed * dt
        rows.append((speed, torque))
    return np.array(rows).T, loose


def recorded(rows, random, window, noise, quanta):
    """What a recorder shows of speed and torque: means over a window, each STEP, with noise and rounded."""
    size = max(1, round(window * FINE))
    ends = np.arange(FINE + random.integers(FINE), rows.shape[1], FINE)
    sums = np.cumsum(np.pad(rows, ((0, 0), (1, 0))), axis=1)
    means = (sums[:, ends] - sums[:, ends - size]) / size
    return (
        np.round((x + n * random.standard_normal(x.size)) / q) * q for x, n, q in zip(means, noise, quanta, strict=True)
    )
