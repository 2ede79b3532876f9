"""Covering straight motions with separating planes: the part of the verifier that proves clearances.

An item is a stretch [s0, s1] of one block against one obstacle. It is proven when some direction d, fixed
over the stretch, parts the two by the required clearance at both ends, with the bulge of the motion in
between subtracted (`verify_kinematics`). Items that fail with cheap directions get the direction of their
nearest points; items that still fail are halved. What is closer than required at the middle of a stretch is a
violation, measured there.

Nothing here knows what the obstacle is: `Problem` places the pair.
"""

from dataclasses import dataclass
from itertools import count
from typing import Protocol

import numpy as np

from planners.arrays import Array
from robots.closest import closest
from robots.separation import Bodies, IntArray, Mask, gap

TOLERANCE = 1e-6
"""[m] What rounding the NC program may spend: 1e-4 mm and 1e-6 deg at a lever of 4 m, and the arithmetic."""
RESOLUTION = 2e-5
"""[m] A stretch that moves less than this and is still not proven counts as a violation."""
SHARPNESS = 5e-4
"""[m] The stated clearance of a block is at most this much below the true one."""
_BATCH = 20_000
_OVERLAP = 1e-9  # [m] nearest points this close are rounding: the bodies overlap
_SINGLE = 3  # rounds in which only the lowest item of each block is sharpened
_SAMPLES = 33  # of a block, to find where a violation is worst
_MEASURED = 500  # violations that are measured so; a program this wrong needs no more


@dataclass(frozen=True, eq=False)
class Items:
    """Stretches against obstacles, each field (P,): block row, s0, s1, obstacle, proven gap (a bound) [m]."""

    block: IntArray
    s0: Array
    s1: Array
    piece: IntArray
    bound: Array

    def __len__(self) -> int:
        return len(self.block)

    def take(self, which: Mask | IntArray | slice) -> "Items":
        """The items at an index or mask."""
        return Items(self.block[which], self.s0[which], self.s1[which], self.piece[which], self.bound[which])

    def halved(self) -> "Items":
        """Both halves of every stretch; the bound of the whole holds for each."""
        middle = 0.5 * (self.s0 + self.s1)
        return join(
            [
                Items(self.block, self.s0, middle, self.piece, self.bound),
                Items(self.block, middle, self.s1, self.piece, self.bound),
            ]
        )

    def raised(self, bound: Array) -> "Items":
        """The items with the better of two proven bounds."""
        return Items(self.block, self.s0, self.s1, self.piece, np.maximum(self.bound, bound))


def join(parts: list[Items]) -> Items:
    """One list of items."""
    columns = ([getattr(p, name) for p in parts] for name in ("block", "s0", "s1", "piece", "bound"))
    return Items(*(np.concatenate(column) for column in columns))


class View(Protocol):
    """A batch of items, placed."""

    @property
    def travel(self) -> Array:
        """How far any point of the pair moves over the stretch, at most, (P,) [m]."""

    def along(self, d: Array) -> Array:
        """Proven gap over the whole stretch along unit directions d (P, m, 3) -> (P, m) [m]."""

    def middle(self) -> tuple[Bodies, Bodies]:
        """The pair at the middle of the stretch."""

    def normals(self) -> Array:
        """Face normals of the pair at the middle, from the first towards the second, (P, m, 3)."""

    def need(self) -> Array:
        """Clearance required all over the stretch, (P,) [m]."""

    def need_at_middle(self) -> Array:
        """Clearance required at the middle, (P,) [m]."""


class Problem(Protocol):
    """Something that places items."""

    def view(self, items: Items) -> View:
        """Place the items."""


@dataclass(frozen=True, eq=False)
class Violations:
    """Places that are too close, each (V,): block row, obstacle, s, measured gap and needed clearance [m]."""

    block: IntArray
    piece: IntArray
    s: Array
    gap: Array
    need: Array

    def __len__(self) -> int:
        return len(self.block)

    def take(self, which: IntArray | slice) -> "Violations":
        """The violations at an index."""
        block, piece, s = self.block[which], self.piece[which], self.s[which]
        return Violations(block, piece, s, self.gap[which], self.need[which])

    @staticmethod
    def none() -> "Violations":
        empty, index = np.empty(0), np.empty(0, dtype=np.int64)
        return Violations(index, index, empty, empty, empty)


@dataclass(eq=False)
class Clearances:
    """What is known of the smallest gap of each block while solids are worked through, each (B,) [m].

    lower: proven. upper: measured somewhere; solid, piece, s: where that was (-1 where nothing is within the
    cap).
    """

    lower: Array
    upper: Array
    solid: IntArray
    piece: IntArray
    s: Array

    @staticmethod
    def unknown(blocks: int, cap: float) -> "Clearances":
        index = np.full(blocks, -1, dtype=np.int64)
        return Clearances(np.full(blocks, cap), np.full(blocks, cap), index, index.copy(), np.zeros(blocks))

    def prove(self, items: Items) -> None:
        """Take the items' bounds as final."""
        np.minimum.at(self.lower, items.block, items.bound)

    def measure(self, solid: int, items: Items, distance: Array) -> None:
        """Take note of distances measured at the middles of the items."""
        order = np.argsort(-distance, kind="stable")
        order = order[distance[order] < self.upper[items.block[order]]]
        block = items.block[order]  # the last assignment wins: the smallest distance
        self.upper[block] = distance[order]
        self.solid[block] = solid
        self.piece[block] = items.piece[order]
        self.s[block] = 0.5 * (items.s0 + items.s1)[order]

    def merge(self, found: "Clearances", rows: IntArray, index: IntArray) -> None:
        """Take over, for each of `rows`, what `found` knows at the same place of `index`, both (R,)."""
        self.lower[rows] = np.minimum(self.lower[rows], found.lower[index])
        closer = found.upper[index] < self.upper[rows]
        rows, index = rows[closer], index[closer]
        for name in ("upper", "solid", "piece", "s"):
            getattr(self, name)[rows] = getattr(found, name)[index]


def prove(problem: Problem, items: Items, most: int) -> tuple[Items, Violations, int]:
    """Prove or refute every item; returns the proven stretches, the violations, and the number of poses.

    Gives up, with items undecided, when there are more than `most` violations.
    """
    proven: list[Items] = [items.take(slice(0, 0))]
    refuted: list[Violations] = [Violations.none()]
    poses = 0
    stack = [items.take(slice(i, i + _BATCH)) for i in range(0, len(items), _BATCH)]
    while stack and sum(len(found) for found in refuted) <= most:
        batch = stack.pop()
        view = problem.view(batch)
        direction, distance = _nearest(view)
        poses += len(batch)
        batch = batch.raised(view.along(direction[:, None, :])[:, 0])
        need_there = view.need_at_middle()
        good = batch.bound >= view.need() - TOLERANCE
        bad = ~good & ((distance < need_there - TOLERANCE) | (view.travel <= RESOLUTION))
        proven.append(batch.take(good))
        if bad.any():
            refuted.append(_violations(batch.take(bad), view, bad, distance, need_there))
        rest = batch.take(~(good | bad))
        if len(rest):
            # A place that is refuted already needs no further proof elsewhere on the same block and obstacle.
            rest = _without(rest, batch.take(bad))
        if len(rest):
            stack.append(rest.halved())
    return join(proven), _at_their_worst(problem, _all(refuted)), poses


def tighten(problem: Problem, solid: int, items: Items, clearances: Clearances) -> int:
    """Raise the items' bounds until each block's proven clearance is within SHARPNESS of a measured one.

    Takes note in `clearances`; returns how many poses were looked at. At first only the lowest item of each
    block is worked on: what is measured there closes most of the others. A block where bodies overlap has no
    clearance that could be sharpened.
    """
    poses = 0
    for attempt in count():
        upper = clearances.upper[items.block]
        is_open = (items.bound < upper - SHARPNESS) & (upper > _OVERLAP)
        clearances.prove(items.take(~is_open))
        items = items.take(is_open)
        if not len(items):
            break
        chosen = _lowest_per_block(items) if attempt < _SINGLE else np.ones(len(items), dtype=bool)
        batch, items = items.take(chosen), items.take(~chosen)
        done = []
        for i in range(0, len(batch), _BATCH):
            part = batch.take(slice(i, i + _BATCH))
            view = problem.view(part)
            direction, distance = _nearest(view)
            poses += len(part)
            clearances.measure(solid, part, distance)
            part = part.raised(view.along(direction[:, None, :])[:, 0])
            done.append(_refined(problem, part, direction, view.travel, clearances))
        items = join([items, *done])
    return poses


def _refined(
    problem: Problem, items: Items, direction: Array, travel: Array, clearances: Clearances
) -> Items:
    """Halve the stretches that are still open and try the same direction on the halves."""
    still = items.bound < clearances.upper[items.block] - SHARPNESS
    final = still & (travel <= RESOLUTION)
    clearances.prove(items.take(final))  # cannot be sharpened: overlapping bodies, or a bracket left open
    still &= ~final
    halves = items.take(still).halved()
    if not len(halves):
        return items.take(~still & ~final)
    again = np.concatenate([direction[still], direction[still]])
    halves = halves.raised(problem.view(halves).along(again[:, None, :])[:, 0])
    return join([items.take(~still & ~final), halves])


def _nearest(view: View) -> tuple[Array, Array]:
    """Direction (P, 3) and distance (P,) of the nearest points at the middles; 0 for overlap."""
    first, second = view.middle()
    start = second.ball()[0] - first.ball()[0]
    start[np.linalg.norm(start, axis=1) < 1e-12] = (0.0, 0.0, 1.0)
    found = closest(first, second, start)
    return found.direction, found.upper


def _violations(items: Items, view: View, bad: Mask, distance: Array, need: Array) -> Violations:
    s = 0.5 * (items.s0 + items.s1)
    return Violations(items.block, items.piece, s, _measured(view, bad, distance), need[bad])


def _measured(view: View, which: Mask, distance: Array) -> Array:
    """Gaps in the middle: the distance or, for an overlap, minus the least way out along a face normal."""
    first, second = (bodies.take(np.flatnonzero(which)) for bodies in view.middle())
    depth = gap(first, second, view.normals()[which]).max(axis=1)
    return np.where(distance[which] > _OVERLAP, distance[which], np.minimum(depth, 0.0))


def _at_their_worst(problem: Problem, found: Violations) -> Violations:
    """One violation per block and obstacle; the first ones where samples over the block find them worst."""
    _, index = np.unique(np.stack([found.block, found.piece]), axis=1, return_index=True)
    found = found.take(np.sort(index))
    first, others = found.take(slice(_MEASURED)), found.take(slice(_MEASURED, None))
    n, m = len(first), _SAMPLES + 1
    grid = np.broadcast_to(np.linspace(0.0, 1.0, _SAMPLES), (n, _SAMPLES))
    s = np.column_stack([grid, first.s]).reshape(-1)
    block, piece = np.repeat(first.block, m), np.repeat(first.piece, m)
    view = problem.view(Items(block, s, s, piece, np.zeros(n * m)))
    measured = _measured(view, np.ones(n * m, dtype=bool), _nearest(view)[1])
    need = view.need_at_middle()
    worst = np.arange(n) * m + (measured - need).reshape(n, m).argmin(axis=1)
    return _all([Violations(block, piece, s, measured, need).take(worst), others])


def _without(items: Items, refuted: Items) -> Items:
    if not len(refuted):
        return items
    size = int(max(items.piece.max(), refuted.piece.max())) + 1
    return items.take(~np.isin(items.block * size + items.piece, refuted.block * size + refuted.piece))


def _lowest_per_block(items: Items) -> Mask:
    """Mask of the item with the lowest bound of every block."""
    order = np.lexsort((items.bound, items.block))
    first = np.ones(len(order), dtype=bool)
    first[1:] = items.block[order][1:] != items.block[order][:-1]
    mask = np.zeros(len(items), dtype=bool)
    mask[order[first]] = True
    return mask


def _all(parts: list[Violations]) -> Violations:
    columns = ([getattr(p, name) for p in parts] for name in ("block", "piece", "s", "gap", "need"))
    return Violations(*(np.concatenate(column) for column in columns))
