"""What a planner may ask about the world, and nothing more."""

from typing import Protocol

from planners.arrays import Array


class Space(Protocol):
    """Configurations of one system among its obstacles.

    Graux 1992 asks that the algorithm be separated from movement management and environment: this protocol is
    that border. A planner never sees a shape, a joint name or a file.

    Configurations have shape (n,); each axis has its own unit ([m] or [rad]).
    """

    @property
    def lower(self) -> Array:
        """Lower bounds (joint stops), shape (n,)."""
        ...

    @property
    def upper(self) -> Array:
        """Upper bounds (joint stops), shape (n,)."""
        ...

    def is_free(self, q: Array) -> bool:
        """Whether `q` keeps the required clearance."""
        ...

    def edge_is_free(self, a: Array, b: Array) -> bool:
        """Whether the whole straight segment from `a` to `b`, ends included, is certified free."""
        ...

    def advance(self, a: Array, b: Array) -> Array:
        """Farthest certified-free configuration on the segment from `a` (which is free) towards `b`.

        The values of `b` exactly when the whole segment is free; the values of `a` when nothing is.
        """
        ...
