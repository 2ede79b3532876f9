"""Why a fastener is not installed, in words: the best any die could do, what blocks it and by how much."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from robots.nc import NcReason
from robots.panel import Fastener
from robots.stations import Refusal

_MM = 1e3
_DEGREE_AXES = ("A", "B", "C")


def reason_for(
    fastener: Fastener, refusals: Sequence[Refusal]
) -> tuple[Literal["inaccessible", "deferred_manual"], NcReason]:
    """Status and reason of a fastener that no die installed; of several refusals the one that lacks least."""
    if not refusals:
        text = f"die {fastener.die} was not offered" if fastener.die else "no die was offered"
        return "deferred_manual", NcReason(
            "die_not_offered", f"{text}: name it among the dies of the request"
        )
    best = min(refusals, key=lambda refusal: refusal.lack)
    if best.no_path:
        return "deferred_manual", _no_path(best)
    return "inaccessible", _out_of_limits(best) if best.out_of_limits else _blocked(best)


def _out_of_limits(refusal: Refusal) -> NcReason:
    out = refusal.out_of_limits
    if out is None:
        raise ValueError("the refusal has no axis")
    turns = out.axis in _DEGREE_AXES
    scale, unit = (180.0 / math.pi, "deg") if turns else (_MM, "mm")
    limit = out.lower if out.value < out.lower else out.upper
    would_need, ends_at = f"{scale * out.value:.1f} {unit}", f"{scale * limit:.1f} {unit}"
    return NcReason(
        code="axis_out_of_limits",
        text=f"axis {out.axis} would need {would_need}, its limit is {ends_at}",
        axis=out.axis,
        value=scale * out.value,
        limit=scale * limit,
    )


def _blocked(refusal: Refusal) -> NcReason:
    blockage = refusal.blockage
    if blockage is None:
        raise ValueError("the refusal has no blockage")
    angle = (
        "" if refusal.die_angle is None else f" at its best angle {math.degrees(refusal.die_angle):.0f} deg"
    )
    if blockage.lack <= 0.0:
        # Every gap alone is wide enough: a solid is inside a thick part, or the proof ends at its resolution.
        text = (
            f"with die {refusal.die_id}{angle}, {blockage.solid} cannot be proved clear of {blockage.other}"
        )
        return _with_blockage("die_blocked", text, refusal)
    gap = f"{_MM * blockage.gap:.1f} mm apart" if blockage.gap > 0.0 else "in collision"
    text = (
        f"with die {refusal.die_id}{angle}, {blockage.solid} and {blockage.other} are {gap}, "
        f"{_MM * blockage.needed:.1f} mm are needed"
    )
    return _with_blockage("die_blocked", text, refusal)


def _no_path(refusal: Refusal) -> NcReason:
    text = f"die {refusal.die_id} fits, but no collision-free way to it was found: {refusal.no_path}"
    blockage = refusal.blockage
    if blockage is not None:
        text += f"; {blockage.solid} and {blockage.other} halt the straight way"
    return _with_blockage("no_path", text, refusal)


def _with_blockage(code: str, text: str, refusal: Refusal) -> NcReason:
    blockage = refusal.blockage
    if blockage is None:
        return NcReason(code, text)
    return NcReason(
        code,
        text,
        solid=blockage.solid,
        part=blockage.other,
        clearance_mm=_MM * blockage.gap,
        needs_mm=_MM * blockage.needed,
    )
