"""Threads of the catalogues by name, as makers print them: metric trapezoidal, Acme, metric and Unified; materials."""

import math
import re
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator

from lsvib.drives.pairings import PAIRINGS
from lsvib.drives.scene import read_yaml
from lsvib.numbers import shown
from lsvib.sheets.fields import NotQuantity
from lsvib.sheets.units import plain

_TABLES = read_yaml(Path(__file__).with_name("threads.yaml"))
_N = r"(\d+(?:\.\d+)?|\.\d+)"
_SIZE, _STARTS = (
    rf"((?:\d[ -])?\d{{1,2}}/\d{{1,2}}|{_N[1:-1]})[ -]*(?:in|\")? ?-",
    r"(?: ?[x,-]? ?\(?([1-9]) ?-?starts?\)?)?",
)
_PITCH_FIRST = re.compile(rf"[*x] ?P{_N} ?[*x] ?([1-9])N", re.IGNORECASE)  # Tr8*P2*4N, of 4 starts
_ISO = re.compile(rf"M ?{_N}(?: ?[x-] ?{_N})?", re.IGNORECASE)
_TRAPEZOID = re.compile(rf"Tr? ?{_N}(?: ?x ?{_N}(?: ?\(?P ?{_N}\)?)?{_STARTS})?", re.IGNORECASE)
_INCHES = re.compile(rf"{_SIZE} ?([1-9]\d?)(?: ?tpi)?{_STARTS}", re.IGNORECASE)
_ASME = re.compile(rf"{_SIZE} ?{_N}P ?- ?{_N}L", re.IGNORECASE)
_BALL = re.compile(r"(?:[SDF]F[A-Z]{1,2}|BSH?|KG[STF]|R)?[ -]?(\d\d)[x-]?0?(\d\d?)(?:-\d)?R?", re.IGNORECASE)
_SERIES = re.compile(r"[ -]*\b(Acme|UN[CF])\b[ -]*", re.IGNORECASE)
_HAND = re.compile(r"[ ,-]*(?:(?<![A-Z])[LR]H\b|\b(?:left|right)[ -]hand(?:ed)?\b)", re.IGNORECASE)
_TOLERANCE = re.compile(r"(?<=[\dL)])[ -]+\d[A-Za-z](?:/\d[A-Za-z])?$")  # 7e, 6H/6g, 2G


@dataclass(frozen=True)
class ThreadSize:
    """A thread: ``lead`` and ``pitch_diameter`` [m], ``half_angle`` of a flank in an axial section [rad].

    ``root_diameter``, ``nominal_diameter`` of the screw [m]; ``engaged_depth`` over the pitch [1]; ``name`` as written.
    """

    lead: float
    pitch_diameter: float
    half_angle: float
    root_diameter: float
    nominal_diameter: float
    engaged_depth: float = 0.5
    name: str = field(default="", compare=False)


def thread_size(name: object) -> ThreadSize:
    """Return the thread of a name such as ``Tr 10x2``, ``Tr 8x8 P2`` (lead, then pitch), ``Acme 1/2-10``, ``M20``.

    The pitch diameter of Tr (DIN 103, ISO 2904) and Acme (ASME B1.5) is the nominal one d less half a pitch P, the root
    diameter d − P − 2 a with a clearance a of the standard; of M (ISO 724) and UN they are d − 3√3/8 P and
    d − 17√3/24 P. Raises ``NotQuantity`` with the end of a sentence.
    """
    text = _HAND.sub("", re.sub(r"(?<=\d) ?[*xX] ?(?=\d)", "x", plain(str(name)))).strip()  # statics are those of RH
    series = {found.upper() for found in _SERIES.findall(text)}
    text = _TOLERANCE.sub("", _SERIES.sub(" ", text).strip())
    text = _PITCH_FIRST.sub(lambda found: f"x{float(found[1]) * int(found[2]):g} P{found[1]}", text)
    forms = (_TRAPEZOID, _trapezoidal), (_ASME, _acme), (_INCHES, partial(_of_inches, series)), (_ISO, _metric)
    for pattern, made in forms:
        if match := pattern.fullmatch(text):
            try:
                return replace(made(*match.groups()), name=str(name))
            except NotQuantity as error:
                raise NotQuantity(f"= {shown(name)} {error}") from None
    if match := _BALL.fullmatch(text):
        raise NotQuantity(
            f"= {shown(name)} is a ball screw, not a sliding thread; give thread.lead = {match[2]} mm, "
            f"thread.pitch_diameter = {match[1]} mm or what its maker states, and friction.efficiency or coefficient"
        )
    raise NotQuantity(
        f"= {shown(name)} is not the name of a thread, such as Tr 10x2, Tr 8x8 P2, Acme 1/2-10, M20x2.5, or of an Acme "
        "thread with pitch and lead in inches, Acme 3/8-0.1P-0.5L"
    )


@cache
def catalogue(half_angle: float) -> list[ThreadSize]:
    """Return threads that are made with flanks of a half angle [rad], Tr if none has it; of up to 4 starts."""
    names = [f"M{d:g}x{pitch:g}" for d, pitches in _TABLES["metric"].items() for pitch in pitches]
    if math.isclose(half_angle, math.radians(14.5)):
        pairs = [(d, n, n / threads, 1 / threads) for d, threads in _TABLES["acme"].items() for n in (1, 2, 4)]
        names = [f"Acme {d}-{p:.6g}P-{lead:.6g}L" for d, n, lead, p in pairs if n == 1 or lead <= _inches(d)]
    elif not math.isclose(half_angle, math.radians(30)):
        pairs = [(d, n, n * p, p) for d, own in _TABLES["trapezoidal"].items() for p in own for n in (1, 2, 3, 4)]
        names = [f"Tr {d:g}x{lead:g}" + f" P{p:g}" * (n > 1) for d, n, lead, p in pairs if n == 1 or lead <= d]
    return [thread_size(name) for name in names]


def _trapezoidal(size: str, named: str | None, own: str | None, count: str | None) -> ThreadSize:
    """A trapezoidal thread [mm]; a lead that is no pitch is one of 2 to 4 starts, if only one pitch makes it so."""
    diameter, lead, starts = float(size), float(named or 0), int(count or 0)
    pitches = _TABLES["trapezoidal"].get(diameter, ())
    if own:
        fits = [(lead, float(own))]
    elif starts:  # the number before them may be the lead, as in the standard, or the pitch
        fits = [(one, one / starts) for one in {lead, lead * starts} if one / starts in pitches]
    elif lead:
        fits = [(lead, p) for p in pitches if lead / p in ((1,) if lead in pitches else range(2, 9))]
        fits = [] if len(fits) == 1 and lead > 4 * fits[0][1] else fits
    else:
        fits = [(p, p) for p in pitches] + [(4 * p, p) for p in pitches[1:2]]
    if len(fits) > 1:
        *names, last = (f"Tr {size}x{one:g}" + (f" P{p:g}" if p < one else "") for one, p in sorted(fits))
        raise NotQuantity(f"may be several threads; write {', '.join(names)} or {last}: lead, then P and the pitch")
    if not fits:
        has = (
            f"Tr {size} has the pitches {', '.join(map(str, pitches))} mm" if pitches else "it goes from Tr 8 to Tr 300"
        )
        like = f"Tr {size}x{lead:g} P{lead if lead <= 0.5 * diameter else lead / 4:g}"
        raise NotQuantity(f"is not in the catalogue: {has}; write any other pitch after a P, such as {like}")
    ((lead, pitch),) = fits
    _check(diameter, pitch, lead, "mm")
    clearance = 0.15 if pitch < 2 else 0.25 if pitch < 6 else 0.5 if pitch < 14 else 1.0
    root = (diameter - pitch - 2 * clearance) * 1e-3
    return ThreadSize(lead * 1e-3, (diameter - 0.5 * pitch) * 1e-3, math.radians(15), root, diameter * 1e-3)


def _of_inches(series: set[str], size: str, threads: str, starts: str | None) -> ThreadSize:
    """A thread of so many per inch, Acme or Unified by its series, or Acme if its size is one of the standard."""
    pitch, inches, count = 1 / int(threads), _inches(size), int(starts or 1)
    size = next((known for known in _TABLES["unified"] | _TABLES["acme"] if abs(_inches(known) - inches) < 1e-3), size)
    kind = dict(zip(_TABLES["unified"].get(size, ()), ("UNC", "UNF"), strict=False)).get(int(threads))
    if count == 1 and kind in series:
        return _sixty_degrees(25.4 * inches, 25.4 * pitch)
    if count == 1 and series <= {"ACME"} and _TABLES["acme"].get(size) == int(threads):
        return _acme(size, str(pitch), str(pitch))
    names = [f"{size}-{threads} {kind}"] if kind and count == 1 and not series else []
    own = (pitch,) if count == 1 else (pitch, pitch / count)  # so many threads, or turns, per inch
    names += [f"Acme {size}-{p:.6g}P-{count * p:.6g}L" for p in own]
    raise NotQuantity(f"is not in the catalogue; write {' or '.join(names)}, with pitch P and lead L in inches")


def _acme(size: str, own: str, named: str) -> ThreadSize:
    """An Acme thread of pitch and lead [inch]."""
    diameter, pitch, lead = _inches(size), float(own), float(named)
    _check(diameter, pitch, lead, "inch")
    root = (diameter - pitch - (0.02 if pitch >= 0.1 else 0.01)) * 0.0254
    return ThreadSize(0.0254 * lead, (diameter - 0.5 * pitch) * 0.0254, math.radians(14.5), root, 0.0254 * diameter)


def _check(diameter: float, pitch: float, lead: float, unit: str) -> None:
    starts = lead / pitch if 0 < pitch <= 0.5 * diameter else 0.0
    if abs(starts - round(starts)) > 0.01 or not 1 <= round(starts) <= 20:
        raise NotQuantity(f"has a pitch above half its diameter, or a lead that is not 1 to 20 times {pitch:g} {unit}")


def _metric(size: str, named: str | None) -> ThreadSize:
    """A metric thread [mm], whose pitch need not be named if it is the coarse one."""
    pitches = _TABLES["metric"].get(float(size), ())
    if not pitches or (named and float(named) not in pitches):
        has = f"M{size} has the pitches {', '.join(map(str, pitches))} mm" if pitches else "it goes from M3 to M64"
        raise NotQuantity(f"is not in the catalogue: {has}")
    return _sixty_degrees(float(size), float(named or pitches[0]))


def _sixty_degrees(diameter: float, pitch: float) -> ThreadSize:
    height = math.sqrt(3) / 2 * pitch  # of the fundamental triangle
    middle, root, nominal = (1e-3 * (diameter - share * height) for share in (3 / 4, 17 / 12, 0))
    return ThreadSize(pitch * 1e-3, middle, math.radians(30), root, nominal, 5 / 8 * height / pitch)


def _inches(text: str) -> float:
    return float(sum(map(Fraction, text.replace("-", " ").split())))


Size = Annotated[ThreadSize, BeforeValidator(thread_size)]


_TABLE: dict[str, Any] = read_yaml(Path(__file__).with_name("materials.yaml"))


@dataclass(frozen=True)
class ScrewMaterial:
    """Density [kg/m³], to one per cent that of the usual alloys; Young's modulus and yield strength [Pa]."""

    density: float
    modulus: float
    yield_strength: float


@dataclass(frozen=True)
class NutMaterial:
    """What a nut bears, as its maker or a handbook says in ``source``; None is what they do not say.

    ``pressure_limit`` [Pa] of its projected area, ``pv_limit`` [Pa m/s] of pressure times sliding speed.
    """

    pressure_limit: float | None
    pv_limit: float | None
    source: str


SCREW_MATERIALS = {name: ScrewMaterial(*numbers) for name, numbers in _TABLE["screws"].items()}
NUT_MATERIALS = {name: NutMaterial(p, pv, _TABLE["sources"][by]) for name, (p, pv, by) in _TABLE["nuts"].items()}
_ALSO = {other: name for name, others in _TABLE["also"].items() for other in others.split()}


def common_name(name: Any) -> Any:
    """Return the name of a material in the tables for another one, such as acetal for POM, if there is one."""
    plain = re.sub(r"[\s-]+", "_", str(name).strip().lower())
    return _ALSO.get(plain, plain if plain in NUT_MATERIALS | SCREW_MATERIALS else name)


def pairings(nut: Any, screw: Any) -> dict[str, list[float]]:
    """Return the names of :data:`PAIRINGS` for a nut of one material on a screw of another (steel), with their ranges.

    >>> pairings("leaded_tin_bronze", None)
    {'steel_on_bronze_dry': [0.4, 0.4], 'steel_on_bronze_lubricated': [0.15, 0.15]}
    """
    nut, screw = common_name(nut), common_name(screw)
    if not isinstance(nut, str) or screw not in (None, "steel", "stainless steel"):
        return {}
    kind = "bronze" if nut.endswith("bronze") else nut
    found = {name: one for name, one in PAIRINGS.items() if f"{name.removeprefix('steel_on_')}_".startswith(f"{kind}_")}
    return {name: [one.low, one.high] for name, one in found.items()}
