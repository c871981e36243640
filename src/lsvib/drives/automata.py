"""The automaton of a drive: its mechanism, the modes that this has, and the tables that these make.

Tables are made once for each drive and shared by all that are equal: do not change them.
"""

from typing import Any

from flint import arb

from lsvib.drives import friction
from lsvib.drives.command import Command, one_after_the_other
from lsvib.drives.drive import Drive, once
from lsvib.drives.law_modes import LawModes
from lsvib.drives.mechanics import coefficients
from lsvib.drives.mechanism import Mechanism
from lsvib.drives.modes import Modes
from lsvib.drives.names import Resume
from lsvib.errors import InputError
from lsvib.systems.automaton import Automaton, assemble
from lsvib.systems.exact.arithmetic import many_digits


def automaton_of(
    drive: Drive, resume: Resume = "contact_sign", command: Command | None = None, rest: bool = True
) -> Automaton:
    """Return the automaton of a drive, also under a command; without ``rest`` that of slip as the motor turns alone.

    Raises ``InputError`` for a rule of resuming that is known of the rigid drive only, where rest cannot be left out,
    or a dry friction leaves the motion undetermined; ``EngineError`` if the rates of a mode cannot be separated in
    double precision.
    """
    if resume != "contact_sign" and not drive.rigid:
        raise InputError(f"resume = {resume!r} is known of the rigid drive only; others know contact_sign.")
    evenly = drive.rigid and drive.input_speed and not (command or friction.depends_on_speed(drive))
    if not rest and not (evenly and not coefficients(drive).paradox):
        raise InputError(
            "physics leaves out rest, which only a rigid drive below its critical mass may do, if its motor turns "
            "evenly and friction does not depend on the speed; list rest."
        )
    return _under_command(drive, command, resume) if command else _at_one_speed(drive, resume, rest)


@once
def _at_one_speed(drive: Drive, resume: Resume, rest: bool) -> Automaton:
    with many_digits():
        modes = modes_of(drive.exact(), drive.parts, resume)
        return modes.automaton() if rest else modes.without_rest()


@once
def _under_command(drive: Drive, command: Command, resume: Resume) -> Automaton:
    """Modes of its own for each piece of the command.

    The clock, the last state, begins anew in each piece, so that no digits of Ω(t) are lost late.
    """
    with many_digits():
        d = drive.exact()
        pieces = [(modes_of(d, drive.parts, resume, (arb(s), arb(a))), x) for x, s, a in command.pieces()]
        return assemble(**one_after_the_other([(modes.layout(), duration) for modes, duration in pieces]))


def modes_of(
    d: Any, parts: tuple[str, ...], resume: Resume = "contact_sign", command: tuple[arb, arb] | None = None
) -> Modes:
    """Return the modes of a drive from its parameters as balls, or of many from arrays; see ``Mechanism``."""
    if not friction.depends_on_speed(d):
        return Modes(Mechanism(d, parts, d.steady_friction, command), resume)
    return LawModes(Mechanism(d, parts, friction.coefficient(d, 0 * d.pitch_radius), command), resume)
