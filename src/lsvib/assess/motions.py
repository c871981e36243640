"""The part of the report that shows motions: what the vibration is at the middle values and in the worst case."""

import math

import yaml

from lsvib.assess import pictures, report
from lsvib.assess.assessment import AssessedMotion, Assessment, Mechanism
from lsvib.assess.drive import point, random_entries
from lsvib.assess.report import Html
from lsvib.assess.words import ATTRACTORS, entry_name, shown


def where(one: Mechanism | AssessedMotion, assessment: Assessment) -> str:
    """Return the point of operation of a mechanism or motion in words."""
    direction, speed, force = one.corner
    lead = assessment.values["lead"] / (2 * math.pi)
    way = "outward" if direction > 0 else "back"
    side = "against" if force >= 0 else "in the direction of"
    load = f"{shown(abs(force), 'N')} {side} outward travel" if force else "no force on the load"
    weight = " besides its weight" if assessment.values["tilt"] != 0 else ""
    return f"travelling {way} at {shown(lead * speed, 'm/s')} ({shown(speed, 'rad/s')}) with {load}{weight}"


def rigid(assessment: Assessment) -> bool:
    """Whether the data sheet has neither a support nor a thread contact that gives way."""
    return assessment.sheet.contact is None and assessment.sheet.support is None


def motions(assessment: Assessment) -> list[Html]:
    """Return what is said of the motion at the middle values and in the worst case."""
    same = assessment.worst is assessment.nominal
    parts = [report.heading("What the vibration is")]
    shown_motions = [("At the given values" if same else "At the middle values", assessment.nominal)]
    if not same:
        shown_motions.append(("In the worst case within the uncertainties", assessment.worst))
    for title, motion in shown_motions:
        parts += _motion(title, motion, assessment)
    return parts


def _motion(title: str, motion: AssessedMotion, assessment: Assessment) -> list[Html]:
    start = "after a strong push" if motion.mechanism == "push_needed" else "after the slightest disturbance"
    parts = [
        report.heading(title, 3),
        report.paragraph(
            f"The drive is {where(motion, assessment)}, where it is most at risk.{_taken(motion, assessment)}"
        ),
    ]
    if motion is assessment.worst and motion is not assessment.nominal:
        spreads = assessment.sheet.spreads
        values = ", ".join(
            f"{entry_name(path)} = {shown(motion.entries[path], spreads[path].unit)}"
            for path in random_entries(assessment.sheet)
        )
        parts.append(report.paragraph(f"The values of this case: {values}."))
    return [
        *parts,
        _what_it_does(motion, start),
        *_push_survived(motion),
        *_picture_and_scene(title, motion),
    ]


def _what_it_does(motion: AssessedMotion, start: str) -> Html:
    """Say what becomes of the motion, whose ``start`` is given in words; of a vibration how large and fast it is."""
    moved = motion.vibration
    ends = ATTRACTORS.get(moved.attractor, moved.attractor)
    if moved.reason is not None:
        return report.paragraph(f"Of the motion {start} this is known: {moved.reason}")
    if moved.frequency is None:
        swing = (
            ""
            if moved.amplitude is None
            else f"; in the time shown the load oscillates by ± {shown(moved.amplitude, 'm')}"
        )
        verb = "returns to" if moved.attractor == "steady sliding" else "ends in"
        return report.paragraph(f"{start[0].upper()}{start[1:]} it {verb} {ends}{swing}.")
    (low, high), (slow, fast) = moved.load_speed, moved.screw_speed
    heard = "audible as a tone" if moved.audible else "not a tone for the ear, but its knocks may be heard"
    rows = [
        ("What it is", ends),
        ("Frequency", f"{shown(moved.frequency, 'Hz')}, {heard}"),
        ("Oscillation of the load about its path", f"± {shown(moved.amplitude, 'm')}"),
        ("Speed of the load within a cycle", f"{shown(low, 'm/s')} to {shown(high, 'm/s')}"),
        ("Speed of the screw within a cycle", f"{shown(slow, 'rad/s')} to {shown(fast, 'rad/s')}"),
        ("Largest contact force of the threads", shown(moved.peak_force, "N")),
    ]
    if moved.impulse:
        rows.append(
            ("Largest impact", f"{shown(moved.impulse, 'N s')}; its force depends on how stiff the threads are")
        )
    return report.table(["", start[0].upper() + start[1:]], rows)


def _push_survived(motion: AssessedMotion) -> list[Html]:
    """Say which sudden change of speed steady running tolerates, if that is known."""
    push, sentence = motion.push
    if push is None or push <= 0:
        return []
    if math.isfinite(push):
        load = shown(motion.values["lead"] / (2 * math.pi) * push, "m/s")
        sentence = (
            f"Steady running tolerates a sudden change of the screw's speed of up to {shown(push, 'rad/s')}, which is "
            f"{load} at the load. {sentence}"
        )
    return [report.paragraph(sentence)]


def _picture_and_scene(title: str, motion: AssessedMotion) -> list[Html]:
    """Draw the motion, and say how to run it, as far as it was computed."""
    moved, parts = motion.vibration, []
    if moved.time.size:
        caption = "Left alone " if motion.mechanism != "push_needed" else "Pushed "
        parts.append(
            report.picture(
                pictures.embedded(pictures.motion_chart, motion), f"{caption}, {title.lower()}.".replace(" ,", ",")
            )
        )
    if moved.scene and moved.time.size:
        parts += [
            report.paragraph("To run this motion yourself, save these lines as scene.yaml and run"),
            report.listing("lsvib simulate --scene scene.yaml --out motion.nc"),
            report.listing(yaml.safe_dump(moved.scene, sort_keys=False)),
        ]  # fmt: skip
    return parts


def _taken(motion: AssessedMotion, assessment: Assessment) -> str:
    """What the motion leaves out of the data sheet, in sentences."""
    sheet, model = assessment.sheet, motion.vibration.model
    parts = {"threads": sheet.contact is not None, "support": sheet.support is not None}
    stiff = " and ".join(name for name, given in parts.items() if given and name != model)
    text = f" Its motion is computed with stiff {stiff}." if stiff else ""
    slope = float(point(sheet, motion.values, *motion.corner).slope)
    if slope != 0:
        effect = "its rise with speed adds" if slope > 0 else "its fall with speed takes away"
        text += f" Friction is taken as constant at its value there; the damping that {effect} is not in this motion."
    return text
