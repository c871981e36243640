"""Drives with a part, whose parameters are those of the chapter's examples where none are given."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lsvib.models import chapter
from lsvib.models.drive import PART_OF, PARTS, Drive


@dataclass(frozen=True)
class Kind:
    """Makes the drives with one ``part``, or the rigid ones."""

    part: str

    def __call__(self, values: Drive | Mapping[str, Any] | None = None, /, **more: Any) -> Drive:
        return Drive.of({**chapter.PARTS.get(self.part, {}), **dict(values or {}), **more})

    of = __call__

    @property
    def parameters(self) -> tuple[str, ...]:
        return tuple(name for name in Drive.model_fields if PART_OF.get(name, self.part) == self.part)

    @property
    def damper(self) -> str:
        """Name of the damping that the part adds."""
        return PARTS[self.part][-1]

    @property
    def given(self) -> tuple[str, ...]:
        """The part in the words of a command."""
        values = chapter.PARTS.get(self.part, {})
        return tuple(word for name, value in values.items() for word in ("--set", f"{name}={value!r}"))


DRIVES = {name: Kind(name) for name in ("rigid", "threads", "support", "nut")}
rigid_drive, threads_drive, support_drive, nut_drive = DRIVES.values()
GIVEN = {name: kind.given for name, kind in DRIVES.items()}


def name_of(drive: Drive) -> str:
    """Name of the kind of a drive with one part at most."""
    return drive.parts[0] if drive.parts else "rigid"
