"""The results of the commands as text, for people; ``--json`` prints the same as one object."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lsvib.errors import InputError

if TYPE_CHECKING:
    from lsvib.datasets.checks import Check


def show(
    result: Mapping[str, Any], as_json: bool, text: Callable[[Mapping[str, Any]], None], out: Path | None = None
) -> None:
    """Print a result as one JSON object, or as ``text`` prints it for people; ``out``: a file that was written."""
    if as_json:
        print(json.dumps(result, indent=2, allow_nan=False))
        return
    if out is not None:
        print(f"wrote {out}")
    text(result)


def print_thresholds(table: Mapping[str, Any]) -> None:
    """Print the thresholds of a drive: all solutions of each, or why there is none, and what the chapter prints."""
    for name, entry in table.items():
        if entry["value"] is None:
            print(f"{name:21s} none: {entry['reason']}")
        for solution in entry["solutions"]:
            value = _with_unit(f"{solution['value']:.12g}", entry["unit"])
            line = f"{name:21s} {entry['unknown']} = {value}"
            if entry["printed"] is not None:
                printed = entry["printed"]
                verdict = "pass" if printed["passed"] else "FAIL"
                line += f"   chapter {printed['value']:g}, relative error {printed['relative_error']:.2%}, {verdict}"
            print(line)
        for low, high in entry["stable_intervals"]:
            ends = "from the least value" if low is None else f"from {low:.12g}"
            ends += " on" if high is None else _with_unit(f" to {high:.12g}", entry["unit"])
            print(f"  {entry['stability']} stability {ends}")


def print_solved_threshold(found: Mapping[str, Any]) -> None:
    """Print all solutions of a threshold, with the derivatives that are not zero."""
    unknown, count = found["unknown"], len(found["solutions"])
    print(f"{found['name']}: {count} solution{'s' if count > 1 else ''} for {unknown}. {found['how']}")
    print(found["statement"])
    for solution in found["solutions"]:
        low, high = solution["enclosure"]
        print(f"{unknown} = {_with_unit(repr(solution['value']), found['unit'])}, between {low!r} and {high!r}")
        print(f"  equation: {solution['equation']}")
        for name, slope in solution["derivatives"].items():
            if slope["value"]:
                print(f"  d/d {name} = {_value(slope)}")


def print_stability(table: Mapping[str, Any]) -> None:
    """Print a report of the stability of a drive."""
    neutral = table["kind"] in ("neutral", "centre")
    verdict = "stable" if table["stable"] else "neutral" if neutral else "unstable"
    kind = table["kind"].replace("_", " ")
    print(f"steady sliding is {verdict}{'' if kind == verdict else f' ({kind})'}")
    for value in table["eigenvalues"]:
        print(f"  eigenvalue {value['real']:.10g} {value['imaginary']:+.10g}i 1/s")
    _print_quantities(table["quantities"])
    _print_conditions(table["conditions"])
    if table["without_damping"] is not None:
        print(f"without any damping: {table['without_damping']['kind'].replace('_', ' ')}")
        _print_quantities(table["without_damping"]["quantities"])
        _print_conditions(table["without_damping"]["conditions"])


def print_motion(result: Mapping[str, Any]) -> None:
    """Print the summary of a motion."""
    final = result["final_state"]
    numbers = ", ".join(f"{key} = {value:.15g}" for key, value in final.items() if key != "mode")
    print(f"final state: {numbers}, {final['mode'].replace('_', ' ')} (SI units)")
    print("events: " + (", ".join(f"{n} {kind.replace('_', ' ')}" for kind, n in result["events"].items()) or "none"))
    doubt = result.get("unresolved_because")
    print(f"attractor: {result['attractor'].replace('_', ' ')}{f': {doubt}' if doubt else ''}")
    print(f"peak normal force: {result['peak_normal_force']:.10g} N, without the impulses of seizures")
    if result.get("peak_normal_impulse"):
        print(f"peak normal impulse of a seizure: {result['peak_normal_impulse']:.10g} N s")


def print_sweep(result: Mapping[str, Any]) -> None:
    """Print the summary of a sweep."""
    for kind, count in result["attractors"].items():
        print(f"{kind.replace('_', ' ')}: {count} of {result['points']} points")
    print(f"{_plain(result['points_per_second'])} points per second")


def print_chart(result: Mapping[str, Any]) -> None:
    """Print the summary of a chart."""
    for name, part in result["fractions"].items():
        print(f"{name.replace('_', ' ')}: {100 * part:.6g} % of {result['cells']} cells")
    curves = ", ".join(name.replace("_", " ") for name in result["curves"])
    print(f"exact curves: {curves or 'none'}")
    print(f"{_plain(result['cells_per_second'])} cells per second")


def picture_files(figure: Path | None) -> list[tuple[Path, str]]:
    """Return the files to draw a picture to and what they are called in messages; none if no figure is asked for."""
    if figure is None:
        return []
    if figure.suffix != ".png":
        raise InputError(f"figure = {figure} does not end in .png; a PDF is written beside it.")
    return [(figure, "PNG"), (figure.with_suffix(".pdf"), "PDF")]


def print_map(result: Mapping[str, Any], counts: Mapping[Any, int]) -> None:
    """Print the summary of a map; ``counts``, cells by attractor."""
    for kind, cells in counts.items():
        if cells and kind >= 0:
            share = f"{100 * cells / result['cells']:.6g} %"
            print(f"{kind.name.lower().replace('_', ' ')}: {share} of {result['cells']} cells")
    print(f"unresolved: {result['unresolved']} cells")
    for doubt, cells in result["unresolved_because"].items():
        print(f"  {cells} cells unresolved: {doubt}")
    area = result["exact_basin_area"]
    if area is not None:
        print(f"exact area of the basin of steady sliding in the map: {area:.12g} rad2/s")
    print(f"{_plain(result['cells_per_second'])} cells per second")


def print_checks(picture: Path, checks: Sequence["Check"], as_json: bool) -> None:
    """Print the checks of a figure and where its picture lies."""

    def text(result: Mapping[str, Any]) -> None:
        """Print a sentence for each check, and last where the picture lies."""
        for check in checks:
            print(check.sentence())
        failed = sum(not check.passed for check in checks)
        if checks:
            print(f"{failed} of {len(checks)} checks failed." if failed else f"All {len(checks)} checks passed.")
        print(f"wrote {picture}, its PDF, dataset and checks")

    show({"figure": str(picture), "checks": [check.to_json() for check in checks]}, as_json, text)


def print_parameters(fields: Mapping[str, Any]) -> None:
    """Print the parameters of a drive with units and allowed ranges."""
    for key, entry in fields.items():
        print(f"{key:21s} {entry['symbol']:7s} = {entry['value']:<20.15g} {entry['unit']:15s} {entry['allowed']}")


def _plain(rate: float) -> str:
    """A rate in three digits, without a power of ten."""
    return f"{float(f'{rate:.3g}'):.15g}"


def _value(entry: Mapping[str, Any]) -> str:
    return "none" if entry["value"] is None else _with_unit(f"{entry['value']:.12g}", entry["unit"])


def _with_unit(text: str, unit: str) -> str:
    """A number with its unit; a pure number, whose unit is "1" in files, stands alone."""
    return text if unit == "1" else f"{text} {unit}"


def _print_quantities(quantities: Mapping[str, Any]) -> None:
    for name, entry in quantities.items():
        print(f"  {name}: {_value(entry)}")


def _print_conditions(conditions: Mapping[str, Any]) -> None:
    for name, condition in conditions.items():
        print(f"  {name}: {'holds' if condition['hold'] else 'does not hold'}")
