"""Fasteners as they would be if the panel's document adjusted them, without making the panel anew.

They are made by the very functions that load a panel, and pass the same checks; beyond those, a fastener that
is moved keeps its distance from its neighbours.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from pydantic import ValidationError

from planners.arrays import Array
from robots.access.remedy_edits import Adjust
from robots.contact import PanelPieces, panel_pieces
from robots.definition_file import canonical_json
from robots.panel import Fastener, Panel, Part, Stack
from robots.panel_adjustments import carried_out
from robots.panel_checks import stacked
from robots.panel_fasteners import Candidate, collect_fasteners
from robots.panel_members import Builder, Members
from robots.panel_reading import Findings, read_definition
from robots.panel_schema import AdjustmentDefinition

LEAST_PITCH = 3.0
"""Diameters between two fasteners (S = 3 D; Dakdouk 2016, appendix A): none is moved nearer to another."""

_DEEP = 0.16
"""[m] A stack is looked for within this distance of the fastener's point."""
_DIGITS = 6

_Amounts = tuple[float, float, float, float]
"""x, arc [mm], tilt_x, tilt_arc [deg]."""


@dataclass(frozen=True, eq=False)
class Trial:
    """A fastener that the panel would have, its stack, and the adjustment that makes it."""

    fastener: Fastener
    stack: Stack
    edit: Adjust


class PanelTrials:
    """Adjusted fasteners of one panel.

    document: what the panel was loaded from. Raises ValueError where it is not that.
    """

    def __init__(self, panel: Panel, document: Mapping[str, Any]) -> None:
        findings = Findings()
        reading = read_definition(dict(document), findings)
        if hashlib.sha256(canonical_json(reading.definition)).hexdigest() != panel.sha256:
            raise ValueError(f"this is not the document that panel {panel.id!r} was loaded from")
        self._members = Builder(reading, findings, panel).build()
        self._candidates = {c.fastener.id: c for c in collect_fasteners(reading, self._members, findings)}
        self._adjusted = {
            entry.fastener: Adjust(**entry.model_dump()) for entry in reading.definition.adjustments
        }
        self._panel, self._pieces = panel, panel_pieces(panel)
        self._points = np.array([f.p for f in panel.fasteners])
        self._diameters = np.array([f.diameter for f in panel.fasteners])
        self._of = -1
        self._made: dict[_Amounts, Trial | None] = {}

    def trial(
        self,
        index: int,
        *,
        x_mm: float = 0.0,
        arc_mm: float = 0.0,
        tilt_x_deg: float = 0.0,
        tilt_arc_deg: float = 0.0,
    ) -> Trial | None:
        """Fastener `index` of the panel adjusted by that much beyond what it is; None where a check says no.

        Its stack is known to the panel's cells as long as the fastener lives.
        """
        if self._of != index:
            self._of, self._made = index, {}
        by = (x_mm, arc_mm, tilt_x_deg, tilt_arc_deg)
        if by not in self._made:
            self._made[by] = self._trial(index, by)
        return self._made[by]

    def _trial(self, index: int, by: _Amounts) -> Trial | None:
        name = self._panel.fasteners[index].id
        before = self._adjusted.get(name, Adjust(name))
        amounts = (before.x_mm, before.arc_mm, before.tilt_x_deg, before.tilt_arc_deg)
        edit = Adjust(name, *(round(old + more, _DIGITS) for old, more in zip(amounts, by, strict=True)))
        try:
            entry = AdjustmentDefinition.model_validate(asdict(edit))
        except ValidationError:  # farther than an adjustment may go
            return None
        findings = Findings()
        candidate = carried_out(self._candidates[name], entry, self._members, (), findings)
        fasteners, stacks = stacked([candidate], self._around(candidate), (), findings)
        if findings.problems or not fasteners or self._crowded(index, fasteners[0]):
            return None
        self._pieces.try_out(fasteners[0], stacks[0])
        return Trial(fasteners[0], stacks[0], edit)

    def lean(self, fastener: Fastener) -> float:
        """Angle between a fastener's axis and the normal of the skin [rad]."""
        surface = self._members.surface
        true = surface.normal(*surface.locate(fastener.p)[:2])
        return math.atan2(float(np.linalg.norm(np.cross(true, fastener.n))), float(true @ fastener.n))

    def _around(self, candidate: Candidate) -> Members:
        """The members with the pieces near the fastener only: what its stack is found in."""
        return replace(self._members, parts=_near(self._panel, self._pieces, candidate.fastener.p))

    def _crowded(self, index: int, fastener: Fastener) -> bool:
        """Whether on its way it is nearer to another fastener than it should be and than it was: so none
        changes places with its neighbour.
        """
        at, way = self._points - self._points[index], fastener.p - self._points[index]
        length = float(way @ way)
        part = np.clip(at @ way / length, 0.0, 1.0) if length > 0.0 else np.zeros(len(at))
        wanted = LEAST_PITCH * np.maximum(self._diameters, fastener.diameter)
        before, apart = np.linalg.norm(at, axis=1), np.linalg.norm(at - part[:, None] * way, axis=1)
        near = apart < np.minimum(wanted, before)
        near[index] = False
        return bool(near.any())


def _near(panel: Panel, pieces: PanelPieces, p: Array) -> list[Part]:
    found = pieces.around(p - _DEEP, p + _DEEP)
    of_part = pieces.part_index[found]
    return [
        replace(panel.parts[k], pieces=pieces.pieces[found[of_part == k]])
        for k in np.unique(of_part).tolist()
    ]
