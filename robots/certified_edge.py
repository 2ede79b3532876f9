"""The one edge test: certified, not sampled.

A piece of the edge is certified for a pair when, at its middle, the gap is at least the required clearance
plus half of the pair's motion over the piece: nothing in the piece can then come closer than required. Where
the gap is smaller the piece is halved for the pairs that are still open; a middle that itself violates the
clearance, or a piece too short to matter, refuses. So a refusal may be over-careful by the resolution, an
acceptance is never wrong, and thin webs cannot be stepped over however long the edge is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from planners.arrays import Array

RESOLUTION = 0.00005
"""[m] Pieces with less motion than this are refused, not halved further."""


class Gaps(Protocol):
    """What the edge test asks of a scene."""

    def place(self, q: Array) -> None:
        """Take configuration `q`."""
        ...

    def within(self, k: int, margin: float) -> bool:
        """Whether the gap of pair `k` is less than `margin` [m]."""
        ...


Required = Callable[[float], list[float]]
"""Clearance [m] every pair must keep at the placed configuration and within the given tip travel [m] of it.
"""


def certified_to(
    gaps: Gaps, a: Array, b: Array, motion: list[float], tip_motion: float, required: Required, *, whole: bool
) -> float:
    """How much of the edge from `a` to `b` is certified: a fraction in [0, 1], 1.0 for all of it.

    motion: bound on each pair's relative motion over the whole edge [m]; pairs with a bound of 0 count too.
    tip_motion: the same for the die tip; `required` is asked with half of its part over each piece.
    whole: only all of the edge is of use, so that the first violation found anywhere on it ends the test.
    """
    step = b - a
    pending = [(0.0, 1.0, list(range(len(motion))))]
    certified = 0.0
    while pending:
        low, high, pairs = pending.pop()
        half = (high - low) / 2.0
        middle = low + half
        gaps.place(a + middle * step)
        needed = required(half * tip_motion)
        pairs = [k for k in pairs if gaps.within(k, needed[k] + half * motion[k])]
        if not pairs:
            certified = high
            continue
        if max(motion[k] for k in pairs) * half < RESOLUTION:
            return certified
        blocked = _violated(gaps, pairs, required)
        if whole and not blocked and high == 1.0:
            gaps.place(b)  # a step into an obstacle mostly fails at its end: ask there before halving
            blocked = _violated(gaps, pairs, required)
        if whole and blocked:
            return certified
        # What lies beyond a blocked middle is of no use, what lies before it still is.
        pending = (
            [(low, middle, pairs)] if blocked else [*pending, (middle, high, pairs), (low, middle, pairs)]
        )
    return certified


def _violated(gaps: Gaps, pairs: list[int], required: Required) -> bool:
    """Whether any of `pairs` is closer than required at the placed configuration."""
    needed = required(0.0)
    return any(gaps.within(k, needed[k]) for k in pairs)
