"""What a remedy changes, in the terms of the input documents, and the documents changed by it.

Nothing that is passed in is changed: each function answers with a copy.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from robots.strict_json import Document, pointer_to


@dataclass(frozen=True)
class UseDie:
    """Let the machine have this die of its library too.

    unbind: where the panel's document binds the fastener to another die (keys and indices); that becomes
    null. Empty where nothing does.
    """

    die_id: str
    unbind: tuple[str | int, ...] = ()


@dataclass(frozen=True)
class Adjust:
    """The panel's `adjustments` have this entry for the fastener, in place of one there may be.

    Arc lengths [mm] and angles [deg] as in the document.
    """

    fastener: str
    x_mm: float = 0.0
    arc_mm: float = 0.0
    tilt_x_deg: float = 0.0
    tilt_arc_deg: float = 0.0

    def entry(self) -> Document:
        """The entry of `adjustments`; what does not change is left out."""
        amounts = {name: getattr(self, name) for name in ("x_mm", "arc_mm", "tilt_x_deg", "tilt_arc_deg")}
        return {"fastener": self.fastener} | {name: value for name, value in amounts.items() if value != 0.0}


@dataclass(frozen=True)
class ShiftClip:
    """The panel's clip of that id stands at `arc_mm` [mm]."""

    clip: str
    arc_mm: float


@dataclass(frozen=True)
class AddDie:
    """The die library has one more die: `definition`, a whole entry of its `dies`; unbind: as in UseDie."""

    definition: Mapping[str, Any]
    unbind: tuple[str | int, ...] = ()


Edit = UseDie | Adjust | ShiftClip | AddDie


def changed_panel(edit: Edit, document: Mapping[str, Any]) -> Document:
    """The panel's document with the edit made; raises KeyError for a clip that is not there."""
    panel: Document = copy.deepcopy(dict(document))
    if isinstance(edit, Adjust):
        others = [each for each in document.get("adjustments", []) if each["fastener"] != edit.fastener]
        panel["adjustments"] = [*copy.deepcopy(others), edit.entry()]
    elif isinstance(edit, ShiftClip):
        _clip(panel, edit.clip)["arc_mm"] = edit.arc_mm
    elif edit.unbind:
        _release(panel, edit.unbind)
    return panel


def changed_dies(edit: Edit, library: Mapping[str, Any]) -> Document:
    """The die library's document with the edit made: a changed die is one more, the last."""
    changed: Document = copy.deepcopy(dict(library))
    if isinstance(edit, AddDie):
        changed["dies"] = [*copy.deepcopy(library["dies"]), copy.deepcopy(dict(edit.definition))]
    return changed


def told_unbind(keys: tuple[str | int, ...]) -> str:
    """JSON pointer of the field that becomes null; empty where none does."""
    return pointer_to(*keys)


def _clip(panel: Mapping[str, Any], clip: str) -> dict[str, Any]:
    for entry in panel.get("clips", []):
        if entry["id"] == clip:
            found: dict[str, Any] = entry
            return found
    raise KeyError(f"no clip {clip!r} in the panel")


def _release(panel: Any, keys: tuple[str | int, ...]) -> None:
    here = panel
    for key in keys[:-1]:
        here = here[key]
    here[keys[-1]] = None
