"""The commands that simulate nothing: parameters, thresholds and stability of a drive."""

from collections.abc import Mapping
from typing import Annotated, Any

from cyclopts import Parameter

from lsvib.cli.app import app
from lsvib.cli.options import CHAPTER, AsJson, DriveOptions, SceneFile
from lsvib.cli.printing import name, quantity, show, table, with_unit
from lsvib.errors import InputError
from lsvib.models.thresholds import TABLE


@app.command
def config(*, drive: DriveOptions = CHAPTER, scene: SceneFile = None, as_json: AsJson = False) -> None:
    """Show the effective parameters of a drive, with units and allowed ranges.

    Examples of use:

        lsvib config --set lead_angle_deg=4 --json

        lsvib config --set contact_stiffness=1e8 --set contact_damping=1e8
    """
    from lsvib.models.drive import Drive, allowed_range, described, names_and_values
    from lsvib.models.scene import Scene, read_yaml

    start = read_yaml(scene) if scene else {}
    for key in start:
        if key not in Scene.model_fields:
            raise InputError(f"{key} is not a known key; the known keys are {', '.join(Scene.model_fields)}.")
    fields = {}
    made = Drive.of(names_and_values("drive", start.get("drive"))).replace(**drive.values())
    for key, value in made.model_dump().items():
        about = described(key)
        allowed = allowed_range(Drive, key)
        fields[key] = {"value": value, "unit": about["unit"], "symbol": about["symbol"], "allowed": allowed}

    def text(fields: Mapping[str, Any]) -> None:
        rows = [(key, one["symbol"], _number(one["value"]), one["unit"], one["allowed"]) for key, one in fields.items()]
        table(rows, "parameter", "symbol", "value", "unit", "allowed range")

    show(fields, as_json, text)


def _number(value: float | None) -> str:
    return "not there" if value is None else f"{value:.15g}"


@app.command
def describe(*, drive: DriveOptions = CHAPTER, as_json: AsJson = False) -> None:
    """Show what a drive is made of: parts that comply, coordinates, equations of motion with numbers, modes.

    Example of use:

        lsvib describe --set contact_stiffness=1e8 --set screw_mass=3 --set support_stiffness=1e6
    """
    from lsvib.models.description import description_of

    def text(found: Mapping[str, Any]) -> None:
        print(f"What complies: {', '.join(found['parts']) or 'nothing but the coupling'}.")
        print("\nEquations (SI units; n axial contact force, τ torque of the threads)")
        print(*(f"  {line}" for line in found["equations"]), sep="\n")
        print()
        rows = [(key, one["unit"], one["long_name"]) for key, one in found["coordinates"].items()]
        table(rows, "coordinate", "unit", "meaning")
        print()
        table([(key, f"{value:.6g}") for key, value in found["steady"].items()], "in steady sliding", "value")
        print(f"\nModes: {', '.join(found['modes'])}.")

    show(description_of(drive.drive()).to_json(), as_json, text)


@app.command
def pairings(*, as_json: AsJson = False) -> None:
    """List the friction that is known by name, with its source, for --set friction=NAME.

    Example of use:

        lsvib pairings

        lsvib config --set friction=steel_on_bronze_lubricated
    """
    from lsvib.models.pairings import PAIRINGS

    found = {
        key: {"low": one.low, "high": one.high, "parameters": one.parameters(), "source": one.source}
        for key, one in PAIRINGS.items()
    }

    def text(found: Mapping[str, Any]) -> None:
        rows = [(key, f"{one['low']:g}", f"{one['high']:g}", one["source"]) for key, one in found.items()]
        table(rows, "friction", "from", "to", "source")

    show(found, as_json, text)


@app.command
def thresholds(
    *,
    drive: DriveOptions = CHAPTER,
    solve: Annotated[str | None, Parameter(help=f"One threshold by name: {', '.join(TABLE)}.")] = None,
    unknown: Annotated[
        str | None,
        Parameter(name="--for", help="The parameter to solve for; others are held. By default the usual one of each."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compute the thresholds of the drive that --set makes, each solved for one parameter.

    All of them by name, beside what the chapter prints for this very drive, or with --solve one of them with its
    enclosure, all solutions, and derivatives by all other parameters.

    Examples of use:

        lsvib thresholds --set translation_damping=1000 --json

        lsvib thresholds --solve stick --for translation_damping --set translation_damping=1000 --set axial_force=35

        lsvib thresholds --solve flutter --for mass --set contact_stiffness=1e8 --set contact_damping=5e4 --json
    """
    asked = drive.drive()
    if solve is not None:
        show(asked.threshold(solve, unknown).to_json(), as_json, _print_solved)
        return
    show({key: found.to_json() for key, found in asked.thresholds(unknown).items()}, as_json, _print_thresholds)


@app.command
def stability(*, drive: DriveOptions = CHAPTER, as_json: AsJson = False) -> None:
    """Say whether steady sliding is stable: its class, eigenvalues, and each condition of instability.

    Examples of use:

        lsvib stability --set mass=11

        lsvib stability --set mass=9 --set contact_stiffness=1e8 --set contact_damping=5e4 --json

        lsvib stability --set screw_mass=11.6 --set support_stiffness=1e6 --set mass=15 --set friction_coefficient=0.3
    """
    show(drive.drive().stability().to_json(), as_json, _print_stability)


def _print_thresholds(found: Mapping[str, Any]) -> None:
    rows = []
    for key, entry in found.items():
        printed, about, unit = entry["printed"], "", entry["unit"]
        if entry["value"] is None:
            rows.append((key, "none", entry["reason"]))
        elif printed is not None:
            verdict = "pass" if printed["passed"] else "FAIL"
            about = f"chapter {printed['value']:g}, relative error {printed['relative_error']:.2%}, {verdict}"
        for solution in entry["solutions"]:
            value = with_unit(f"{solution['value']:.12g}", unit)
            rows.append((key, f"{entry['unknown']} = {value}", about))
        for low, high in entry["stable_intervals"]:
            first = "" if low is None else f" from {low:.12g}"
            last = "" if high is None else f"{' up' if low is None else ''} to {high:.12g}"
            ends = with_unit(first + last, unit) + (" on" if first and not last else "")
            rows.append(("", "", f"{entry['stability']} stability{ends}"))
    table(rows, "threshold", "solved for", "remarks")


def _print_solved(found: Mapping[str, Any]) -> None:
    unknown, count = found["unknown"], len(found["solutions"])
    print(f"{found['name']}: {count} solution{'s' if count > 1 else ''} for {unknown}. {found['how']}")
    print(found["statement"])
    for solution in found["solutions"]:
        low, high = solution["enclosure"]
        print(f"{unknown} = {with_unit(repr(solution['value']), found['unit'])}, between {low!r} and {high!r}")
        print(f"  equation: {solution['equation']}")
        for key, slope in solution["derivatives"].items():
            if slope["value"]:
                print(f"  d/d {key} = {quantity(slope)}")


def _print_stability(found: Mapping[str, Any]) -> None:
    neutral = found["kind"] in ("neutral", "centre")
    verdict = "stable" if found["stable"] else "neutral" if neutral else "unstable"
    kind = name(found["kind"])
    print(f"steady sliding is {verdict}{'' if kind == verdict else f' ({kind})'}")
    for value in found["eigenvalues"]:
        imaginary = f" {value['imaginary']:+.10g}i" if value["imaginary"] else ""
        print(f"  eigenvalue {value['real']:.10g}{imaginary} 1/s")
    _print_quantities_and_conditions(found)
    if found["without_damping"] is not None:
        print(f"without any damping: {name(found['without_damping']['kind'])}")
        _print_quantities_and_conditions(found["without_damping"])


def _print_quantities_and_conditions(found: Mapping[str, Any]) -> None:
    for key, entry in found.get("quantities", {}).items():
        print(f"  {key}: {quantity(entry)}")
    for key, condition in found["conditions"].items():
        print(f"  condition {key}: {'holds' if condition['hold'] else 'does not hold'}")
