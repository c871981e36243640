"""A ball that is thrown up bounces infinitely often in a finite time, and then lies still.

The ball of the example "Simulation of a bouncing ball" of Simulink, which stops short of the last bounce: thrown up at
15 m/s from 10 m, with a restitution of 0.8. The times between bounces are a geometric series, whose sum is known.
`python examples/systems/bouncing_ball.py` writes bouncing_ball.png.
"""

from matplotlib import pyplot as plt

from lsvib.systems import System

ball = System(
    states=["x", "v"],
    parameters={"g": "9.81", "k": "0.8"},
    modes={"fly": {"x": "v", "v": "-g"}, "lie": {"x": 0, "v": 0}},
    events=[{"mode": "fly", "when": "x < 0", "reset": {"v": "-k*v"}, "beyond": "lie"}],
)
motion = ball.simulate("fly", {"x": 10, "v": 15}, 25)
*bounces, last = motion.event_time.values
print(f"{len(bounces)} bounces are resolved; all infinitely many are over at {last:.15g} s")

figure, (height, left) = plt.subplots(1, 2, figsize=(7.2, 2.8), layout="constrained")
height.plot(motion.time, motion.x)
height.axvline(last, color="black", linestyle=":", label="all bounces are over")
height.set(xlabel="time [s]", ylabel="height [m]")
height.legend()
left.semilogy(range(1, len(bounces) + 1), last - bounces, ".")
left.set(xlabel="bounce", ylabel="time until all are over [s]")
figure.savefig("bouncing_ball.png", dpi=150)
