"""Random systems that are linear between events, and motions of them by Taylor sums on short steps and bisection.

Nothing is shared with the engine: matrices are drawn here, and what the package reads are texts made from them. Guards
are looked at after each step, of 10 μs after an event and soon of 10 ms, so that two events within one may be missed.
"""

from dataclasses import dataclass, field

import numpy as np

STEP, TERMS = 0.01, 20  # rates are below 10 1/s, so that terms left out are below 1e-30
NEAR = 1e-9  # a guard that is nearer to zero has just fired


@dataclass
class Hybrid:
    """Matrices (n, n + 3) over states, cos ω t, sin ω t, 1; events (modes, row, reset, to); surfaces (a, b, row)."""

    fields: list[np.ndarray]
    rate: float  # ω [rad/s], zero without forcing
    events: list[tuple] = field(default_factory=list)
    surfaces: list[tuple] = field(default_factory=list)

    @property
    def n(self) -> int:
        return len(self.fields[0])

    def keys(self) -> dict:
        """Return the keys of the package's system."""
        names = [f"x{i}" for i in range(self.n)]

        def text(row):
            terms = [*names, *(("c", "s") if self.rate else ("0", "0")), "1"]
            return " + ".join(f"({float(x)!r})*{y}" for x, y in zip(row, terms, strict=True) if x and y != "0") or "0"

        modes = {f"m{k}": dict(zip(names, map(text, own), strict=True)) for k, own in enumerate(self.fields)}
        events = []
        for modes_, row, reset, to in self.events:
            own = {"mode": [f"m{k}" for k in modes_], "when": f"{text(row)} > 0"}
            own |= {"reset": dict(zip(names, map(text, reset), strict=True))} if reset is not None else {}
            events.append(own | ({} if to is None else {"to": f"m{to}"}))
        surfaces = [{"between": [f"m{a}", f"m{b}"], "at": text(row)} for a, b, row in self.surfaces]
        harmonics = {"c, s": self.rate} if self.rate else {}
        return dict(states=names, modes=modes, harmonics=harmonics, events=events, surfaces=surfaces)

    def _rows(self, mode):
        """Field of a mode on (x, c, s, 1); a mode (a, b) slides between two."""
        turning = [[0, 0, -self.rate, 0], [0, 0, self.rate, 0], [0, 0, 0, 0]]
        turning = np.array([[*np.zeros(self.n), *row[1:]] for row in turning])
        turning[1, [self.n, self.n + 1]] = self.rate, 0.0
        if isinstance(mode, int):
            return np.vstack([self.fields[mode], turning])
        a, b = mode
        first, second = self._rows(a), self._rows(b)
        row = next(row for x, y, row in self.surfaces if (x, y) == mode)
        low, high = row @ first, row @ second
        # (1 − α) f₁ + α f₂ with α = r₁ / (r₁ − r₂), whose denominator is the same on all of the surface
        point = np.zeros(self.n + 3)
        point[-1] = 1.0
        normal = row[: self.n]
        point[: self.n] = -normal * row[-1] / (normal @ normal)
        gap = float((low - high) @ point)
        jump = ((second - first) @ point)[:, None]
        return first + jump * (low / gap)[None, :]

    def _guards(self, mode):
        """Rows that are negative in a mode, each with what happens when it is not."""
        both = {mode} if isinstance(mode, int) else {*mode}
        guards = [(row, (reset, mode if to is None else to)) for own, row, reset, to in self.events if both <= {*own}]
        for a, b, row in self.surfaces:
            low, high = row @ self._rows(a), row @ self._rows(b)
            if mode == a:
                guards.append((row, lambda z, a=a, b=b, r=high, s=row: (a, b) if r @ z <= 0 and s @ z <= NEAR else b))
            elif mode == b:
                guards.append((-row, lambda z, a=a, b=b, r=low, s=row: (a, b) if r @ z >= 0 and s @ z >= -NEAR else a))
            elif mode == (a, b):
                guards += [(-low, lambda z, a=a: a), (high, lambda z, b=b: b)]
        return guards

    def motion(self, mode, start, end, most=60):
        """Return times, states after, and modes after of the events of a motion, and the state at its end."""
        t, x, found = 0.0, np.array(start, dtype=float), []
        while t < end and len(found) < most:
            z = np.array([*x, np.cos(self.rate * t), np.sin(self.rate * t), 1.0])
            rows, guards = self._rows(mode), self._guards(mode)
            table = np.array([row for row, _ in guards]).reshape(-1, z.size)
            values, rates = table @ z, table @ (rows @ z)
            fired = np.flatnonzero((values > NEAR) | ((np.abs(values) <= NEAR) & (rates > NEAR)))
            if not fired.size:
                armed, longest = values < -NEAR, 1e-5
                while t < end and not fired.size:
                    series = [z]
                    for k in range(1, TERMS):
                        series.append(rows @ series[-1] / k)
                    series = np.array(series[::-1])
                    step = min(longest, end - t)
                    ahead = np.array([np.polyval(series[:, i], step) for i in range(z.size)])
                    crossed = armed & (table @ ahead > 0)
                    if crossed.any():
                        roots = np.array(
                            [
                                _root(series @ row, step) if on else np.inf
                                for row, on in zip(table, crossed, strict=True)
                            ]
                        )
                        fired, step = np.array([np.argmin(roots)]), roots.min()
                        ahead = np.array([np.polyval(series[:, i], step) for i in range(z.size)])
                    armed |= table @ ahead < -NEAR
                    t, z, longest = t + step, ahead, min(2 * longest, STEP)
            if not fired.size:
                return found, z[: self.n]
            what = guards[fired[0]][1]
            if callable(what):
                mode = what(z)
            else:
                reset, mode = what
                z[: self.n] = z[: self.n] if reset is None else reset @ z
            x = z[: self.n]
            found.append((t, x.copy(), mode))
        return found, x


def _root(form, high):
    low = 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if np.polyval(form, middle) > 0 else (middle, high)
    return high


def drawn(seed):
    """Return a random system with a start: 2 to 5 states, 2 to 4 modes, resets, forcing, sliding."""
    chance = np.random.default_rng([72, seed])
    n, modes = int(chance.integers(2, 6)), int(chance.integers(2, 5))
    rate = float(chance.uniform(0.5, 3.0)) if chance.random() < 0.5 else 0.0
    width, chain = n + 3, chance.random() < 0.2  # rates that coincide

    def one_field():
        own = np.zeros((n, width))
        matrix = np.eye(n, k=1) - np.eye(n) if chain else chance.normal(size=(n, n))
        own[:, :n] = matrix - max(0.0, np.linalg.eigvals(matrix).real.max() - 0.2) * np.eye(n)
        own[:, -1] = chance.normal(size=n)
        if rate:
            own[:, n : n + 2] = chance.normal(size=(n, 2))
        return own

    def one_row(distance):
        row = np.zeros(width)
        row[:n], row[-1] = chance.normal(size=n), -distance
        row[:n] /= np.linalg.norm(row[:n])
        return row

    fields = [one_field() for _ in range(modes)]
    system, start = Hybrid(fields, rate), 0.3 * chance.normal(size=n)
    slides = chance.random() < 0.6
    if slides:
        normal = one_row(float(chance.uniform(-0.2, 0.2)))
        jump = chance.normal(size=n)
        jump *= -chance.uniform(0.5, 3.0) * np.sign(jump @ normal[:n])
        fields[1] = fields[0] + np.outer(chance.normal(size=n), normal)
        fields[1][:, -1] += jump
        system.surfaces.append((0, 1, normal))
    for k in range(modes):
        reset = None
        if chance.random() < 0.6:
            reset = np.eye(n, width) * chance.uniform(0.3, 0.9) * chance.choice([-1, 1], size=n)[:, None]
            reset[:, -1] = 0.2 * chance.normal(size=n)
        own = ((0, 1) if k == 0 else ()) if slides and k < 2 else (k,)
        to = (k + 1) % modes if not (slides and k == 0) else 2 % modes
        if own and not (slides and modes == 2):
            system.events.append((own, one_row(float(chance.uniform(0.2, 0.7))), reset, to))
    return system, start
