"""Two systems of one's own by lsvib and by what else follows events, in one run: error beside time and lines of code.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.own_systems

An impact oscillator and a relay with a plant of third order. Each method is written as its manual says, as a function
that sets up all that it can and returns what is timed; its lines are counted. Times are processor times: of the set-up
with a first run, which may compile, and the best of five more. Threads of OpenBLAS that wait for each other would count
against malbrid, up to thirty times. The truth is a march in 50 digits. What is not installed is left out, and the run
says so.
"""

import inspect
import time
from collections.abc import Callable

import numpy as np
from flint import arb, arb_mat, ctx

END = 1000.0  # s
Run = Callable[[], np.ndarray]  # the state at the end


def impact_lsvib() -> Run:
    from lsvib.systems import System

    impact = System(
        states=["x", "v"],
        harmonics={"c, s": 1},
        modes={"fly": {"x": "v", "v": "-x - 0.1*v + c"}},
        events=[{"mode": "fly", "when": "x > 1", "reset": {"v": "-0.8*v"}}],
    )
    return lambda: impact.simulate("fly", {"x": 0.1}, END, samples=2)[["x", "v"]].isel(time=-1).to_array().values


def relay_lsvib() -> Run:
    from lsvib.systems import System

    plant = {"x": "y", "y": "z"}
    relay = System(
        states=["x", "y", "z"],
        modes={"low": plant | {"z": "-3*y - 2*z + 1"}, "high": plant | {"z": "-3*y - 2*z - 1"}},
        surfaces=[{"between": ["low", "high"], "at": "x"}],
    )
    return lambda: relay.simulate("high", {"x": 1}, END, samples=2)[["x", "y", "z"]].isel(time=-1).to_array().values


def impact_scipy() -> Run:
    from scipy.integrate import solve_ivp

    def field(t, y):
        return y[1], -y[0] - 0.1 * y[1] + np.cos(t)

    def stop(t, y):
        return y[0] - 1

    stop.terminal, stop.direction = True, 1

    def run():
        t, y = 0.0, [0.1, 0.0]
        while t < END:
            found = solve_ivp(field, (t, END), y, "DOP853", events=stop, rtol=1e-12, atol=1e-13)
            t, y = found.t[-1], found.y[:, -1]
            if found.status == 1:
                y = [1.0, -0.8 * y[1]]
        return y

    return run


def relay_scipy() -> Run:
    from scipy.integrate import solve_ivp

    def field(t, y, u):
        return y[1], y[2], -3 * y[1] - 2 * y[2] - u

    def switch(t, y, u):
        return u * y[0]

    switch.terminal, switch.direction = True, -1

    def run():
        t, y, u = 0.0, [1.0, 0.0, 0.0], 1
        while t < END:
            found = solve_ivp(field, (t, END), y, "DOP853", events=switch, args=(u,), rtol=1e-12, atol=1e-13)
            t, y, u = found.t[-1], found.y[:, -1], -u
            if found.status == 1:
                y[0] = 0.0
        return y

    return run


def impact_heyoka() -> Run:
    import heyoka as hy

    def strike(solver, sign):
        solver.state[:] = 1.0, -0.8 * solver.state[1]
        return True

    x, v = hy.make_vars("x", "v")
    stop = hy.t_event(x - 1, callback=strike, direction=hy.event_direction.positive)
    solver = hy.taylor_adaptive([(x, v), (v, -x - 0.1 * v + hy.cos(hy.time))], [0.1, 0.0], t_events=[stop])

    def run():
        solver.time, solver.state[:] = 0.0, (0.1, 0.0)
        solver.reset_cooldowns()
        solver.propagate_until(END)
        return solver.state

    return run


def relay_heyoka() -> Run:
    import heyoka as hy

    def flip(solver, sign):
        solver.state[0], solver.pars[0] = 0.0, -solver.pars[0]
        return True

    x, y, z = hy.make_vars("x", "y", "z")
    field = [(x, y), (y, z), (z, -3 * y - 2 * z - hy.par[0])]
    solver = hy.taylor_adaptive(field, [1.0, 0.0, 0.0], pars=[1.0], t_events=[hy.t_event(x, callback=flip)])

    def run():
        solver.time, solver.pars[0], solver.state[:] = 0.0, 1.0, (1.0, 0.0, 0.0)
        solver.reset_cooldowns()
        solver.propagate_until(END)
        return solver.state

    return run


def impact_diffrax() -> Run:
    import diffrax as dfx
    import jax
    import optimistix as optx

    jax.config.update("jax_enable_x64", True)
    term = dfx.ODETerm(lambda t, y, args: jax.numpy.array([y[1], -y[0] - 0.1 * y[1] + jax.numpy.cos(t)]))
    root, steps = optx.Newton(1e-13, 1e-13), dfx.PIDController(rtol=1e-12, atol=1e-13)
    stop = dfx.Event(lambda t, y, args, **more: y[0] - 1, root, direction=True)

    @jax.jit
    def arc(t, y):
        found = dfx.diffeqsolve(term, dfx.Dopri8(), t, END, None, y, stepsize_controller=steps, event=stop)
        return found.ts[-1], found.ys[-1]

    def run():
        t, y = arc(0.0, np.array([0.1, 0.0]))
        while t < END:
            t, y = arc(t, np.array([1.0, -0.8 * y[1]]))
        return y

    return run


def relay_diffrax() -> Run:
    import diffrax as dfx
    import jax
    import optimistix as optx

    jax.config.update("jax_enable_x64", True)
    term = dfx.ODETerm(lambda t, y, u: jax.numpy.array([y[1], y[2], -3 * y[1] - 2 * y[2] - u]))
    root, steps = optx.Newton(1e-13, 1e-13), dfx.PIDController(rtol=1e-12, atol=1e-13)
    switch = dfx.Event(lambda t, y, args, **more: args * y[0], root, direction=False)

    @jax.jit
    def arc(t, y, u):
        found = dfx.diffeqsolve(term, dfx.Dopri8(), t, END, None, y, u, stepsize_controller=steps, event=switch)
        return found.ts[-1], found.ys[-1]

    def run():
        u = 1.0
        t, y = arc(0.0, np.array([1.0, 0.0, 0.0]), u)
        while t < END:
            u = -u
            t, y = arc(t, np.array([0.0, y[1], y[2]]), u)
        return y

    return run


def impact_malbrid() -> Run:
    from malbrid import LinearSystemSimulator
    from scipy.linalg import expm

    rows = np.zeros((5, 5))  # x, v, cos t, sin t, 1
    rows[0, 1], rows[1, :3], rows[2, 3], rows[3, 2] = 1, (-1, -0.1, 1), -1, 1
    solver = LinearSystemSimulator(["x", "v", "c", "s", "one"])
    stop = (solver.get_var("x") >= 1) & (solver.get_var("v") >= 0)

    def mode(name):
        return rows, [(stop, "strike", lambda y: ("fly", np.array([1.0, -0.8 * y[1], *y[2:]]), False))]

    def run():
        solver.simulate(mode, "fly", np.array([0.1, 0.0, 1.0, 0.0, 1.0]), max_time=END)
        t, y = solver.time_points[-1], solver.continuous_states[-1]  # beyond the end
        return (expm((END - t) * rows) @ y)[:2]

    return run


def relay_malbrid() -> Run:
    from malbrid import LinearSystemSimulator
    from scipy.linalg import expm

    solver = LinearSystemSimulator(["x", "y", "z", "one"])
    x, y = solver.get_var("x"), solver.get_var("y")

    def mode(u):
        rows = np.zeros((4, 4))
        rows[0, 1], rows[1, 2], rows[2] = 1, 1, (0, -3, -2, -u)
        due = (x <= 0) & (y <= 0) if u > 0 else (x >= 0) & (y >= 0)
        return rows, [(due, "switch", lambda place: (-u, place, False))]

    def run():
        solver.simulate(mode, 1, np.array([1.0, 0.0, 0.0, 1.0]), max_time=END)
        t, place, u = solver.time_points[-1], solver.continuous_states[-1], solver.discrete_states[-1]
        return (expm((END - t) * mode(u)[0]) @ place)[:3]

    return run


def truth(rows: dict[int, list[list]], start: list, strike: Callable[[int, list], tuple[int, list]]) -> np.ndarray:
    """Return the state at the end, in many digits: steps of 1/128 s in a mode, in which x falls or rises through zero.

    ``rows``: A of z′ = A z by mode, +1 where x is positive, −1 where it is negative; ``strike``: what happens then.
    """
    mode, place, left = 1, arb_mat([[x] for x in start]), arb(END)
    step = {sign: (arb_mat(own) * (arb(1) / 128)).exp() for sign, own in rows.items()}
    while left > 0:
        ahead = step[mode] * place
        if left * 128 < 1:
            return np.array([float(x) for x in ((arb_mat(rows[mode]) * left).exp() * place).entries()])
        if (mode * ahead[0, 0]).mid() > 0:
            place, left = ahead, (left - arb(1) / 128).mid()
            continue
        low, high = arb(0), arb(1) / 128
        for _ in range(150):
            middle = ((low + high) / 2).mid()
            beyond = (mode * ((arb_mat(rows[mode]) * middle).exp() * place)[0, 0]).mid() <= 0
            low, high = (low, middle) if beyond else (middle, high)
        place, left = (arb_mat(rows[mode]) * high).exp() * place, (left - high).mid()
        mode, entries = strike(mode, [x.mid() for x in place.entries()])
        place = arb_mat([[x] for x in entries])
    return np.array([float(x) for x in place.entries()])


def true_states() -> dict[str, np.ndarray]:
    """Return the states of both systems at the end."""
    with ctx.workdps(50):
        tenth = arb(1) / 10
        rows = [[0, -1, 0, 0, 0], [1, -tenth, 1, 0, -1], [0, 0, 0, -1, 0], [0, 0, 1, 0, 0], [0] * 5]
        begin = [1 - tenth, 0, 1, 0, 1]  # 1 − x, v, cos t, sin t, 1
        gap, speed, *_ = truth({1: rows}, begin, lambda sign, z: (sign, [0, -8 * tenth * z[1], *z[2:]]))
        plant = {sign: [[0, 1, 0, 0], [0, 0, 1, 0], [0, -3, -2, -sign], [0] * 4] for sign in (1, -1)}
        relay = truth(plant, [1, 0, 0, 1], lambda sign, z: (-sign, [0, *z[1:]]))
    return {"impact": np.array([1 - gap, speed]), "relay": relay[:3]}


def timed(setup: Callable[[], Run]) -> tuple[float, float, np.ndarray]:
    """Return the times [s] of set-up with a first run and of the fastest of five more, and the state at the end."""
    begun = time.process_time()
    run = setup()
    state = run()
    first, again = time.process_time() - begun, np.inf
    if first > 20:
        return first, first, np.asarray(state)
    for _ in range(5):
        begun = time.process_time()
        state = run()
        again = min(again, time.process_time() - begun)
    return first, again, np.asarray(state)


def main() -> None:
    """Print the table."""
    vars(np)["NINF"] = -np.inf  # malbrid 0.0.11 takes it from numpy, which has it no more
    print("| system | method | lines | first run, s | again, ms | error |\n|---|---|---|---|---|---|")
    for system, true in true_states().items():
        for method in ("lsvib", "heyoka", "diffrax", "scipy", "malbrid"):
            setup = globals()[f"{system}_{method}"]
            lines = sum(bool(line.strip()) for line in inspect.getsource(setup).splitlines())
            try:
                first, again, state = timed(setup)
            except ImportError as missing:
                print(f"| {system} | {method} | {lines} | {missing} | | |")
                continue
            error = np.abs(state - true).max() / np.abs(true).max()
            print(f"| {system} | {method} | {lines} | {first:.2f} | {1e3 * again:.2g} | {error:.0e} |", flush=True)


if __name__ == "__main__":
    main()
