"""The commands that simulate nothing: parameters, thresholds and stability of a drive."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from lsvib.cli.app import app
from lsvib.cli.options import MODEL, MODEL_IF_GIVEN, AsJson, Changes, SceneFile, pairs
from lsvib.cli.printing import print_parameters, print_solved_threshold, print_stability, print_thresholds, show
from lsvib.errors import InputError


@app.command
def config(
    *,
    model: Annotated[str | None, MODEL_IF_GIVEN] = None,
    changes: Changes = None,
    scene: SceneFile = None,
    as_json: AsJson = False,
) -> None:
    """Show the effective parameters of a drive, with units and allowed ranges.

    Examples of use:

        lsvib config

        lsvib config --set lead_angle_deg=4 --json

        lsvib config --model threads
    """
    from lsvib.api import drive_class
    from lsvib.models.drive import allowed_range, described, names_and_values

    start = _known_keys(scene) if scene else {}
    kind = drive_class(model or start.get("model", "rigid"))
    drive = kind.of(names_and_values("drive", start.get("drive"))).replace(**pairs(changes))
    fields = {}
    for key, value in drive:
        about = described(kind, key)
        allowed = allowed_range(kind, key)
        fields[key] = {"value": value, "unit": about["unit"], "symbol": about["symbol"], "allowed": allowed}
    show(fields, as_json, print_parameters)


@app.command
def thresholds(
    *,
    model: Annotated[str, MODEL] = "rigid",
    changes: Changes = None,
    solve: Annotated[
        str | None,
        Parameter(
            help="One threshold by name: onset, kinematic_constraint, negative_damping, flutter, stick, detach, "
            "global_stability, fold, cycle_birth or rest_loss."
        ),
    ] = None,
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

        lsvib thresholds

        lsvib thresholds --set translation_damping=1000 --json

        lsvib thresholds --model threads --set mass=9 --set contact_damping=5e4 --for contact_damping

        lsvib thresholds --solve stick --for translation_damping --set translation_damping=1000 --set axial_force=35

        lsvib thresholds --solve flutter --for mass --model threads --set contact_damping=5e4 --json
    """
    from lsvib.api import drive_class

    drive = drive_class(model).of(pairs(changes))
    if solve is not None:
        show(drive.threshold(solve, unknown).to_json(), as_json, print_solved_threshold)
        return
    table = {name: found.to_json() for name, found in drive.thresholds(unknown).items()}
    show(table, as_json, print_thresholds)


@app.command
def stability(*, model: Annotated[str, MODEL] = "rigid", changes: Changes = None, as_json: AsJson = False) -> None:
    """Classify the steady sliding of a drive by eqs (8.18) to (8.21).

    Examples of use:

        lsvib stability --set mass=11

        lsvib stability --set mass=1 --set translation_damping=1000 --set axial_force=25 --json

        lsvib stability --model threads --set mass=9 --set contact_stiffness=1e8 --set contact_damping=5e4

        lsvib stability --model support --set mass=15 --set friction_coefficient=0.3
    """
    from lsvib.api import drive_class

    show(drive_class(model).of(pairs(changes)).stability().to_json(), as_json, print_stability)


def _known_keys(scene: Path) -> dict[str, Any]:
    """Read the file of a scene; every key is one of a scene."""
    from lsvib.models.scene import Scene, read_yaml

    values = read_yaml(scene)
    for key in values:
        if key not in Scene.model_fields:
            raise InputError(f"{key} is not a known key; the known keys are {', '.join(Scene.model_fields)}.")
    return values
