"""What only shows when all is in place: stacks against grips, fasteners and parts in each other."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planners.arrays import Array
from robots.broad_phase import overlapping_boxes
from robots.panel import Fastener, Part, Stack
from robots.panel_fasteners import Candidate
from robots.panel_members import Members
from robots.panel_reading import Findings
from robots.piercing import find_piercings
from robots.schema_problems import Keys
from robots.stack import find_stacks

#: Grip and stack may differ by this much [m].
GRIP_TOLERANCE = 0.3e-3
#: A stack thicker than this many diameters is not one: the axis runs along a web.
_THICKEST = 10.0
#: Fasteners in each other beyond this number have one cause.
_MOST_CLOSE = 1_000_000
#: Points of a hole's rim whose stacks are compared with the one on its axis.
_RIM = 8
#: Where a hole that is there already ends, in diameters from the axis: it is wider than the shank by less.
_BEYOND = 0.75
#: The process that needs nothing to join.
DRILL_ONLY = "drill_only"


@dataclass(frozen=True)
class _Fault:
    """What is wrong with one fastener's stack; faults of one row are told once, at `keys`."""

    keys: Keys
    code: str
    message: str
    value: float | str
    remedy: str


def stacked(
    candidates: Sequence[Candidate], members: Members, pierced: Collection[str], findings: Findings
) -> tuple[tuple[Fastener, ...], tuple[Stack, ...]]:
    """Fasteners with their grip, and their stacks; faults go to `findings`. pierced: parts in each other."""
    if not candidates or not members.parts:
        return (), ()
    points = np.array([c.fastener.p for c in candidates])
    normals = np.array([c.fastener.n for c in candidates])
    parts = tuple(members.parts)
    stacks = find_stacks(parts, points, normals)
    rims = find_stacks(parts, *_rims(candidates, points, normals))
    if any(part.is_mesh for part in parts):
        stacks, rims = _around_holes(candidates, parts, stacks, rims)
    faults: dict[tuple[Keys, str], list[_Fault]] = {}
    fasteners = []
    for position, (candidate, stack) in enumerate(zip(candidates, stacks, strict=True)):
        fault = _fault(candidate, stack)
        if fault is None:
            rim = rims[_RIM * position : _RIM * (position + 1)]
            fault = _rim_fault(candidate, stack, rim, pierced)
        if fault is not None and (members.complete or candidate.fastener.member is not None):
            fault = replace(fault, remedy=candidate.hint + fault.remedy)
            faults.setdefault((fault.keys, fault.code), []).append(fault)
        grip = stack.grip if candidate.grip is None else candidate.grip
        fasteners.append(replace(candidate.fastener, grip=grip))
    for first, *others in faults.values():
        more = f", and {len(others)} more of this row likewise" if others else ""
        findings.add(first.keys, first.code, first.message + more, first.value, first.remedy)
    return tuple(fasteners), tuple(stacks)


def _fault(candidate: Candidate, stack: Stack) -> _Fault | None:
    """What is wrong with one stack, or None."""
    fastener, keys = candidate.fastener, candidate.keys
    parts = ", ".join(stack.parts) or "no part"
    name, through = f"fastener {fastener.id!r}", f"it goes through {parts}"
    if fastener.member is not None and fastener.member not in stack.parts:
        remedy = "Move the line onto the foot, skip that zone, or narrow a foot the skin curves away from."
        return _Fault(keys, "misses_member", f"{name} misses its member: {through}", fastener.id, remedy)
    if len(stack.parts) < 2 and fastener.process != DRILL_ONLY:
        remedy = f"Move it over a member, or use the process {DRILL_ONLY}."
        return _Fault(keys, "nothing_to_join", f"{name} has nothing to join: {through}", parts, remedy)
    true = round(1000.0 * stack.grip, 2)
    if stack.grip > _THICKEST * fastener.diameter:
        message = f"{name} would go through {true} mm of {parts}"
        return _Fault(keys, "stack_too_thick", message, true, "Move it off the web.")
    if candidate.grip is not None and abs(candidate.grip - stack.grip) > GRIP_TOLERANCE:
        stated = round(1000.0 * candidate.grip, 4)
        message = f"{name} has a grip of {stated} mm, but {parts} are {true} mm thick"
        remedy = f"Use a grip of {true} mm, or from_stack."
        return _Fault((*keys[:2], "grip_mm"), "grip_mismatch", message, stated, remedy)
    return None


def _around_holes(
    candidates: Sequence[Candidate], parts: tuple[Part, ...], stacks: list[Stack], rims: list[Stack]
) -> tuple[list[Stack], list[Stack]]:
    """The stacks, and those at the rims, where a CAD part may have the fastener's hole already.

    Such a part is not on the axis, but all round it: where the ring beyond the hole has one stack, and that
    has more to join than the axis, it is the fastener's.
    """
    _, normals, around = rings(candidates)
    found = find_stacks(parts, around.reshape(-1, 3), np.repeat(normals, _RIM, axis=0))
    stacks, rims = list(stacks), list(rims)
    for position, stack in enumerate(stacks):
        ring = slice(_RIM * position, _RIM * (position + 1))
        first, *others = found[ring]
        even = all(o.parts == first.parts and abs(o.grip - first.grip) <= GRIP_TOLERANCE for o in others)
        if even and first.grip > stack.grip + GRIP_TOLERANCE and {*stack.parts} <= {*first.parts}:
            stacks[position], rims[ring] = first, found[ring]
    return stacks, rims


def rings(candidates: Sequence[Candidate]) -> tuple[Array, Array, Array]:
    """Points (F, 3) of fasteners, normals (F, 3), and points around each beyond its hole, (F, _RIM, 3)."""
    points = np.array([c.fastener.p for c in candidates]).reshape(-1, 3)
    normals = np.array([c.fastener.n for c in candidates]).reshape(-1, 3)
    around, _ = _rims(candidates, points, normals, _BEYOND)
    return points, normals, around.reshape(-1, _RIM, 3)


def _rims(
    candidates: Sequence[Candidate], points: Array, normals: Array, share: float = 0.5
) -> tuple[Array, Array]:
    """Points around all fasteners (F * _RIM, 3), those of one together, and their normals.

    share: of the diameter, how far from the axis; a half is the rim of the hole.
    """
    radii = np.array([share * c.fastener.diameter for c in candidates])
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]  # the axis least along each normal
    first = np.cross(normals, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    turns = np.linspace(0.0, 2.0 * np.pi, _RIM, endpoint=False)[:, None]
    around = np.cos(turns) * first[:, None] + np.sin(turns) * np.cross(normals, first)[:, None]
    rims: Array = points[:, None] + radii[:, None, None] * around
    return rims.reshape(-1, 3), np.repeat(normals, _RIM, axis=0)


def _rim_fault(
    candidate: Candidate, stack: Stack, rim: Sequence[Stack], pierced: Collection[str]
) -> _Fault | None:
    """A hole must have the same stack all round: else it cuts a web, or runs over an edge.

    Where parts pierce each other, which is reported by itself, a stack says nothing.
    """
    for other in rim:
        same = set(other.parts) == set(stack.parts) and abs(other.grip - stack.grip) <= GRIP_TOLERANCE
        if not same and not {*stack.parts, *other.parts} & set(pierced):
            name, change = candidate.fastener.id, f"{_told(stack)} on its axis, {_told(other)} at its rim"
            message = f"the stack changes within the hole of fastener {name!r}: {change}"
            remedy = "Move it off the web or the edge; two diameters are the usual distance."
            return _Fault(candidate.keys, "uneven_stack", message, name, remedy)
    return None


def _told(stack: Stack) -> str:
    return f"{1000.0 * stack.grip:.2f} mm ({', '.join(stack.parts)})" if stack.parts else "no part"


def check_spacing(candidates: Sequence[Candidate], findings: Findings) -> None:
    """Find fasteners whose holes run into each other, once per pair of places."""
    if not candidates:
        return
    points = np.array([c.fastener.p for c in candidates])
    radii = 0.5 * np.array([[c.fastener.diameter] for c in candidates])
    boxes = (points - radii, points + radii)
    i, j = overlapping_boxes(boxes, boxes, _MOST_CLOSE)
    i, j = i[i < j], j[i < j]
    apart = np.linalg.norm(points[i] - points[j], axis=1)
    close = apart < radii[i, 0] + radii[j, 0]
    seen = set()
    for a, b, distance in zip(i[close].tolist(), j[close].tolist(), apart[close].tolist(), strict=True):
        first, second = candidates[a], candidates[b]
        if (first.keys, second.keys) in seen:
            continue
        seen.add((first.keys, second.keys))
        ids = f"{second.fastener.id!r} and {first.fastener.id!r}"
        message = f"the holes of fasteners {ids} run into each other: {1000.0 * distance:.2f} mm apart"
        findings.add(
            second.keys, "fasteners_overlap", message, second.fastener.id, "Remove or move one of them."
        )


def check_piercing(members: Members, findings: Findings) -> frozenset[str]:
    """Find parts that pierce each other, at the place of the later one; return the ids of all of them."""
    parts = tuple(members.parts)
    pierced: set[str] = set()
    for piercing in find_piercings(parts) if parts else ():
        first, second = parts[piercing.first], parts[piercing.second]
        names = f"{second.kind} {second.id!r} pierces {first.kind} {first.id!r}"
        message = f"{names} by {1000.0 * piercing.depth:.2f} mm"
        remedy = "Move or shorten one of them, or give the frame a mouse hole or a standoff."
        findings.add(members.places[second.id], "parts_pierce", message, first.id, remedy)
        pierced |= {first.id, second.id}
    return frozenset(pierced)
