"""The difference of two programs: the fasteners, members and links that are not as before, and why."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from robots.cell import Blockage
from robots.nc import NcFastener, NcHeader
from robots.nc_changes import NcChanges, NcFastenerChange, NcLinkChange, NcMemberChange
from robots.outline import Between, Outline

Blocked = Mapping[tuple[str, Between], Blockage]
"""What is in the way of previous links, by die and ends."""

_SAME_MM = 2e-4
"""Of points in two texts: a digit each of three coordinates is no move."""


_SAME_GRIP_MM = 0.001
_SAME_AXIS = 1e-7


def other_settings(old: NcHeader, new: NcHeader) -> str | None:
    """Why nothing of one program may be kept in another; None where both were planned with the same means."""
    if old.planner != new.planner:
        a, b = (f"{each.name} {each.version} with seed {each.seed}" for each in (old.planner, new.planner))
        return f"the previous program was planned by {a}, this one by {b}"
    for name, what in (("machine", "machine"), ("dies", "dies"), ("process", "processes")):
        a, b = getattr(old.inputs, name), getattr(new.inputs, name)
        if a != b:
            stated = f"{a.id} ({a.sha256[:12]}), this one for {b.id} ({b.sha256[:12]})"
            return f"the previous program was planned for other {what}: {stated}"
    if old.inputs.approach != new.inputs.approach:
        return "the previous program was planned with another approach order"
    return None


def changes(old: Outline, new: Outline, everything: str | None, blocked: Blocked) -> NcChanges:
    """What became of `old` in `new`. everything: why nothing was kept. blocked: as planning found out."""
    fasteners = {each.id: each for each in _fasteners(old, new)}
    links = _Links(old, new, fasteners, blocked)
    found = list(links.changed())
    members = () if everything else tuple(_members(old, new, fasteners, blocked))
    return NcChanges(
        everything=everything,
        fasteners=tuple(fasteners.values()),
        members=members,
        links=() if everything else tuple(found),
        kept_links=links.kept,
        cycle_time_s=new.cycle_time_s - old.cycle_time_s,
    )


def _fasteners(old: Outline, new: Outline) -> Iterator[NcFastenerChange]:
    """In the order of the new program, those that are gone last."""
    before, now = ({each.id: each for each in outline.fasteners} for outline in (old, new))
    for each in new.fasteners:
        if each.id not in before:
            yield NcFastenerChange(each.id, "added", f"{each.id} is new")
            continue
        moved = math.dist(before[each.id].p_mm, each.p_mm)
        others = list(_others(before[each.id], each))
        if moved > _SAME_MM:
            text = ", ".join([f"{each.id} moved by {moved:.3f} mm", *others])
            yield NcFastenerChange(each.id, "moved", text)
        elif others:
            yield NcFastenerChange(each.id, "changed", f"{each.id}: {', '.join(others)}")
    for each in old.fasteners:
        if each.id not in now:
            yield NcFastenerChange(each.id, "removed", f"{each.id} is gone")


def _others(a: NcFastener, b: NcFastener) -> Iterator[str]:
    """What else differs of one fastener."""
    if math.dist(a.n, b.n) > _SAME_AXIS and math.dist(a.p_mm, b.p_mm) <= _SAME_MM:
        yield "its axis is turned"
    if a.stack != b.stack:
        yield f"its stack was {' '.join(a.stack)} and is {' '.join(b.stack)}"
    for name, was, is_now in (("diameter", a.diameter_mm, b.diameter_mm), ("grip", a.grip_mm, b.grip_mm)):
        if abs(was - is_now) > _SAME_GRIP_MM:
            yield f"its {name} was {was:g} mm and is {is_now:g} mm"
    for name, fate, fate_now in (("status", a.status, b.status), ("die", a.die_id, b.die_id)):
        if fate != fate_now:
            yield f"its {name} was {fate} and is {fate_now}"


def _members(
    old: Outline, new: Outline, fasteners: Mapping[str, NcFastenerChange], blocked: Blocked
) -> Iterator[NcMemberChange]:
    """Parts of which half of the fasteners or more are others, and parts in the way, in the order of their
    names.
    """
    before, now = _joined_by(old), _joined_by(new)
    in_the_way = [blockage.other for blockage in blocked.values()]
    for part in sorted(before.keys() | now.keys() | set(in_the_way)):
        ids = dict.fromkeys([*before.get(part, ()), *now.get(part, ())])
        touched = [fasteners[name].what for name in ids if name in fasteners]
        texts = []
        if part not in before and part in now:
            texts.append("joined by no fastener before")
        elif part in before and part not in now:
            texts.append("joined by no fastener any more")
        elif 2 * len(touched) >= len(ids) and touched:
            texts.append(f"{len(touched)} of its {len(ids)} fasteners are others or elsewhere")
        if part in in_the_way:
            texts.append(f"in the way of previous links: {in_the_way.count(part)}")
        if texts:
            yield NcMemberChange(part, "; ".join(texts))


def _joined_by(outline: Outline) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for fastener in outline.fasteners:
        for part in fastener.stack:
            found.setdefault(part, []).append(fastener.id)
    return found


@dataclass(eq=False)
class _Links:
    """Compares the links of two programs; `kept` counts those with the same axis values."""

    old: Outline
    new: Outline
    fasteners: Mapping[str, NcFastenerChange]
    blocked: Blocked
    kept: int = 0
    _came_from: dict[str, str | None] = field(default_factory=dict)

    def changed(self) -> Iterator[NcLinkChange]:
        """The links of the new program that are not as before, in its order."""
        for each in self.old.passes.values():
            self._came_from.update({leads: leaves for leaves, leads in each.ways if leads is not None})
        for die_id, now in self.new.passes.items():
            before = self.old.passes.get(die_id)
            for ends, way in now.ways.items():
                stations = [name for name in ends if name is not None]
                if (
                    before is not None
                    and before.ways.get(ends) == way
                    and all(before.stations.get(name) == now.stations.get(name) for name in stations)
                ):
                    self.kept += 1
                else:
                    yield NcLinkChange(die_id, *ends, self._why(die_id, ends))

    def _why(self, die_id: str, ends: Between) -> str:
        for name in reversed(ends):
            if name is not None and name in self.fasteners:
                return self.fasteners[name].text
        blockage = self.blocked.get((die_id, ends))
        if blockage is not None:
            gap, needed = 1e3 * blockage.gap, 1e3 * blockage.needed
            return f"{blockage.solid} is {gap:.3f} mm from {blockage.other} now, needs {needed:.3f} mm"
        before = self.old.passes.get(die_id)
        if before is None or ends not in before.ways:
            was = self._came_from.get(ends[1] or "") or "home"
            fate = (
                self.fasteners[was].text if was in self.fasteners else f"{ends[1] or 'home'} came after {was}"
            )
            return f"there was no such link: {fate}"
        return "what stands around it changed: the die stands or moves otherwise"
