"""`KernelTurns`: the arcs of free die angles at one fastener, answered by the compiled kernel."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from planners.arrays import Array
from robots.kernel.flat import FlatCell, copied, machine_row, own_numbers, solid_row
from robots.kernel.layout import (
    C_HEIGHT,
    DEPTH,
    N_OPEN_PAIRS,
    N_PAIRS,
    N_PIECES,
    OWN_CENTER,
    SWEPT,
    TIP_PAIR,
    W_HEIGHT,
    Ints,
    W,
)
from robots.kernel.stations import KernelStations
from robots.kernel.turn import ALL, MEANT, NOT_MEANT, SIMPLEX, free_turn
from robots.kernel.turned import BODIES, ROOM
from robots.solids import Cylinder, Solid

MOST_ARCS = 4096
"""Far more than panels have; what is beyond is left out."""

_LEFT_OUT = -2.0
"""Clearance of a pair that is not asked about: less than any gap, known or not."""

_CLOSER = 2e-9
"""[m] Asked for beyond the clearance: more than the tolerance of all other questions to the kernel, so that
each of them agrees to what is free here.
"""

_MOVE, _CLAMPED, _OPENED, _ALONG = range(4)
"""Rows of lifts: the W move, its two ends, and beside what W lifts, too."""

_NO_ARCS: Array = np.empty((0, 2))
_NO_PIECES: Ints = np.empty(0, dtype=np.int64)


class FreeArcs(NamedTuple):
    """Arcs (k, 2) of C within [-pi, pi] [rad]: with a proved process move, and with room in transit, too."""

    fits: Array
    roomy: Array


class Question(NamedTuple):
    """One row of what `turn.free_turn` is asked; margin [m]."""

    body: int
    other: int
    lift: int
    pieces: int
    margin: float


class Questions(NamedTuple):
    """All of it: rows (Q, 4) and margins (Q,) [m]."""

    asked: Ints
    margins: Array


class Bodies(NamedTuple):
    """As `turned` has solids: points (N, 5), their first and number (B, 2), disc and lever [m] (B, 2)."""

    points: Array
    rows: Ints
    sizes: Array


class Pairs(NamedTuple):
    """The pairs of a packed cell: solids (K, 2), clearances (K, 2) and what they always keep (K,), [m]."""

    solids: Ints
    needs: Array
    always: Array


class KernelTurns:
    """The free die angles of one cell. One thread at a time may ask.

    flat: the packed cell; solids: its solids, in their order. Raises ValueError for a cylinder that does not
    stand along the tool axis.
    """

    def __init__(self, flat: FlatCell, solids: Sequence[Solid]) -> None:
        self._flat = flat
        heights = machine_row(flat)[[W_HEIGHT, C_HEIGHT]]
        self._height = float(heights.sum())
        self._links = [solid.link for solid in solids]
        pairs = _pairs(flat)
        tip = solids[int(pairs.solids[flat.indices[TIP_PAIR], 0])]
        outlines = [_outline(solid, float(heights[1])) for solid in solids]
        self._bodies = _bodies([*outlines, (_middle(tip), 0.0)])
        fits, roomy = self._questions(pairs)
        self._fits, self._roomy = self._rows(fits), self._rows(roomy)
        self._region = self._around([*fits, *roomy])
        self._still = KernelStations(self._without_turning(pairs))
        pieces, depth = flat.indices[[N_PIECES, DEPTH]].tolist()
        self._work = (
            np.empty((6, 12)),
            np.empty(SWEPT),
            np.empty(depth + 2, dtype=np.int64),
            np.empty(pieces, dtype=np.int64),
            np.empty((8 * pieces, 3)),
            np.empty(BODIES, dtype=np.int64),
            np.empty(ROOM),
            np.empty((SIMPLEX + 1, 3)),
        )
        self._arcs = np.empty((2, MOST_ARCS, 2))

    def free_arcs(self, opened: Array, clamped: Array, meant: Ints) -> FreeArcs:
        """The free arcs at two poses (7,) that differ in W only; which C they have does not matter.

        meant: pieces that the die tip may touch.
        """
        if self._still.first_free(opened[None], clamped[None], _NO_PIECES) is None:
            return FreeArcs(_NO_ARCS, _NO_ARCS)
        up, down = self._height + float(clamped[W]), self._height + float(opened[W])
        low, high = min(up, down), max(up, down)
        lifts = np.array([[low, high], [up, up], [down, down], [0.0, 0.0]])
        region = self._region + np.array([0.0, low, high])
        fits = self._ask(self._fits, lifts, region, clamped, meant, np.array([[-math.pi, math.pi]]))
        if len(fits) == 0:
            return FreeArcs(fits, _NO_ARCS)
        # What does not turn needs the same in transit: only the die may come nearer at a fastener.
        return FreeArcs(fits, self._ask(self._roomy, lifts, region, opened, meant, fits))

    def _ask(
        self, questions: Questions, lifts: Array, region: Array, q: Array, meant: Ints, arcs: Array
    ) -> Array:
        """What is free of `arcs` (k, 2)."""
        self._arcs[0, : len(arcs)] = arcs
        place = np.array(q, dtype=np.float64)
        given = (*self._flat, *self._bodies, *questions, lifts, region, place, meant)
        n = free_turn(*given, *self._work, self._arcs, len(arcs))
        free: Array = self._arcs[0, :n].copy()
        return free

    def _questions(self, pairs: Pairs) -> tuple[list[Question], list[Question]]:
        """What an angle must keep to fit, and what else for room in transit."""
        open_pairs, tip_pair = self._flat.indices[[N_OPEN_PAIRS, TIP_PAIR]].tolist()
        fits, roomy = [], []
        for k, (body, other) in self._turning(pairs):
            transit, near = (pairs.needs[k] + _CLOSER).tolist()
            rides = other >= 0 and self._links[other] == "W"
            if pairs.always[k] < near:
                lift = _ALONG if rides else _MOVE if k < open_pairs else _CLAMPED
                fits.append(Question(body, other, lift, NOT_MEANT if k == tip_pair else ALL, near))
            if k < open_pairs and pairs.always[k] < transit:
                roomy.append(Question(body, other, _ALONG if rides else _OPENED, ALL, transit))
        fits.append(Question(len(self._links), -1, _CLAMPED, MEANT, _CLOSER))  # the middle of the tip
        return fits, roomy

    def _rows(self, questions: list[Question]) -> Questions:
        """As the kernel is asked, those about the largest solids first: they leave least to the others."""
        order = sorted(questions, key=lambda each: -float(self._bodies.sizes[each.body].sum()))
        asked = np.array([each[:-1] for each in order], dtype=np.int64)
        return Questions(asked, np.array([each.margin for each in order]))

    def _turning(self, pairs: Pairs) -> Iterator[tuple[int, tuple[int, int]]]:
        """The pairs of which one solid turns: their number, that solid and the other one, or -1."""
        for k, (one, other) in enumerate(pairs.solids.tolist()):
            turn = self._links[one] == "C", other >= 0 and self._links[other] == "C"
            if turn[0] != turn[1]:
                yield k, (one, other) if turn[0] else (other, one)

    def _without_turning(self, pairs: Pairs) -> FlatCell:
        """The cell without the clearances that depend on C."""
        still = copied(self._flat)
        _pairs(still).needs[[k for k, _ in self._turning(pairs)]] = _LEFT_OUT
        return still

    def _around(self, questions: list[Question]) -> Array:
        """Radius, lowest and highest height [m] in the die's frame of what the questions are about."""
        bodies, most = self._bodies, max(each.margin for each in questions)
        turning = {each.body for each in questions}
        heights = np.concatenate([bodies.points[slice(*_ends(bodies.rows[b])), 2] for b in turning])
        reach = max(float(bodies.sizes[b].sum()) for b in turning)
        return np.array([reach + most, heights.min() - most, heights.max() + most])


def _pairs(flat: FlatCell) -> Pairs:
    """Views of the pairs of a packed cell, which are the last things in it."""
    count, own = int(flat.indices[N_PAIRS]), own_numbers(flat)
    return Pairs(
        flat.indices[-2 * count :].reshape(count, 2),
        own[-3 * count : -count].reshape(count, 2),
        own[-count:],
    )


def _ends(row: Ints) -> tuple[int, int]:
    first, count = row.tolist()
    return first, first + count


def _outline(solid: Solid, height: float) -> tuple[Array, float]:
    """Points (k, 3) and a disc [m] whose sum is the solid, on its link; what W carries is seen from link C,
    `height` [m] above it.
    """
    shape, T = solid.shape, solid.T_link_solid
    points, disc = solid.vertices, 0.0
    if isinstance(shape, Cylinder):
        if abs(T[2, 2]) != 1.0:
            raise ValueError(f"cylinder {solid.name} does not stand along the tool axis")
        disc = shape.radius
        points = np.array([T[:3, 3] - [0.0, 0.0, shape.length / 2], T[:3, 3] + [0.0, 0.0, shape.length / 2]])
    return points - [0.0, 0.0, height if solid.link == "W" else 0.0], disc


def _middle(solid: Solid) -> Array:
    """The middle (1, 3) of a solid's own box, on its link."""
    T = solid.T_link_solid
    middle: Array = T[:3, :3] @ solid_row(solid)[OWN_CENTER : OWN_CENTER + 3] + T[:3, 3]
    return middle[None]


def _bodies(outlines: Sequence[tuple[Array, float]]) -> Bodies:
    ends = np.cumsum([0, *(len(points) for points, _ in outlines)]).tolist()
    corners = np.vstack([points for points, _ in outlines])
    radii = np.hypot(corners[:, 0], corners[:, 1])
    rows = np.array([[first, end - first] for first, end in pairwise(ends)])
    levers = [radii[first:end].max() for first, end in pairwise(ends)]
    points = np.column_stack([corners, radii, np.arctan2(corners[:, 1], corners[:, 0])])
    return Bodies(points, rows, np.column_stack([[disc for _, disc in outlines], levers]))
