"""How the die tip moves, as the panel sees it: what corners that are rounded are measured by."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from planners.arrays import Array

_STEP = 1e-4  # [m] or [rad] of the difference quotient


class Tips(Protocol):
    """Knows where the die tip is."""

    def tips(self, configurations: Array) -> Array:
        """The die tip at configurations (N, n) as the panel sees it, (N, 3) [m]."""
        ...


def tip_motions(space: Tips, configurations: Array) -> Array:
    """The tip's motion by each axis at configurations (N, n), as the panel sees it: (N, 3, n), [m] or [m] per
    [rad].
    """
    count, n = configurations.shape
    steps = _STEP * np.vstack([np.eye(n), -np.eye(n)])
    tips = space.tips((configurations[:, None] + steps).reshape(-1, n)).reshape(count, 2 * n, 3)
    motions: Array = (tips[:, :n] - tips[:, n:]).transpose(0, 2, 1) / (2.0 * _STEP)
    return np.ascontiguousarray(motions)
