"""The commands that simulate nothing: parameters, thresholds and stability of a drive."""

from collections.abc import Iterator
from typing import Annotated

from cyclopts import Parameter

from lsvib.cli.app import app, show
from lsvib.cli.options import AsJson, Changes, SceneFile, drive_of
from lsvib.drives.thresholds import TABLE
from lsvib.errors import InputError
from lsvib.words import table


@app.command
def config(*, changes: Changes = None, scene: SceneFile = None, as_json: AsJson = False) -> None:
    """Show the effective parameters of a drive, with units and allowed ranges.

    Examples of use:

        lsvib config --set lead_angle_deg=4 --json

        lsvib config --set contact_stiffness=1e8 --set contact_damping=1e8
    """
    from lsvib.drives.complaints import allowed_range, meant
    from lsvib.drives.drive import Drive, described
    from lsvib.drives.scene import Scene, read_yaml
    from lsvib.numbers import names_and_values

    start = read_yaml(scene) if scene else {}
    for key in start:
        if key not in Scene.model_fields:
            raise InputError(f"{key} is not a known key; {meant(Scene, key)}.")
    fields, rows = {}, []
    made = Drive.of(names_and_values("drive", start.get("drive"))).replace(**dict(changes or ()))
    for key, value in made.model_dump().items():
        about, allowed = described(key), allowed_range(Drive, key)
        fields[key] = {"value": value, "unit": about["unit"], "symbol": about["symbol"], "allowed": allowed}
        rows.append((key, about["symbol"], "absent" if value is None else f"{value:.15g}", about["unit"], allowed))
    show(fields, as_json, [table(rows, "parameter", "symbol", "value", "unit", "allowed range")])


@app.command
def describe(*, changes: Changes = None, as_json: AsJson = False) -> None:
    """Show the model of a drive: compliant parts, coordinates, equations of motion with numbers, modes.

    Example of use:

        lsvib describe --set contact_stiffness=1e8 --set screw_mass=3 --set support_stiffness=1e6
    """
    from lsvib.drives.description import description_of

    own = drive_of(changes)
    found, where = description_of(own), "in steady sliding" if own.input_speed else "with the coupling relaxed"

    def text() -> Iterator[str]:
        yield f"Compliant parts: {', '.join(found.parts) or 'the coupling only'}."
        yield "\nEquations (SI units; n axial contact force, τ torque of the threads)"
        yield from (f"  {line}" for line in found.equations)
        rows = ((key, unit, meaning) for key, (meaning, unit) in found.coordinates.items())
        yield f"\n{table(rows, 'coordinate', 'unit', 'meaning')}\n"
        yield table(((key, f"{value:.6g}") for key, value in found.steady.items()), where, "value")
        yield f"\nModes: {', '.join(found.modes)}."

    show(found.to_json(), as_json, text())


@app.command
def pairings(*, as_json: AsJson = False) -> None:
    """List friction coefficients by name, with their sources, for --set friction=NAME.

    Examples of use:

        lsvib pairings

        lsvib config --set friction=steel_on_bronze_lubricated
    """
    from lsvib.drives.pairings import PAIRINGS

    found = {
        key: {"low": one.low, "high": one.high, "parameters": one.parameters(), "source": one.source}
        for key, one in PAIRINGS.items()
    }
    rows = ((key, f"{one.low:g}", f"{one.high:g}", one.source) for key, one in PAIRINGS.items())
    show(found, as_json, [table(rows, "friction", "from", "to", "source")])


@app.command
def thresholds(
    *,
    changes: Changes = None,
    solve: Annotated[str | None, Parameter(help=f"One threshold by name: {', '.join(TABLE)}.")] = None,
    unknown: Annotated[
        str | None,
        Parameter(name="--for", help="Parameter to solve for; by default the usual one of each threshold."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compute the thresholds of a drive, each solved for one parameter.

    Lists all of them, beside what the chapter prints for the same drive; --solve takes one of them and adds its
    enclosure, all solutions, and derivatives with respect to all other parameters.

    Examples of use:

        lsvib thresholds --set translation_damping=1000 --json

        lsvib thresholds --solve stick --for translation_damping --set translation_damping=1000 --set axial_force=35

        lsvib thresholds --solve flutter --for mass --set contact_stiffness=1e8 --set contact_damping=5e4 --json
    """
    asked = drive_of(changes)
    if solve is not None:
        one = asked.threshold(solve, unknown)
        show(one.to_json(), as_json, one.text())
        return
    found = asked.thresholds(unknown)
    text = [table((row for one in found.values() for row in one.rows()), "threshold", "solved for", "remarks")]
    show({key: one.to_json() for key, one in found.items()}, as_json, text)


@app.command
def stability(*, changes: Changes = None, scene: SceneFile = None, as_json: AsJson = False) -> None:
    """Tell whether steady sliding is stable: class, eigenvalues, and which instabilities occur.

    Examples of use:

        lsvib stability --set mass=11

        lsvib stability --set mass=9 --set contact_stiffness=1e8 --set contact_damping=5e4 --json

        lsvib stability --set screw_mass=11.6 --set support_stiffness=1e6 --set mass=15 --set friction_coefficient=0.3
    """
    if scene is None:
        drive = drive_of(changes)
    else:
        from lsvib.answers.motion import as_scene  # which loads the engine
        from lsvib.api import Drive

        drive = Drive.of(as_scene(scene, {}, dict(changes or ())).drive)
    report = drive.stability()
    show(report.to_json(), as_json, report.text())
