"""The rules by which motion goes on after a seizure, by name; :mod:`lsvib.models.rigid` says what they mean."""

from typing import Any, Literal, get_args

from lsvib.errors import InputError
from lsvib.numbers import shown

Resume = Literal["contact_sign", "at_once"]
RULES: tuple[Resume, ...] = get_args(Resume)  # the limit of a compliant contact, and the chapter's reading


def rule(given: Any) -> Resume:
    """Return a rule of resuming after a seizure; raises ``InputError`` for anything else."""
    for known in RULES:
        if isinstance(given, str) and given == known:
            return known
    raise InputError(f"resume = {shown(given)} is not one of {', '.join(RULES)}.")
