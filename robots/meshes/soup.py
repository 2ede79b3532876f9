"""Triangles as a file has them, before they are bodies: checked, in the file's own unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from robots.meshes.model import Body, Hole
from robots.meshes.refusals import MAX_TRIANGLES, refused, too_many, unreadable

MAX_BODIES = 10_000
_FARTHEST = 1e9  # of any unit: 1,000 km in mm, and far from where a sum of squares overflows
_NAME_CHARACTERS = 120


@dataclass(frozen=True, eq=False)
class Soup:
    """Vertices (V, 3) in the unit of the file, triangles (T, 3) of indices into them, holes and deviation."""

    name: str
    vertices: Array
    triangles: NDArray[np.int64]
    holes: tuple[Hole, ...] = ()
    deviation: float = 0.0


def check(soups: Sequence[Soup]) -> None:
    """Raise InvalidInput unless there are triangles, whose indices and coordinates make sense."""
    count = sum(len(soup.triangles) for soup in soups)
    if count == 0:
        message = "the file has no triangles"
        raise refused("no_triangles", message, "Export surfaces or solids, not points and lines.", value=0)
    if count > MAX_TRIANGLES:
        raise too_many(count)
    if len(soups) > MAX_BODIES:
        message = f"the file has {len(soups)} bodies; {MAX_BODIES} are the most that are read"
        raise refused("too_many_bodies", message, "Divide the assembly.", value=len(soups))
    for soup in soups:
        _check_indices(soup)
        _check_coordinates(soup)


def _check_indices(soup: Soup) -> None:
    if not len(soup.triangles):
        return
    low, high = int(soup.triangles.min()), int(soup.triangles.max())
    if low < 0 or high >= len(soup.vertices):
        wrong = low if low < 0 else high
        message = f"a triangle of {soup.name!r} uses vertex {wrong} of {len(soup.vertices)}"
        remedy = "Export the file again: it is damaged."
        raise refused("index_out_of_range", message, remedy, value=wrong)


def _check_coordinates(soup: Soup) -> None:
    used = soup.vertices[np.unique(soup.triangles)]
    if not np.isfinite(used).all():
        place = int(np.flatnonzero(~np.isfinite(used).all(axis=1))[0])
        message = f"a corner of a triangle of {soup.name!r} is not a number, or infinite"
        remedy = "Export the file again: it is damaged."
        raise refused("not_finite", message, remedy, value=repr(used[place].tolist()))
    farthest = float(np.abs(used).max(initial=0.0))
    if farthest > _FARTHEST:
        message = f"a coordinate of {soup.name!r} is {farthest:.3g}"
        raise refused("absurd_coordinate", message, "Export the file again: it is damaged.", value=farthest)


def extent(soups: Sequence[Soup]) -> Array:
    """Sizes (3,) of the box along the axes that holds every triangle, in the unit of the file."""
    corners = [soup.vertices[soup.triangles.ravel()] for soup in soups if len(soup.triangles)]
    low = np.min([each.min(axis=0) for each in corners], axis=0)
    high = np.max([each.max(axis=0) for each in corners], axis=0)
    sizes: Array = high - low
    return sizes


def to_bodies(soups: Sequence[Soup], scale: float) -> tuple[Body, ...]:
    """Bodies in metres, `scale` [m] being the unit of the file; each has a name of its own.

    Vertices at exactly the same place become one, so that it is known which triangles meet; triangles stay as
    they are, in their order: neither dropped nor mended.
    """
    names = _unique([soup.name for soup in soups if len(soup.triangles)])
    bodies = []
    for name, soup in zip(names, (each for each in soups if len(each.triangles)), strict=True):
        vertices, triangles = merged(soup.vertices, soup.triangles)
        bodies.append(Body(name, vertices * scale, triangles, soup.holes, soup.deviation))
    return tuple(bodies)


def merged(vertices: Array, triangles: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """The same triangles, on vertices that are all different and all used, in lexical order."""
    used, corners = np.unique(triangles, return_inverse=True)
    kept = vertices[used] + 0.0  # -0.0 is where 0.0 is
    order = np.lexsort(kept.T[::-1])
    ordered = kept[order]
    first = np.ones(len(kept), dtype=bool)
    first[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    new = np.empty(len(kept), dtype=np.int64)
    new[order] = np.cumsum(first) - 1
    return ordered[first], new[corners].reshape(-1, 3)


def _unique(names: Sequence[str]) -> list[str]:
    """Names fit to be shown, no two alike: the second "clip" is "clip (2)"."""
    taken: set[str] = set()
    found, counts = [], dict.fromkeys(names, 0)
    for name in names:
        plain = "".join(each if each.isprintable() else " " for each in name).strip()[:_NAME_CHARACTERS]
        plain = unique = plain or "body"
        counts[plain] = counts.get(plain, 0) + 1
        while unique in taken:
            unique = f"{plain} ({counts[plain]})" if counts[plain] > 1 else f"{plain} (2)"
            counts[plain] += 1
        taken.add(unique)
        found.append(unique)
    return found


def array(values: object, columns: int, what: str) -> Array:
    """`values` as an array (N, columns) of floats; raises InvalidInput."""
    try:
        found: Array = np.asarray(values, dtype=np.float64).reshape(-1, columns)
    except (ValueError, TypeError, OverflowError):
        raise unreadable(f"{what} are not rows of {columns} numbers") from None
    return found
