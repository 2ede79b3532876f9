"""A Path: ordered checked configurations, no time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.arrays import Array, frozen
from planners.errors import NotFinite, WrongShape


@dataclass(frozen=True, eq=False)
class Path:
    """Straight segments through `configurations`, shape (N, n), read-only; N = 0 is the empty path.

    Raises `WrongShape` or `NotFinite`.
    """

    configurations: Array

    def __post_init__(self) -> None:
        configurations = frozen(self.configurations)
        if configurations.ndim != 2:
            raise WrongShape("configurations", "(N, n)", str(configurations.shape))
        if not np.isfinite(configurations).all():
            raise NotFinite("configurations")
        object.__setattr__(self, "configurations", configurations)

    @classmethod
    def trusted(cls, configurations: Array) -> Path:
        """A path of an array (N, n) that nobody else holds and that is known to be finite: not checked, not
        copied.
        """
        path = object.__new__(cls)
        configurations.setflags(write=False)
        object.__setattr__(path, "configurations", configurations)
        return path

    def __reduce__(self) -> tuple[type[Path], tuple[Array]]:
        # Unpickling an array makes it writable again: come back through the constructor, which freezes it.
        return type(self), (self.configurations,)

    def __len__(self) -> int:
        return len(self.configurations)

    @property
    def start(self) -> Array:
        """First configuration, shape (n,)."""
        first: Array = self.configurations[0]
        return first

    @property
    def goal(self) -> Array:
        """Last configuration, shape (n,)."""
        last: Array = self.configurations[-1]
        return last

    def length(self, weights: Array | None = None) -> float:
        """Sum over the segments of the (weighted) Euclidean length, sqrt(sum_i (w_i dq_i)^2).

        weights: shape (n,), makes axes of different units comparable; None: all ones.
        """
        steps = np.diff(self.configurations, axis=0)
        if weights is not None:
            steps = steps * weights
        return float(np.linalg.norm(steps, axis=1).sum())

    def reversed(self) -> Path:
        """The same path from its goal to its start."""
        return Path(self.configurations[::-1])
