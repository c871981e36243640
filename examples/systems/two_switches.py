"""Two switches that would chatter without end: the motion slides between them instead.

x' = ∓2 and y' = −3 or 1.5, by the sign of x − y; event-driven solvers get stuck (OpenModelica, issue 12190).
The convex combination of both that stays on x = y (Filippov, *Differential Equations with Discontinuous Righthand
Sides*, 1988) is x' = y' = −6/17. `python examples/systems/two_switches.py` writes two_switches.png.
"""

from matplotlib import pyplot as plt

from lsvib.systems import System

switches = System(
    states=["x", "y"],
    modes={"below": {"x": 2, "y": -3}, "above": {"x": -2, "y": 1.5}},
    surfaces=[{"between": ["below", "above"], "at": "x - y"}],  # below where x - y < 0
)
motion = switches.simulate("above", {"x": 1.5, "y": 1}, 1)
end = motion.isel(time=-1)
print(f"slides from {motion.event_time.item():.15g} s on; x(1 s) = {end.x.item():.15g}, y(1 s) = {end.y.item():.15g}")

figure, (states, plane) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
states.plot(motion.time, motion.x, label="$x$")
states.plot(motion.time, motion.y, "--", label="$y$")
states.axvline(motion.event_time.item(), color="black", linestyle=":", label="slides from here on")
states.set(xlabel="time [s]")
states.legend()
for start in ({"x": 1.5, "y": 1}, {"x": 1.6, "y": 1.4}, {"x": 1, "y": 1.6}, {"x": 0.9, "y": 1.1}):
    motion = switches.simulate("above", start, 1)
    plane.plot(motion.x, motion.y)
    plane.plot(motion.x[0], motion.y[0], "o", color="C7")
plane.axline((1, 1), slope=1, color="black", linestyle=":", label="$x = y$")
plane.set(xlabel="$x$", ylabel="$y$", aspect="equal")
plane.legend()
figure.savefig("two_switches.png", dpi=150)
