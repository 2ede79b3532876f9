"""Remedies at a clip: the one that is in the way, shifted along its frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from robots.access.panel_access import Desk, FastenerAccess
from robots.access.remedy import Remedy, Tried
from robots.access.remedy_case import ROUNDING, Case, asked, first_success
from robots.access.remedy_edits import ShiftClip, changed_panel
from robots.access.smallest import Outcome, smallest
from robots.definition_file import meters
from robots.die_angles import free_angles
from robots.errors import InvalidInput
from robots.panel import Panel
from robots.panel_file import load_panel
from robots.strict_json import Document

_COARSE = 5
"""[mm] Shifts so far apart are tried first; each one is a panel made anew."""
_AROUND = 0.1
"""[m] Fasteners so near to a clip, before or after its shift, must stay reachable: farther than dies are
wide.
"""
_DIGITS = 6


def clips(case: Case) -> tuple[list[Remedy], Tried]:
    """The smallest shift each way of every clip that blocks the fastener at the best angle of a die."""
    limit_mm = case.shop.limits.clip_mm
    found = []
    in_the_way = _in_the_way(case)
    for clip in in_the_way:
        (entry,) = (entry for entry in case.shop.document["clips"] if entry["id"] == clip)
        for sense in (1, -1):
            shift = _Shift(case, clip, float(entry["arc_mm"]), sense)
            shifted = smallest(shift.asked, _COARSE, int(limit_mm + ROUNDING))
            if shifted is not None:
                amount, success = shifted
                towards = "+arc" if sense > 0 else "-arc"
                edit = shift.edit(amount)
                found.append(case.remedy("shift_clip", clip, towards, meters(amount), success, edit))
    skipped = "" if in_the_way else "no clip is in the way"
    return found, Tried("shift_clip", in_the_way, meters(limit_mm), len(found), skipped)


def _in_the_way(case: Case) -> tuple[str, ...]:
    """The clips that block, in the order of the dies; each once."""
    panel = case.shop.desk.panel
    blockages = [hindrance.blockage for _, hindrance in case.access.hindrances]
    others = [blockage.other for blockage in blockages if blockage is not None]
    return tuple(
        dict.fromkeys(
            other for other in others if other in panel.part_ids and panel.part(other).kind == "clip"
        )
    )


class _Shift:
    """One clip shifted one way."""

    def __init__(self, case: Case, clip: str, arc_mm: float, sense: int) -> None:
        self._case, self._clip, self._arc_mm, self._sense = case, clip, arc_mm, sense

    def edit(self, amount: int) -> ShiftClip:
        """The shift by that many [mm]."""
        return ShiftClip(self._clip, round(self._arc_mm + self._sense * amount, _DIGITS))

    def asked(self, amount: int) -> Outcome:
        """What becomes of the fastener; a failure, too, where another one would no longer be reached."""
        case, here = self._case, self._case.shop.desk
        document = changed_panel(self.edit(amount), case.shop.document)
        if not self._fits_alone(document):
            return Outcome()
        desk = self._loaded(document)
        if desk is None or [f.id for f in desk.panel.fasteners] != [f.id for f in here.panel.fasteners]:
            return Outcome()
        outcome = first_success(_each(case, desk, case.index))
        if outcome.success is not None and not self._others_stay(desk):
            return Outcome()
        return outcome

    def _fits_alone(self, document: Document) -> bool:
        """Whether a die fits where little more than the clip stands: where it does not, more parts are no
        help, and the whole panel need not be made anew.
        """
        desk = self._loaded(alone(document, self._clip, self._case.access))
        if desk is None:
            return False
        index = [f.id for f in desk.panel.fasteners].index(self._case.fastener.id)
        fastener, stack = desk.panel.fasteners[index], desk.panel.stacks[index]
        return any(len(free_angles(desk.at(die)[0], fastener, stack).fits) for die in self._case.usable)

    def _loaded(self, document: Document) -> Desk | None:
        here = self._case.shop.desk
        try:
            panel = load_panel(document, here.machine.processes.ids, here.panel)
        except InvalidInput:
            return None
        return Desk(here.machine, panel, here.seed, here.heuristics)

    def _others_stay(self, desk: Desk) -> bool:
        """Whether all fasteners about the clip that are reached now still are."""
        case, here = self._case, self._case.shop.desk
        near = _near(here.panel, self._clip) | _near(desk.panel, self._clip)
        others = sorted(near - {case.index})
        return all(_is_reached(case, desk, i) for i in others if _was_reached(case, i))


def alone(document: Mapping[str, Any], clip: str, access: FastenerAccess) -> Document:
    """The panel's document with one fastener's row on its member only, and of the free-standing parts with
    the clip, its frame, and what the fastener joins.
    """
    kept = {clip, *access.stack.parts}
    kept |= {entry["frame"] for entry in document["clips"] if entry["id"] in kept}
    parts = {
        name: [entry for entry in document.get(name, []) if entry["id"] in kept]
        for name in ("frames", "clips", "boxes", "extrusions")
    }
    of, name = access.fastener, access.fastener.id
    return {
        **document,
        **parts,
        "fasteners": [entry for entry in document.get("fasteners", []) if entry["id"] == name],
        "rows": [{**row, "members": [of.member]} for row in document.get("rows", []) if row["id"] == of.row],
        "adjustments": [each for each in document.get("adjustments", []) if each["fastener"] == name],
    }


def _each(case: Case, desk: Desk, index: int) -> Iterator[Outcome]:
    """What each die does that may be used at fastener `index` of the desk's panel."""
    fastener, stack = desk.panel.fasteners[index], desk.panel.stacks[index]
    for die in case.shop.usable(fastener):
        yield asked(desk, desk.at(die)[0], index, case.stop, fastener, stack)


def _is_reached(case: Case, desk: Desk, index: int) -> bool:
    return first_success(_each(case, desk, index)).success is not None


def _was_reached(case: Case, index: int) -> bool:
    reached = case.shop.reached
    if index not in reached:
        reached[index] = _is_reached(case, case.shop.desk, index)
    return reached[index]


def _near(panel: Panel, clip: str) -> set[int]:
    """Places in the panel of the fasteners about a clip, its own among them."""
    corners = panel.part(clip).pieces.reshape(-1, 3)
    low, high = corners.min(axis=0) - _AROUND, corners.max(axis=0) + _AROUND
    points = np.array([fastener.p for fastener in panel.fasteners])
    return set(np.flatnonzero(np.all((points >= low) & (points <= high), axis=1)).tolist())
