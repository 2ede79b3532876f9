"""Axis limits: whether configurations are within them, and where a segment leaves them."""

from __future__ import annotations

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.layout import LOWER, UPPER

AT_LIMIT = 1e-12
"""As `Machine.within_limits`: so much beyond an axis limit is rounding."""


@compiled_on_views
def within_limits(machine: Array, path: Array, rows: int) -> bool:
    """Whether the first `rows` configurations of the path are within limits; what is no number is not."""
    for row in range(rows):
        for i in range(7):
            q = path[row, i]
            if not (machine[LOWER + i] - AT_LIMIT <= q <= machine[UPPER + i] + AT_LIMIT):
                return False
    return True


@compiled_on_views
def cut_at_limits(machine: Array, a: Array, b: Array) -> None:
    """Move `b` back on the segment from `a`, which is within limits, to where the segment leaves them."""
    share = 1.0
    for i in range(7):
        step = b[i] - a[i]
        room = machine[UPPER + i] - a[i] if step > 0.0 else a[i] - machine[LOWER + i]
        if step != 0.0:
            share = min(share, max(0.0, room / abs(step)))
    if share < 1.0:
        move_back(a, b, share)


@compiled_on_views
def move_back(a: Array, b: Array, share: float) -> None:
    """Move `b` back on the segment from `a`, to that share of it; exactly to `a` for 0."""
    for i in range(7):
        b[i] = a[i] + share * (b[i] - a[i]) if share > 0.0 else a[i]
