r"""The rigid drive in reversed time: where a motion on the boundary of a basin came from.

State (u, v) with v = −w, so that  du/dτ = v  for τ = −t and every oscillator keeps its form with −a₁. Slip can be
followed backwards, and so can the passage from one slip mode to another. Rest and seizure cannot: in them many motions
end in the same state. The one that is followed back here is the one that comes from slip.

Γ₊ > 0: contact reversals and reversals of the screw, each a change of mode at the same state. A motion backwards never
meets rest, because rest is left in a single state.
Γ₊ ≤ 0: slip under law −1 forward that began at θ′ = 0, at u, is traced to the seizure that ended there: to the state of
Q = 0 with the same u. With q_w > 0 that state has θ′ > 0 and ends another forward slip; with q_w ≤ 0 it is not traced.
The trace ends (mode ``beginning``) where no motion arrives: on Q = 0 from the wrong side.
"""

from dataclasses import replace

from flint import arb

from lsvib.drives.automata import automaton_of, modes_of
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.drives.names import Event, MotionMode
from lsvib.systems.automaton import Automaton, Branch, Guard, Mode, Surface, Transition, assemble
from lsvib.systems.exact.arithmetic import Row, many_digits
from lsvib.systems.exact.modal_form import PlanarMode
from lsvib.systems.kernels.layout import Test

BEGINNING = int(MotionMode.REST)  # code of the mode in which a trace ends


def backward_automaton(drive: Drive, touch: arb | None = None) -> Automaton:
    """Return the automaton of a drive in reversed time, Ω > 0.

    ``touch`` [rad], for Γ₊ ≤ 0: the deviation u at which a motion touches Q = 0; slip forward ends on one side of it
    only.
    """
    c, (q_u, q_w, q_0) = coefficients(drive), coefficients(drive).q_row
    with many_digits():
        forward = modes_of(drive.exact(), ())
        backward = q_u, -q_w, q_0
        slips = {key: forward.solution(key).field[1] for key in forward.slips if not c.paradox or key[0] > 0}
    surfaces = {
        "contact": Surface(backward, int(automaton_of(drive).tables.snap[0])),
        "screw_speed": Surface((0, -1, drive.input_speed), 1),
    }
    modes, transitions = {}, _seizures(c.q_row, touch) if c.paradox else {}
    for key, (stiffness, damping, force) in slips.items():
        (d, q, ways), name = key, forward.name(key)
        contact = Guard("contact", q, "nothing" if c.paradox else f"contact_{name}")
        guards = (contact, Guard("screw_speed", d, f"stand_{name}"))
        modes[name] = Mode(MotionMode[name.upper()], PlanarMode.of(1, damping, -stiffness, force), guards)
        if not c.paradox:
            reversal = Branch(forward.name((d, -q, ways)), Event.CONTACT_REVERSAL)
            transitions[f"contact_{name}"] = Transition((reversal,))
            transitions[f"stand_{name}"] = Transition((Branch(forward.name((-d, q, ways)), Event.REVERSAL),))
    if c.paradox:
        # Any motion that grows would do: nothing comes back from there.
        modes["beginning"] = Mode(BEGINNING, PlanarMode.of(1, -1, 1, 0), ())
    return assemble(
        states=("u", "reversed_w"),
        surfaces=surfaces,
        modes=modes,
        transitions=transitions,
        observables={},
        shortest_stay=0.0,
    )


def backward_under_law(drive: Drive) -> Automaton:
    """Return the automaton of a drive under a friction law in reversed time, Ω > 0: the same modes with −x′.

    The state is (u, w). A motion backwards has no branch where it comes to speeds in the Painlevé region, as a seizure
    may lead there from anywhere.
    """
    with many_digits():
        law = modes_of(drive.exact(), drive.parts)
        layout = law.layout()
    modes, transitions = layout["modes"], layout["transitions"]
    for key, transition in transitions.items():
        both_ways = {branch.kind for branch in transition.branches} <= {Event.CONTACT_REVERSAL, Event.PASSAGE}
        goes_on = both_ways and not key.startswith(("faster", "slower"))  # these lead into the band and out of it
        transitions[key] = transition if goes_on else Transition(())
    turned = {law.name((d, q, ())): law.name((-d, q, ())) for d, q, _ in law.slips if not law.paradox}
    for name, mode in modes.items():
        flow, guards = replace(mode.flow, field=-mode.flow.field, push=-mode.flow.push, settled=None), mode.guards
        if other := turned.get(name.removesuffix("_slow")):
            other = f"{other}_slow" if f"{other}_slow" in modes else other
            transitions[f"stand_{name}"] = Transition((Branch(other, Event.REVERSAL),))
            guards = tuple(replace(g, transition=f"stand_{name}") if g.surface == "slip_speed" else g for g in guards)
        modes[name] = replace(mode, flow=flow, guards=guards)
    return assemble(**layout)


def _seizures(q_row: Row, touch: arb | None) -> dict[str, Transition]:
    """Transitions for Γ₊ ≤ 0: from θ′ = 0 to the state of Q = 0 in which the seizure began."""
    (q_u, q_w, q_0), forward = q_row, MotionMode.SLIP_FORWARD_NEGATIVE.name.lower()
    nothing = Branch("beginning", Event.SEIZURE)
    if q_w <= 0:
        return dict.fromkeys(("nothing", f"stand_{forward}"), Transition((nothing,)))
    with many_digits():
        reset = ((1, 0, 0), (q_u / q_w, 0, q_0 / q_w))
        # Q = 0 is arrived at from inside beyond the point of touching only.
        ended = Branch(forward, Event.SEIZURE, (((-q_w, 0, q_w * touch), Test.POSITIVE),))
    return {"nothing": Transition((nothing,)), f"stand_{forward}": Transition((ended, nothing), reset=reset)}
