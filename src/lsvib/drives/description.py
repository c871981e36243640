"""A drive in words and numbers: its parts, coordinates, equations of motion and modes."""

from dataclasses import asdict, dataclass
from typing import Any

from flint import arb

from lsvib.drives import friction
from lsvib.drives.drive import IN_WORDS, PARTS, Drive
from lsvib.drives.mechanism import Mechanism
from lsvib.drives.model import model_of, seated
from lsvib.drives.names import BODIES, WORDS
from lsvib.systems.exact.arithmetic import many_digits

_OWN = {
    "u": ("deviation u of the coupling deflection z = θ − Ω t from steady sliding", "rad"),
    "w": ("rate w of that deviation; the screw turns at θ′ = Ω + w", "rad s-1"),
}


@dataclass(frozen=True)
class Description:
    """What a drive consists of.

    ``parts`` in words; ``coordinates``: long name and unit of each coordinate of the state, by name; ``steady``: z
    [rad], n [N], τ [N m] and the coordinates of parts in steady sliding; ``equations`` of motion with numbers in SI
    units (:mod:`lsvib.drives.mechanism`); ``modes`` by name.

    >>> description_of(Drive(mass=11)).equations[-1]
    'Γ₊ = -2.75678e-07 kg m²: the threads can seize'
    """

    parts: tuple[str, ...]
    coordinates: dict[str, tuple[str, str]]
    steady: dict[str, float]
    equations: tuple[str, ...]
    modes: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """Return it as plain numbers and names."""
        coordinates = {key: {"long_name": words, "unit": unit} for key, (words, unit) in self.coordinates.items()}
        return asdict(self) | {"coordinates": coordinates}


def description_of(drive: Drive) -> Description:
    """Return what a drive consists of."""
    model, d = model_of(drive), drive.exact()
    with many_digits():
        mechanism = Mechanism(d, drive.parts, friction.coefficient(d, arb(0)))
        steady = {"coupling_deflection": float(mechanism.deflection[-1])}
        steady |= {"axial_contact_force": float(mechanism.force), "thread_torque": float(mechanism.twist)}
        if "support" in drive.parts:
            steady["screw_shift"] = float(mechanism.force / d.support_stiffness)
        if "nut" in drive.parts:
            steady["nut_angle"] = float(mechanism.twist / d.nut_stiffness)
        if mechanism.compliant:
            steady["thread_mismatch"] = float(seated(mechanism)[mechanism.place["threads"]])
        equations = (*_bodies(drive, float(mechanism.reach)), *_threads(drive, mechanism))
    return Description(
        parts=tuple(IN_WORDS[part] for part in drive.parts),
        coordinates={name: _OWN.get(name) or WORDS[name][:2] for name in model.states},
        steady=steady,
        equations=equations,
        modes=tuple(mode.name.lower() for mode in model.modes),
    )


def _bodies(drive: Drive, reach: float) -> list[str]:
    d, turns, shifts = drive, "nut" in drive.parts, "support" in drive.parts
    screw = [("−", d.coupling_stiffness, "z"), ("−", d.coupling_damping, "z′"), ("−", d.support_damping, "θ′")]
    screw.append(("−", d.bearing_friction, "sgn θ′"))
    load = [("−", d.translation_damping, "x′"), ("−", d.slide_friction, "sgn x′")]
    lines = []
    for part in drive.parts:
        if body := BODIES.get(part):
            inertia, stiffness, damping = (getattr(d, name) for name in PARTS[part])
            of, rate, coupling = body.symbol, f"{body.symbol}′", []
            if body.on == "command":
                of, rate = f"({of} − {d.input_speed:.6g} t)", f"({rate} − {d.input_speed:.6g})"
                coupling = [("+", d.coupling_stiffness, "z"), ("+", d.coupling_damping, "z′")]
            elif body.on:
                of, rate = f"({of} − θ)", f"({rate} − θ′)"
                screw += [("+", stiffness, of), ("+", damping, rate)]
            pushed = {"contact": "n ", "torque": "τ "}.get(body.pushed, "")
            springs = _sum([("−", stiffness, of), ("−", damping, rate), *coupling])
            lines.append(f"{inertia:.6g} {body.symbol}″ = {pushed}{springs}")
    lines.insert(0, f"{d.screw_inertia:.6g} θ″ = {_sum(screw)} − τ")
    right = _sum([("", d.axial_force, ""), *load])
    lines.append(f"{d.mass:.6g} x″ = {right + ' ' if right else ''}− n")
    angle = "(θ − θ_2)" if turns else "θ"
    lines.append(f"x = {reach:.6g} {angle}{' + x_1' if shifts else ''}{' + e' if 'threads' in d.parts else ''}")
    turned = f" − {d.input_speed:.6g} t" if d.input_speed else ""
    return [*lines, "z = θ − θ_m" if "motor" in d.parts else f"z = θ{turned}"]


def _sum(terms: list[tuple[str, float, str]]) -> str:
    """Terms, each a sign, a number and what it multiplies; those that are zero are left out."""
    return " ".join(f"{sign} {value:.6g} {name}".strip() for sign, value, name in terms if value)


def _threads(drive: Drive, mechanism: Mechanism) -> list[str]:
    slip = "θ′ − θ_2′" if "nut" in drive.parts else "θ′"
    levers = [float(mechanism.lever(law, mechanism.slowest)) for law in (1, -1)]
    lines = [
        f"slip: τ = {levers[0]:.6g} n where n ({slip}) > 0, τ = {levers[1]:.6g} n where it is < 0",
        f"rest: {slip} = 0 while static friction holds, μ = {float(mechanism.d.static_friction):.6g}",
    ]
    of = {"slide": ("x′ = 0", "N"), "bearing": ("θ′ = 0", "N m")}
    for name, holding in mechanism.holding.items():
        (speed, unit), most = of[name], f"{float(holding):.6g}"
        if name in mechanism.own:
            lines.append(f"held: {speed} while friction of the {name} holds, up to {most} {unit}")
        else:
            lines.append(f"rest: the {name} holds up to {most} {unit}, and breaks loose together with the threads")
    if friction.depends_on_speed(drive):
        lines[0] += ", at slow sliding"
    if mechanism.compliant:
        d = mechanism.d
        stiffness, damping = float(d.cos_lead * d.contact_stiffness), float(d.cos_lead * d.contact_damping)
        contact = _sum([("", stiffness, "e"), ("+", damping, "e′")])
        lines.append(f"N = {contact}, and n is the axial force of N and its friction")
    else:
        inertia, mass = mechanism.effective()
        gamma = float(inertia - mechanism.turned * mass)
        where = " in steady sliding" if friction.depends_on_speed(drive) else ""
        lines.append(f"Γ₊ = {gamma:.6g} kg m²{where}{'' if gamma > 0 else ': the threads can seize'}")
    return lines
