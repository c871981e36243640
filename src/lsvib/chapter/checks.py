"""Checks of computed values against the chapter, kept as data: claim, expected, computed, error, tolerance, verdict.

The checks of a run become a text, by figure, and the printed numbers a table for a report (``checks.*.j2``), both with
the outcome for all that the chapter states (``config/chapter.yaml``).
"""

import json
import math
import operator
import os
import re
import string
import textwrap
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any, Literal, NamedTuple, Self

import numpy as np

from lsvib.drives import chapter
from lsvib.drives.chapter import claims
from lsvib.drives.scene import read_yaml
from lsvib.errors import InputError

NamedChecks = Sequence[tuple[str, "Check"]]  # pairs (figure, check)
Statements = dict[str, list[dict[str, Any]]]
_VERDICTS = {  # the first that an entry has is its own: a check may hold the evidence of a correction
    "correction": "need a correction ({})",
    "id": "are checked",
    "input": "are inputs",
    "left": "belong to figures that are not in this run",
    "unchecked": "are not checked, each for a stated reason",
}
_RELATIONS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}


class Clause(NamedTuple):
    """One of the conditions that a claim is made of: what was found, in words that take its name, and its verdict."""

    value: Any
    words: str
    passed: bool


def each(value: Any, relation: Literal["<", "<=", ">", ">="], bound: Any) -> Clause:
    """Return the clause that a number, or each of an array, is in a relation to a bound; NaN and none never are."""
    numbers, limit = np.ravel(value), float(bound)
    worst = float((numbers.max if "<" in relation else numbers.min)()) if numbers.size else math.nan
    return Clause(worst, f"{{}} {text(worst)} {relation} {text(limit)}", _RELATIONS[relation](worst, limit))


def near(value: Any, expected: Any, tolerance: float) -> Clause:
    """Return the clause that a number, or each of an array, is what is expected, up to a relative error [1]."""
    found = each(abs(value / expected - 1), "<=", tolerance)
    return found._replace(words=found.words.replace("{}", "{} off by"))


def every(cases: Any) -> Clause:
    """Return the clause that something is so in all cases of a Boolean array, at least one."""
    return _counted("all", cases, np.all(cases) and np.size(cases))


def some(cases: Any) -> Clause:
    """Return the clause that something is so in at least one case of a Boolean array."""
    return _counted("some", cases, np.any(cases))


def never(cases: Any) -> Clause:
    """Return the clause that something is so in no case of a Boolean array, which has at least one."""
    return _counted("no", cases, not np.any(cases) and np.size(cases))


def _counted(word: str, cases: Any, holds: Any) -> Clause:
    return Clause(np.asarray(cases), f"{word} {{}} ({int(np.sum(cases))} of {np.size(cases)})", bool(holds))


@dataclass(frozen=True)
class Check:
    """One claim of the chapter and what was computed; make it with :meth:`of` or :meth:`that`.

    ``claim`` is a sentence, ``source`` says where the chapter makes it, ``error`` is the relative error [1],
    ``tolerance`` the largest relative error allowed [1] and ``tolerance_reason`` why; ``expected`` and ``computed`` are
    numbers in ``unit``. For a claim that holds or does not, ``expected`` is ``"true"``, ``computed`` says what was
    found, ``unit``, ``error`` and ``tolerance`` are None. ``id``: that of the claim in ``config/chapter.yaml``, if any.
    ``clauses``: of a claim that has several conditions what was found of each, by its name, and whether it holds.
    """

    claim: str
    source: str
    expected: float | str
    computed: float | str
    error: float | None
    tolerance: float | None
    tolerance_reason: str
    unit: str | None
    passed: bool
    id: str = ""
    clauses: dict[str, dict[str, Any]] = field(default_factory=dict)

    @classmethod
    def holds(cls, claim: str, source: str, computed: str, truth: bool) -> Self:
        """Check that a claim holds: ``truth`` decides, ``computed`` says in words or numbers what was found."""
        return cls(claim, source, "true", computed, None, None, "", None, bool(truth))

    @classmethod
    def that(cls, id: str, /, **told: Any) -> Self:
        """Check that the claim of this id in ``config/chapter.yaml`` holds, where all its words are.

        ``told``, by name: the clauses that decide, all of which have to hold – :func:`each`, :func:`every`,
        :func:`some`, :func:`never` –, and what else the words leave open in braces: a number or text, an array, of
        which each entry is told, or ``{x.min}`` and the like of an array ``x``. Clauses that the words do not tell, and
        those that do not hold, follow them.
        """
        said, judged = claims()[id], {name: one for name, one in told.items() if isinstance(one, Clause)}
        numbers = {name: one.value if name in judged else one for name, one in told.items()}
        claim, source, found = (_filled(words, numbers) for words in (said.claim, said.source, said.found))
        clauses, rest = {}, []
        for name, (_, words, holds) in judged.items():
            words = words.format(name.replace("_", " "))
            clauses[name] = {"found": words, "passed": holds}
            if not holds or not re.search(rf"{{{name}\b", said.found):
                rest.append(words if holds else f"NOT {words}")
        passed = bool(clauses) and all(one.passed for one in judged.values())
        words = "; ".join(filter(None, (found, ", ".join(rest))))
        return cls(claim, source, "true", words, None, None, "", None, passed, id, clauses)

    @classmethod
    def of(cls, id: str, computed: Any, *, expected: Any = None, note: str = "", **left_open: Any) -> Self:
        """Check the number that has this id in ``config/chapter.yaml``, where its words, source and tolerance are.

        ``computed``, or of several numbers the worst, is compared with the one that the chapter prints, or else with
        what is ``expected``; what is not finite never passes, nor does anything where zero is expected. ``left_open``:
        what words and source leave open, by the name in braces; ``note``: what is special, to follow the claim.
        """
        said, numbers = claims()[id], np.ravel(computed)
        claim, source = (_filled(words, left_open) for words in (said.claim, said.source))
        aim = float(said.value if expected is None else expected)
        worst = float(numbers[np.argmax(np.abs(numbers - aim))])  # NaN is worse than any
        error, claim = abs(worst - aim) / abs(aim) if aim else math.nan, f"{claim}, {note}" if note else claim
        passed = error <= said.tolerance
        return cls(claim, source, aim, worst, error, said.tolerance, said.reason, said.unit, passed, id)

    def to_json(self) -> dict[str, Any]:
        """Return plain values for JSON; numbers that are not finite become text, because JSON has none."""
        return {key: str(v) if isinstance(v, float) and not math.isfinite(v) else v for key, v in asdict(self).items()}

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Self:
        """Rebuild a check from :meth:`to_json`."""
        texts, numbers = ("nan", "inf", "-inf"), ("computed", "error")
        plain: dict[str, Any] = {k: float(v) if k in numbers and v in texts else v for k, v in values.items()}
        return cls(**plain)

    def aim(self) -> str:
        """Return what is expected with its unit, a printed number with the digits that the chapter prints."""
        said = claims().get(self.id)
        digits = said.digits if said and said.value == self.expected else ""
        return quantity(digits or self.expected, self.unit)

    def sentence(self) -> str:
        """Return the verdict as one sentence."""
        if self.tolerance is None:
            return f"{self.claim}: {'true' if self.passed else 'NOT true'} ({self.computed}) [{self.source}]."
        return (
            f"{self.claim}: expected {self.aim()}, "
            f"computed {quantity(self.computed, self.unit)}, relative error "
            f"{text(self.error)} {'<=' if self.passed else 'is NOT <='} {text(self.tolerance)} [{self.source}]."
        )


class _Words(string.Formatter):
    """Fills in numbers and texts: of an array each entry, or one, ``{x[-1]}``, or a number of all, ``{x.min}``."""

    def get_field(self, field_name: str, args: Any, kwargs: Mapping[str, Any]) -> tuple[Any, str]:
        """Return what is named; NaN for what an empty array has not, such as the least of its entries."""
        name, index, method = re.fullmatch(r"(\w+)(?:\[(-?\d+)\])?(?:\.(\w+))?", field_name).groups()  # type: ignore[union-attr]
        try:
            value = kwargs[name] if index is None else kwargs[name][int(index)]
            value = getattr(value, method) if method else value
            return (value() if callable(value) else value), name
        except (IndexError, ValueError):
            return math.nan, name

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return a number, text or array in words."""
        return ", ".join("none" if one != one else format(one, format_spec) for one in np.ravel(value).tolist())


def _filled(words: str, numbers: Mapping[str, Any]) -> str:
    return _Words().vformat(words, (), numbers)


def read_checks(path: str | os.PathLike[str]) -> list[tuple[str, Check]]:
    """Read a file of checks: pairs (figure, check), the figure from the record or else from the name of the file.

    Raises ``InputError``, with the remedy, if the file is missing or damaged.
    """
    try:
        records = json.loads(Path(path).read_text(encoding="utf-8"))
        return [(record.pop("figure", Path(path).stem), Check.from_json(record)) for record in records]
    except OSError as error:
        raise InputError(f"Cannot read {path}: {error.strerror}.") from None
    except (ValueError, TypeError, AttributeError):
        raise InputError(f"{path} is not a readable file of checks; make it again.") from None


def read_statements(path: str | os.PathLike[str], run: NamedChecks | None = None) -> Statements:
    """Read the list and return its entries by verdict: ``correction``, ``id`` (checked), ``input``, ``unchecked``.

    If the checks of a ``run`` are given, an entry has those that cover it as ``by``, and is ``left`` if none does.
    """
    statements: Statements = {verdict: [] for verdict in _VERDICTS}
    for entry in read_yaml(str(path))["entries"]:
        verdict, id = next((v for v in _VERDICTS if v in entry), "id"), entry.get("id", entry.get("check"))
        by = [check for figure, check in run or () if check.id == id and entry.get("figure", figure) == figure]
        statements["left" if run is not None and id and not by else verdict].append({**entry, "by": by})
    return statements


def counted(statements: Statements) -> str:
    """Return in one sentence how many numbers and claims the chapter states, and how many of them have each verdict."""

    def both(entries: Iterable[dict[str, Any]]) -> str:
        found = Counter("numbers" if "value" in entry else "claims" for entry in entries)
        return " and ".join(f"{found[k]} {k[:-1] if found[k] == 1 else k}" for k in ("numbers", "claims") if found[k])

    order = [verdict for verdict in ("input", "id", "correction", "left", "unchecked") if statements[verdict]]
    *parts, last = (f"{both(statements[v])} {_VERDICTS[v].format(kinds(statements))}" for v in order)
    return f"Of the chapter's {both(chain(*statements.values()))}, {', '.join(parts)}, and {last}."


def kinds(statements: Statements) -> str:
    """Return how many statements of the chapter need a correction of which kind, such as "misprint 7, …"."""
    found = Counter(kind for entry in statements["correction"] for kind in entry["correction"])
    return ", ".join(f"{kind} {n}" for kind, n in found.most_common())


def verdict(checks: NamedChecks) -> str:
    """Return one line: how many checks passed, and in which figures some failed."""
    failed = [figure for figure, check in checks if not check.passed]
    if not failed:
        return f"All {len(checks)} checks passed."
    return f"{len(failed)} of {len(checks)} checks FAILED: {', '.join(dict.fromkeys(failed))}."


def failures(checks: NamedChecks) -> list[str]:
    """Return one sentence for each check that failed."""
    return [f"{figure}: {check.sentence()}" for figure, check in checks if not check.passed]


def printed_thresholds(checks: NamedChecks) -> list[str]:
    """Return a line for each threshold that the chapter prints, as far as it is among the checks: printed, computed."""
    lines = []
    for name, id in chapter.THRESHOLDS.items():
        for figure, check in ((figure, check) for figure, check in checks if check.id == id):
            words = f"{name.replace('_', ' '):18} printed {check.aim():8}"
            computed = f"computed {quantity(check.computed, check.unit):10}"
            lines.append(f"{words} {computed} error {percent(check.error):8} {figure}")
    return lines


def counts(checks: NamedChecks) -> str:
    """Return how many checks passed in which figures, in lines of at most 120 columns."""
    passed: dict[str, list[bool]] = {}
    for figure, check in checks:
        passed.setdefault(figure, []).append(check.passed)
    parts = [f"{figure} {sum(found)}/{len(found)}" for figure, found in passed.items()]
    return "\n".join(textwrap.wrap(f"Passed: {', '.join(parts)}.", 120, break_on_hyphens=False))


def percent(error: float | None) -> str:
    """Return a relative error in per cent, a dash if there is none."""
    return "-" if error is None else f"{100 * error:.2g} %"


def quantity(value: float | str, unit: str | None) -> str:
    """Return a value with its unit as text."""
    return text(value) if unit in (None, "1") or value != value else f"{text(value)} {unit}"


def text(value: float | str | None) -> str:
    """Return a value as text, numbers with six digits, NaN as "none"."""
    return "none" if value != value else f"{value:.6g}" if isinstance(value, float) else str(value)


def printed(checks: NamedChecks) -> list[tuple[str, Check]]:
    """Return those of some checks whose number the chapter prints, the thresholds first."""
    return [pair for claim in chapter.printed() for pair in checks if pair[1].id == claim.id]


def report(form: Literal["md", "rst"], checks: NamedChecks, statements: Statements | None = None) -> str:
    """Return checks in one of two forms.

    ``md``: Markdown that reads well as text. First how many ``statements`` of the chapter have which verdict, if these
    are given, and a table of the numbers that it prints, if some are among the checks; then for each figure how many
    passed, and a line for each of them. ``rst``: the table of printed numbers in reStructuredText, for a report.
    """
    from jinja2 import Environment, PackageLoader

    pages = Environment(loader=PackageLoader("lsvib.chapter", "."), trim_blocks=True)
    pages.filters["flat"] = lambda words: " ".join(words.split())
    pages.filters["literal"] = lambda words: re.sub(r"([*`|_\\])", r"\\\1", words)  # no character means but itself
    return pages.get_template(f"checks.{form}.j2").render(
        verdict=verdict(checks),
        printed=[(figure, check, _cells(figure, check)) for figure, check in printed(checks)],
        every=checks,
        statements=statements,
        counted=counted(statements) if statements else "",
        figures=dict.fromkeys(figure for figure, _ in checks),
    )


def _cells(figure: str, check: Check) -> list[str]:
    """What was expected and computed, the error and the largest allowed, the verdict or correction, the figure."""
    values = [" ".join(value.split()) for value in (check.aim(), quantity(check.computed, check.unit))]
    verdict = next(iter(claims()[check.id].correction), "pass") if check.passed else "FAIL"
    return [*values, percent(check.error), percent(check.tolerance), verdict, figure]
