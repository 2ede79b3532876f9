"""Remedies: the smallest changes after which a fastener that no die reaches is reached.

Searched on a grid of amounts that a shop would say (0.1 mm, 0.05 degrees, 1 mm for clips), and verified on it
by the very `reach` that found the fastener unreachable: a certified station, a certified way home and back.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from planners.detector import never
from robots.access.adjust_remedies import moves, tilts
from robots.access.clip_remedies import clips
from robots.access.die_remedies import lower, narrower, other_dies
from robots.access.panel_access import Desk, FastenerAccess
from robots.access.remedy import Limits, Remedies, Remedy, RemedyKind, Tried
from robots.access.remedy_case import Case, Stopped, Workshop
from robots.dies import Die

__all__ = ["Limits", "Remedies", "Remedy", "RemedyFinder", "RemedyKind", "Tried"]

_COST: dict[RemedyKind, int] = {
    "other_die": 0,
    "tilt": 1,
    "move_fastener": 2,
    "shift_clip": 3,
    "lower_die": 4,
    "narrower_die": 4,
}

_KINDS = (other_dies, tilts, moves, clips, lower, narrower)


class RemedyFinder:
    """Finds remedies for the fasteners of one panel; what it makes for one serves the next.

    desk: machine and panel. document: what the panel was loaded from. dies: those that were asked about, the
    first one preferred. Raises ValueError where `document` is not that of the desk's panel.
    """

    def __init__(
        self, desk: Desk, document: Mapping[str, Any], dies: Sequence[Die], limits: Limits | None = None
    ) -> None:
        self._workshop = Workshop(desk, document, dies, limits or Limits())

    def remedies(self, access: FastenerAccess, stop: Callable[[], bool] = never) -> Remedies | None:
        """The remedies for one fastener of the panel that none of the dies reaches; None when `stop` ended
        it.

        Raises ValueError for a fastener that is reached: it needs none.
        """
        if access.chosen is not None:
            raise ValueError(f"fastener {access.fastener.id} is reached: it needs no remedy")
        case = Case(self._workshop, access, stop)
        try:
            searched = [kind(case) for kind in _KINDS]
        except Stopped:
            return None
        found = [remedy for remedies, _ in searched for remedy in remedies]
        return Remedies(access.fastener.id, tuple(sorted(found, key=_rank)), tuple(t for _, t in searched))


def _rank(remedy: Remedy) -> tuple[int, float]:
    """By what it costs a shop, then by amount; what is equal stays in the order of the search."""
    return _COST[remedy.kind], remedy.amount
