"""Mending a body, and only what is asked for: a repair is a change of the part, and says what it changed.

In this order, whatever the order it was asked in: `merge` vertices that lie together, `drop` triangles that
close nothing, `orient` them out of the material, `fill` flat holes. Only `merge` moves anything, and nothing
by more than its tolerance. Where two ways of mending are possible the one that leaves more material is taken,
or none: the audit of the result tells what is still wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from planners.arrays import Array
from robots.errors import InputProblem, InvalidInput
from robots.meshes.audit import duplicates, inverted_pieces, no_area, volumes
from robots.meshes.audit_edges import Bools, Ints, components, edges_of, turned
from robots.meshes.audit_findings import counted
from robots.meshes.fill import filled
from robots.meshes.model import Body
from robots.meshes.soup import merged

Fix = Literal["merge", "drop", "orient", "fill"]

MOST_TOLERANCE = 1e-4
"""[m] By which vertices may be moved: well below the thickness of any sheet."""

_MOST_PAIRS = 5_000_000
"""Pairs of vertices that lie together; more are a tolerance beyond the size of the triangles."""


class Repaired(NamedTuple):
    """The mended body, and a sentence for everything that was done or was not possible."""

    body: Body
    done: tuple[str, ...]


def repair(
    body: Body, wanted: Sequence[Fix], *, tolerance: float = 1e-6, longest_rim: float = 0.05
) -> Repaired:
    """Mend a body. tolerance: by which `merge` may move a vertex [m], at most MOST_TOLERANCE. longest_rim:
    around a hole that `fill` closes [m]. Raises InvalidInput where the tolerance makes no sense for the body,
    or nothing would be left of it.
    """
    if not 0.0 < tolerance <= MOST_TOLERANCE:
        raise _too_large(tolerance)
    vertices, triangles, done = body.vertices, body.triangles, list[str]()
    if "merge" in wanted:
        vertices, triangles, said = _merged(vertices, triangles, tolerance)
        done.append(said)
    if "drop" in wanted:
        triangles, said = _dropped(vertices, triangles)
        done.append(said)
    if "orient" in wanted:
        triangles, said = _oriented(vertices, triangles)
        done.append(said)
    if "fill" in wanted:
        triangles, closed, notes = filled(vertices, triangles, longest_rim)
        done += notes
        if closed and "orient" in wanted:
            triangles, said = _oriented(vertices, triangles)
            done.append(said)
    if not len(triangles):
        message, remedy = f"nothing is left of the body {body.name!r} after this repair", "Export it again."
        raise InvalidInput([InputProblem("", "nothing_left", message, len(body.triangles), remedy)])
    vertices, triangles = merged(vertices, triangles)
    return Repaired(replace(body, vertices=vertices, triangles=triangles), tuple(done))


def _merged(vertices: Array, triangles: Ints, tolerance: float) -> tuple[Array, Ints, str]:
    """Put vertices that lie within the tolerance of one before at its place; drop what collapses.

    A vertex goes to one that itself stays, so it moves once, and not along a row of others.
    """
    tree = cKDTree(vertices)
    if tree.count_neighbors(tree, tolerance) > 2 * _MOST_PAIRS + len(vertices):
        raise _too_large(tolerance)
    pairs = tree.query_pairs(tolerance, output_type="ndarray")
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    onto = list(range(len(vertices)))
    for a, b in pairs.tolist():
        if onto[a] == a and onto[b] == b:
            onto[b] = a
    to = np.array(onto, dtype=np.int64)
    moved = np.flatnonzero(to != np.arange(len(to)))
    way = float(np.linalg.norm(vertices[moved] - vertices[to[moved]], axis=1).max(initial=0.0))
    before, after = _repeated(triangles), _repeated(to[triangles])
    collapsed = after & ~before
    said = f"merge: {counted(len(moved), 'vertex', 'vertices')} moved, by {1000.0 * way:.3g} mm at most"
    if collapsed.any():
        said += f"; {counted(int(collapsed.sum()), 'triangle')} collapsed and dropped"
    return vertices, to[triangles][~collapsed], said


def _dropped(vertices: Array, triangles: Ints) -> tuple[Ints, str]:
    """Drop triangles with a corner twice, copies that face the same way, and those without area.

    Of two that face each other none is dropped: they may be a sheet without thickness. Triangles without
    area stay where an edge would be open without them.
    """
    repeated = _repeated(triangles)
    kept = triangles[~repeated]
    first = np.argmin(kept, axis=1)
    turned_first = np.take_along_axis(kept, (first[:, None] + np.arange(3)) % 3, axis=1)
    copies = _later_copies(turned_first)
    kept = kept[~copies]
    flat = no_area(vertices[kept])
    needed = bool(flat.any()) and _unmatched(kept[~flat]) > _unmatched(kept)
    said = f"drop: {counted(int(repeated.sum()), 'triangle')} with a corner twice"
    said += f", {counted(int(copies.sum()), 'copy', 'copies')}"
    facing = int(duplicates(kept).sum())
    if needed:
        said += f"; {int(flat.sum())} without area kept, as they close edges"
    else:
        kept = kept[~flat]
        said += f", {int(flat.sum())} without area"
    if facing:
        said += f"; {facing} that lie on others but face the other way kept"
    return kept, said


def _oriented(vertices: Array, triangles: Ints) -> tuple[Ints, str]:
    """Turn triangles so that neighbours face the same side, and closed pieces outwards.

    A piece that faces inwards stays where it is a cavity in another's material.
    """
    edges = edges_of(triangles)
    turn, possible = turned(len(triangles), edges)
    if not possible:
        return triangles, "orient: nothing done, the surface has one side only"
    if not edges.count.size or not (edges.count == 2).all():
        said = f"orient: {counted(int(turn.sum()), 'triangle')} turned to face as their neighbours; which"
        return _turned(triangles, turn), said + " side is out is not known, as the body is not closed"
    corners = vertices[_turned(triangles, turn)]
    number, piece = components(len(triangles), edges)
    if float(volumes(corners, piece, number).sum()) < 0.0:
        turn = ~turn
    inwards = inverted_pieces(vertices[_turned(triangles, turn)], piece, number)
    while inwards.any():  # each round turns pieces outwards, and none back
        turn = turn ^ inwards[piece]
        inwards = inverted_pieces(vertices[_turned(triangles, turn)], piece, number)
    return _turned(triangles, turn), f"orient: {counted(int(turn.sum()), 'triangle')} turned"


def _turned(triangles: Ints, which: Bools) -> Ints:
    return np.where(which[:, None], triangles[:, ::-1], triangles)


def _repeated(triangles: Ints) -> Bools:
    found: Bools = (triangles == np.roll(triangles, -1, axis=1)).any(axis=1)
    return found


def _later_copies(triangles: Ints) -> Bools:
    _, first = np.unique(triangles, axis=0, return_index=True)
    found = np.ones(len(triangles), dtype=np.bool_)
    found[first] = False
    return found


def _unmatched(triangles: Ints) -> int:
    """Edges where not exactly two triangles meet."""
    return int((edges_of(triangles).count != 2).sum())


def _too_large(tolerance: float) -> InvalidInput:
    message = "the tolerance for merging vertices is no distance within which this body's vertices are few"
    remedy = f"Choose one above 0 and up to {1000.0 * MOST_TOLERANCE:g} mm, below the size of the triangles."
    return InvalidInput([InputProblem("", "merge_tolerance", message, 1000.0 * tolerance, remedy)])
