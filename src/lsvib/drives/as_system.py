"""A drive with constant friction in words: the keys of a :class:`lsvib.systems.System`, by the chapter's symbols."""

from itertools import product
from typing import Any

from lsvib.drives.drive import DRY, IN_WORDS, Drive, described
from lsvib.drives.friction import OF_SPEED
from lsvib.drives.names import DIRECTIONS, SIGNS
from lsvib.errors import InputError

_Q = "I*R + r_m*t*(m*k*z + (m*c - I*c_x)*(Omega + w))"  # has the sign of N of rigid threads (8.17)
_PRESSED = "(k_c*e + c_c*v)"  # N / cos λ of compliant ones


def keys_of(drive: Drive) -> dict[str, Any]:
    """Return the keys of the system that a drive is; raises ``InputError`` for one of which none is made."""
    threads, given = "threads" in drive.parts, drive.__dict__
    if other := [IN_WORDS[x] for x in drive.parts if x != "threads"] + [x for x in (*OF_SPEED, *DRY) if given[x]]:
        raise InputError(f"the drive has {other[0]}; only rigid or compliant threads with one friction make a system.")
    known = {"mu_s": "mu"} | {described(key)["symbol"]: value for key, value in drive if key != "lead_angle"}
    known |= {"lead": drive.lead_angle, "t": "tan(lead)"}
    for s, law in (("plus", ""), ("minus", "-")):
        known |= {f"{x}_{s}": f"({law}{mu} - t)/(1 + {law}{mu}*t)" for x, mu in (("xi", "mu"), ("hold", "mu_s"))}
        if threads:
            known[f"b_{s}"] = f"cos(lead)*(cos(lead) + {law}mu*sin(lead))"
        else:
            known |= {f"Gamma_{s}": f"I - xi_{s}*t*m*r_m**2", f"C_{s}": f"c - xi_{s}*t*c_x*r_m**2"}
    known |= {} if threads else {"real_below_critical_mass": "sqrt(Gamma_plus)"}  # above it the drive seizes: refused
    modes, rests, events = {}, {}, []
    for (way, direction), (q, side) in product(DIRECTIONS.items(), SIGNS.items()):
        here, rest = f"slip_{direction}_{side}", f"rest_{side}" if threads else "rest"
        s = "plus" if way == q else "minus"
        if threads:
            turns = f"(-k*z - c*(Omega + w) - r_m*xi_{s}*b_{s}*{_PRESSED})/I"
            moves = f"(R - c_x*(r_m*t*(Omega + w) + v) - b_{s}*{_PRESSED})/m - r_m*t*{turns}"
            modes[here] = {"z": "w", "w": turns, "e": "v", "v": moves}
            rests[rest] = {"z": "w", "w": 0, "e": "v", "v": f"(R - c_x*v - {_PRESSED} + t*k*z/r_m)/m"}
            torque = f"hold_{s}*(r_m*{_PRESSED} - t*k*z)"
        else:
            modes[here] = {"z": "w", "w": f"-(k*z + C_{s}*(Omega + w) + r_m*xi_{s}*R)/Gamma_{s}"}
            rests[rest] = {"z": "w", "w": 0}
            torque = f"r_m*(R*(hold_plus + hold_minus) {'-+'[way > 0]} abs(R)*(hold_plus - hold_minus))/2"
        events.append({"mode": here, "when": f"Omega + w {'><'[way > 0]} 0", "to": rest})
        if threads or q > 0:
            events.append({"mode": rest, "when": f"-k*z {'<>'[way > 0]} {torque}", "to": here})
    sides = ("slip_forward", "slip_backward", "rest")[: 2 + threads]
    planes = [{"between": [f"{x}_negative", f"{x}_positive"], "at": _PRESSED if threads else _Q} for x in sides]
    return dict(states=[*rests[rest]], parameters=known, modes=modes | rests, events=events, surfaces=planes)
