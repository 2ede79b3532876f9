"""Fasteners from the holes that CAD parts have: those that go through the skin.

Holes of several bodies on one axis, one behind the other, are the hole of one fastener. Its point is where
the axis meets the outer face of the skin, as if there were no hole; its normal is the axis, outwards.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from planners.arrays import Array
from robots.errors import InputProblem, InvalidInput
from robots.fastener_lists.checks import too_close
from robots.fastener_lists.mapping import HoleDiameter, Mapping
from robots.fastener_lists.reading import FastenerList, LeftOut
from robots.fastener_lists.rows import LENGTH_DIGITS, Draft, entry_of, unit_vector
from robots.fastener_lists.skin import SkinView
from robots.fastener_lists.table import limited
from robots.meshes.model import Body
from robots.panel_fasteners import MAX_FASTENERS, OFF_NORMAL, OFF_SKIN
from robots.process_file import load_processes

#: Axes of holes of one fastener are nearer to each other than this [m], and turned by less [rad].
_ONE_AXIS = 0.2e-3
_ONE_DIRECTION = math.radians(0.5)
#: Sheets that are joined lie on each other but for this, of sealant and shims [m].
_GAP = 1.0e-3
#: How far an end of a hole may be from the face that it should reach, for tessellation [m].
_SHORT = 0.2e-3
#: Where the skin's outer face is asked for, in radii of the hole around its axis.
_AROUND = 2.0
_RING = np.array([[math.cos(turn), math.sin(turn)] for turn in np.arange(8) * math.pi / 4.0])


@dataclass(frozen=True, eq=False)
class _Holes:
    """All holes: the body of each, ends (H, 3) of their axes, the outer one first, and radii (H,) [m]."""

    bodies: tuple[str, ...]
    outer: Array
    inner: Array
    radii: Array


@dataclass(frozen=True, eq=False)
class _Drilled:
    """The holes on one axis.

    p, n: (3,), where it meets the outer face [m], and its direction, outwards. turn: from the skin's normal
    [rad]. off: how far a ring around p is from the outer face at most [m]. thickness: of the skin there [m].
    """

    members: NDArray[np.int64]
    p: Array
    n: Array
    turn: float
    off: float
    thickness: float


def from_holes(
    bodies: Sequence[Body], skin: SkinView, mapping: Mapping, processes: Collection[str] | None = None
) -> FastenerList:
    """Fasteners in the holes of `bodies`, in the order of x, then y, called H0001 and so on.

    mapping: its `holes` say which fastener goes into which hole, its defaults what else is known of them.
    processes: the names that there are; None means those of the default library. Holes that do not go through
    the skin, or that no fastener is said to be for, are left out, each with the reason. Raises InvalidInput.
    """
    _check(mapping, load_processes().ids if processes is None else processes)
    holes = _all_holes(bodies, skin)
    taken: list[tuple[tuple[float, ...], Draft]] = []
    left_out = []
    for drilled in _drilled(holes, skin):
        found = _fastener(holes, drilled, mapping)
        if isinstance(found, LeftOut):
            left_out.append(found)
        else:
            taken.append((tuple(found.point("design").round(3).tolist()), found))
    taken.sort(key=lambda each: each[0])
    drafts = [_named(draft, number) for number, (_, draft) in enumerate(taken, 1)]
    _check_found(drafts, left_out)
    entries = tuple(dict(entry_of(d, d.point("design"), np.asarray(d.n))) for d in drafts)
    told = (f"{len(drafts)} of {len(drafts) + len(left_out)} holes go through the skin and take a fastener",)
    return FastenerList(entries, tuple(d.place for d in drafts), {}, "m", told, tuple(left_out))


def _check(mapping: Mapping, processes: Collection[str]) -> None:
    process, problems = mapping.defaults.process, []
    if process is None:
        remedy = f'Add to the mapping: {{"defaults": {{"process": ...}}}}, one of: {", ".join(processes)}.'
        problems.append(InputProblem("/defaults", "no_process", "holes tell no process", None, remedy))
    elif process not in processes:
        message, remedy = f"there is no process {process!r}", f"Use one of: {', '.join(processes)}."
        problems.append(InputProblem("/defaults/process", "unknown_process", message, process, remedy))
    if not mapping.holes:
        message = "no fastener is said to be for any hole"
        remedy = 'Add to the mapping: {"holes": [{"hole_mm": 4.1, "diameter_mm": 4.0}]}.'
        problems.append(InputProblem("/holes", "no_diameter", message, None, remedy))
    if problems:
        raise InvalidInput(problems)


def _check_found(drafts: Sequence[Draft], left_out: Sequence[LeftOut]) -> None:
    if not drafts:
        why = left_out[0].reason if left_out else "the bodies have none"
        message = f"no hole is one for a fastener: {why}"
        remedy = "Name the skin that the holes go through, and the diameters of its holes."
        raise InvalidInput([InputProblem("", "no_fasteners", message, len(left_out), remedy)])
    if len(drafts) > MAX_FASTENERS:
        message = f"there are more than {MAX_FASTENERS} fasteners"
        raise InvalidInput([InputProblem("", "too_large", message, len(drafts), "Divide the panel.")])
    problems = list(too_close(drafts, np.array([draft.point("design") for draft in drafts])))
    if problems:
        raise InvalidInput(limited(problems))


def _all_holes(bodies: Sequence[Body], skin: SkinView) -> _Holes:
    each = [(body.name, hole) for body in bodies for hole in body.holes]
    ends = np.array([(hole.first, hole.last) for _, hole in each]).reshape(-1, 2, 3)
    facing = skin.outer_point(ends.mean(axis=1)).normals if len(each) else np.empty((0, 3))
    turned = np.einsum("hc,hc->h", ends[:, 1] - ends[:, 0], facing) > 0.0
    ends[turned] = ends[turned][:, ::-1]
    radii = np.array([hole.radius for _, hole in each])
    return _Holes(tuple(name for name, _ in each), ends[:, 0], ends[:, 1], radii)


def _groups(holes: _Holes) -> list[NDArray[np.int64]]:
    """Holes that are on one axis and follow each other, the outermost first."""
    total = len(holes.radii)
    if not total:
        return []
    middles = 0.5 * (holes.outer + holes.inner)
    longest = float(np.linalg.norm(holes.outer - holes.inner, axis=1).max())
    near = cKDTree(middles).query_pairs(longest + _GAP + _ONE_AXIS, output_type="ndarray")
    first, second = near[:, 0], near[:, 1]
    axes = holes.inner - holes.outer
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    a, b = axes[first], axes[second]
    between = middles[second] - middles[first]
    along = np.einsum("pc,pc->p", between, a)
    aside = np.linalg.norm(between - along[:, None] * a, axis=1)
    turn = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("pc,pc->p", a, b))
    halves = 0.5 * np.linalg.norm(holes.outer - holes.inner, axis=1)
    gap = np.abs(along) - halves[first] - halves[second]
    one = (aside < _ONE_AXIS) & (turn < _ONE_DIRECTION) & (gap < _GAP)
    pairs = near[one]
    joined = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(total, total))
    count, labels = connected_components(joined, directed=False)
    order = np.argsort(labels, kind="stable")
    groups = np.split(order, np.searchsorted(labels[order], np.arange(1, count)))
    return [np.asarray(group, dtype=np.int64) for group in groups]


def _drilled(holes: _Holes, skin: SkinView) -> list[_Drilled]:
    """The holes of each axis, and how the skin is there."""
    groups = _groups(holes)
    if not groups:
        return []
    starts = np.array([holes.outer[members[0]] for members in groups])
    n = np.array([(holes.outer[members] - holes.inner[members]).sum(axis=0) for members in groups])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    rings = _rings(n, np.array([_AROUND * holes.radii[members].max() for members in groups]))
    on, shape = skin.outer_point((starts[:, None] + rings).reshape(-1, 3)), rings.shape
    middles, normals = (each.reshape(shape).mean(axis=1) for each in (on.points, on.normals))
    along = np.einsum("gc,gc->g", middles - starts, normals) / np.einsum("gc,gc->g", n, normals)
    p = starts + along[:, None] * n
    on = skin.outer_point((p[:, None] + rings).reshape(-1, 3))
    normals = on.normals.reshape(shape).mean(axis=1)
    turns = np.arctan2(np.linalg.norm(np.cross(normals, n), axis=1), np.einsum("gc,gc->g", normals, n))
    off = on.distances.reshape(shape[:2]).max(axis=1)
    thickness = skin.inner_distances(p)
    return [_Drilled(*each) for each in zip(groups, p, n, turns, off, thickness, strict=True)]


def _rings(n: Array, radii: Array) -> Array:
    """Points (G, 8, 3) around the origin, across directions (G, 3) and at distances (G,) from it."""
    least = np.eye(3)[np.abs(n).argmin(axis=1)]  # the axis least along each
    first = np.cross(n, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    rings: Array = np.einsum("kt,tgc->gkc", _RING, np.array([first, np.cross(n, first)]))
    return radii[:, None, None] * rings


def _fastener(holes: _Holes, drilled: _Drilled, mapping: Mapping) -> Draft | LeftOut:
    """The fastener of the holes on one axis, or why there is none."""
    members = drilled.members
    shown = ", ".join(dict.fromkeys(holes.bodies[i] for i in members))
    what = f"hole at {(1000.0 * drilled.p).round(2).tolist()} mm in {shown}"
    fault = _fault(holes, drilled)
    if fault is not None:
        return LeftOut(what, *fault)
    sizes = (2000.0 * holes.radii[members]).tolist()
    fits = [next((hole.diameter_mm for hole in mapping.holes if _fits(size, hole)), None) for size in sizes]
    if None in fits:
        size = sizes[fits.index(None)]
        return LeftOut(what, "no_diameter", f"no fastener is said to be for a hole of {size:.3f} mm")
    if len(set(fits)) > 1:
        told = " and ".join(f"{each:g}" for each in dict.fromkeys(fits) if each is not None)
        return LeftOut(what, "mixed_diameters", f"its pieces are for fasteners of {told} mm")
    defaults = mapping.defaults
    values = {
        "diameter_mm": fits[0],
        "grip_mm": defaults.grip_mm or "from_stack",
        **{name: getattr(defaults, name) for name in ("process", "die", "code")},
    }
    point = np.round(1000.0 * drilled.p, LENGTH_DIGITS)
    return Draft(f"/holes/{int(members.min())}", values, point, None, unit_vector(drilled.n))


def _fault(holes: _Holes, drilled: _Drilled) -> tuple[str, str] | None:
    """Why a hole is none of a fastener through the skin: a code and a reason."""
    p, n, thickness = drilled.p, drilled.n, drilled.thickness
    begins = float(((p - holes.outer[drilled.members]) @ n).min())
    ends = float(((p - holes.inner[drilled.members]) @ n).max())
    if drilled.off > OFF_SKIN:
        return "off_skin", "its axis does not meet the outer face of the skin, or too near to an edge"
    if begins > thickness - _SHORT:
        return "not_in_skin", f"it begins {1000.0 * begins:.2f} mm below the outer face, not in the skin"
    if ends < thickness - _SHORT:
        return (
            "blind",
            f"it ends {1000.0 * ends:.2f} mm below the outer face of {1000.0 * thickness:.2f} mm of skin",
        )
    if drilled.turn > OFF_NORMAL:
        return "tilted", f"its axis is {math.degrees(drilled.turn):.2f} degrees off the skin's normal"
    return None


def _fits(size: float, hole: HoleDiameter) -> bool:
    return abs(size - hole.hole_mm) <= hole.tolerance_mm + 1e-9


def _named(draft: Draft, number: int) -> Draft:
    return Draft(draft.place, {"id": f"H{number:04d}", **draft.values}, draft.design, None, draft.n)


def by_reason(left_out: Sequence[LeftOut]) -> Iterator[tuple[str, int, LeftOut]]:
    """Reasons why something was left out: code, how often, and the first of them."""
    codes = dict.fromkeys(each.code for each in left_out)
    for code in codes:
        those = [each for each in left_out if each.code == code]
        yield code, len(those), those[0]
