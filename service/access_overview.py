"""What the fasteners of a panel come to: counts, percentages and classes, by die, kind of part and part."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Sequence
from typing import TypeVar, get_args

from planners.accessibility.summary import AccessSummary
from robots.access.panel_access import FastenerAccess, PanelAccess, count, joining, part_of
from service.access_schemas import (
    AccessClass,
    AccessOverview,
    AccessShare,
    AccessWord,
    DieCounts,
    Joining,
    JoiningShares,
    KindShares,
    PartShare,
)

_Key = TypeVar("_Key", bound=Hashable)

_WORDS: dict[AccessClass | None, AccessWord | None] = {
    "accessible": "Accessible",
    "modify_tool": "Limited accessibility",
    "crowded": "Not accessible",
    None: None,
}
"""Dakdouk 2016, Table 3-4 states its words without percentages: here they are those of section 3.5."""

_JOININGS: tuple[Joining, ...] = get_args(Joining)


def overview(access: PanelAccess) -> AccessOverview:
    """Counts, status and class of the panel, and its rows in the manner of Dakdouk 2016, Table 3-4."""
    panel, summary = access.panel, _summary(access.fasteners)
    of_kind = _grouped(access, lambda each: panel.part(part_of(each, panel)).kind)
    of_part = _grouped(access, lambda each: (part_of(each, panel), joining(each, panel)))
    return AccessOverview(
        total=summary.total,
        **count(access.fasteners),
        percent=_percent(summary),
        status=summary.status,
        access_class=summary.access_class,
        dies=[_die_counts(place, die.id, access) for place, die in enumerate(access.dies)],
        panel=JoiningShares(**_by_joining(access.fasteners, access)),
        by_kind=[
            KindShares(kind=kind, **_by_joining(of_kind[kind], access))
            for kind in dict.fromkeys(part.kind for part in panel.parts)
            if kind in of_kind
        ],
        by_part=[
            PartShare(part=part.id, kind=part.kind, joining=joined, share=_share(of_part[part.id, joined]))
            for part in panel.parts
            for joined in _JOININGS
            if (part.id, joined) in of_part
        ],
    )


def _grouped(access: PanelAccess, key: Callable[[FastenerAccess], _Key]) -> dict[_Key, list[FastenerAccess]]:
    groups: defaultdict[_Key, list[FastenerAccess]] = defaultdict(list)
    for each in access.fasteners:
        groups[key(each)].append(each)
    return dict(groups)


def _by_joining(fasteners: Sequence[FastenerAccess], access: PanelAccess) -> dict[str, AccessShare | None]:
    those = {
        joined: [each for each in fasteners if joining(each, access.panel) == joined] for joined in _JOININGS
    }
    return {joined: _share(some) if some else None for joined, some in those.items()}


def _share(fasteners: Sequence[FastenerAccess]) -> AccessShare:
    summary = _summary(fasteners)
    return AccessShare(
        total=summary.total,
        accessible=summary.accomplished,
        percent=_percent(summary),
        access_class=summary.access_class,
        word=_WORDS[summary.access_class],
    )


def _summary(fasteners: Sequence[FastenerAccess]) -> AccessSummary:
    """As the thesis counts, which has one tool: another die is one more way to reach a rivet."""
    counts = count(fasteners)
    return AccessSummary(counts["direct"], counts["rotated"] + counts["other_die"], counts["inaccessible"])


def _percent(summary: AccessSummary) -> float | None:
    return None if summary.percent is None else round(summary.percent, 4)


def _die_counts(place: int, die_id: str, access: PanelAccess) -> DieCounts:
    reached = [each.reaches[place] for each in access.fasteners if each.reaches[place].ok]
    direct = sum(not each.turned for each in reached)
    return DieCounts(
        die=die_id,
        reached=len(reached),
        direct=direct,
        rotated=len(reached) - direct,
        chosen=sum(each.chosen is each.reaches[place] for each in access.fasteners),
    )
