"""Escapes: displacement sequences that freed the die earlier (Graux 1992, Path generation)."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from planners.detector import Detector
from planners.errors import InvalidSetting, WrongShape
from planners.path import Path


@dataclass(frozen=True, eq=False)
class Escape:
    """A smoothed path, stored relative to its departure.

    name: says where it came from. where: position of the link, shape (k,), for "nearest first". offsets:
    configurations less the first one, shape (N, n), N >= 2; less the last one they are what the goal sees.
    """

    name: str
    where: Array
    offsets: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "where", frozen(self.where))
        object.__setattr__(self, "offsets", frozen(self.offsets))
        if self.where.ndim != 1:
            raise WrongShape("where", "(k,)", str(self.where.shape))
        if self.offsets.ndim != 2 or len(self.offsets) < 2:
            raise WrongShape("offsets", "(N, n) with N >= 2", str(self.offsets.shape))

    def __reduce__(self) -> tuple[type[Escape], tuple[str, Array, Array]]:
        return type(self), (self.name, self.where, self.offsets)

    def backwards(self) -> Escape:
        """The same motion the other way round, under the same name."""
        return Escape(self.name, self.where, self.offsets[::-1] - self.offsets[-1])


class EscapeArrays(NamedTuple):
    """A library as plain arrays, oldest escape first.

    names: m. where: shape (m, k). lengths: N of each escape, (m,). offsets: all of them stacked, (sum N, n).
    numbered: how many links were remembered so far, for the running numbers.
    """

    names: tuple[str, ...]
    where: Array
    lengths: Array
    offsets: Array
    numbered: int


class EscapeLibrary:
    """The escapes of the latest links, oldest forgotten first. Picklable; same calls, same answers."""

    def __init__(self, kept: int = 64) -> None:
        if kept < 1:
            raise InvalidSetting("kept", kept, "1 or more")
        self._escapes: deque[Escape] = deque(maxlen=kept)
        self._numbered = 0

    def __len__(self) -> int:
        return len(self._escapes)

    def remember(self, path: Path, where: ArrayLike, name: str | None = None) -> Escape:
        """Store a smoothed path found at `where`, shape (k,); `name` is a running number if not given."""
        name = str(self._numbered) if name is None else name
        escape = Escape(name, self._position(where), path.configurations - path.start)
        self._escapes.append(escape)
        self._numbered += 1
        return escape

    def recall(self, where: ArrayLike, count: int) -> list[Escape]:
        """At most `count` escapes: nearest to `where` first, of equals the most recent first."""
        here = self._position(where)
        latest_first = reversed(self._escapes)
        return sorted(latest_first, key=lambda escape: _distance(escape.where, here))[:count]

    def to_arrays(self) -> EscapeArrays:
        """Export."""
        escapes = list(self._escapes)
        return EscapeArrays(
            tuple(escape.name for escape in escapes),
            frozen([escape.where for escape in escapes]),
            frozen([len(escape.offsets) for escape in escapes]),
            frozen([row for escape in escapes for row in escape.offsets]),
            self._numbered,
        )

    @classmethod
    def from_arrays(cls, arrays: EscapeArrays, kept: int = 64) -> EscapeLibrary:
        """Import what `to_arrays` exported; of more than `kept` the oldest are forgotten."""
        library = cls(kept)
        ends = np.cumsum(arrays.lengths).astype(int)
        pieces = np.split(arrays.offsets, ends[:-1])
        library._escapes.extend(map(Escape, arrays.names, arrays.where, pieces))
        library._numbered = arrays.numbered
        return library

    def _position(self, where: ArrayLike) -> Array:
        """`where` as an array of the same shape as those before it; raises `WrongShape`."""
        position = frozen(where)
        expected = self._escapes[0].where.shape if self._escapes else position.shape
        if position.ndim != 1 or position.shape != expected:
            raise WrongShape("where", str(expected) if self._escapes else "(k,)", str(position.shape))
        return position


def replay(detector: Detector, escape: Escape, start: Array, goal: Array) -> list[Array]:
    """Certified configurations from `start` to `goal`, shape (n,) each, following `escape`; none if it fails.

    The escape is followed from the start as far as it is free, and backwards from the goal likewise. Then the
    two are joined by one straight segment: first from a waypoint to the one after it as the goal sees it (the
    last waypoint straight to the goal and the start straight to the first waypoint are the two ends of that
    series), then between the two images of one and the same waypoint.
    """
    departure = _follow(detector, escape.offsets[:-1] + start)
    arrival = _follow(detector, (escape.offsets - escape.offsets[-1])[:0:-1] + goal)
    waypoints = len(escape.offsets)
    for shared in (waypoints - 2, waypoints - 1):
        for i in range(min(shared, len(departure) - 1), -1, -1):
            j = shared - i
            if j < len(arrival) and detector.edge_is_free(departure[i], arrival[j]):
                return departure[: i + 1] + arrival[j::-1]
    return []


def _follow(detector: Detector, configurations: Array) -> list[Array]:
    """The leading `configurations` joined by certified segments; the first one is taken as free."""
    space = detector.space
    followed = [configurations[0]]
    for q in configurations[1:]:
        # At a joint stop the shifted waypoint is held at the stop: the test decides whether that still frees.
        q = np.clip(q, space.lower, space.upper)
        if not detector.edge_is_free(followed[-1], q):
            break
        followed.append(q)
    return followed


def _distance(a: Array, b: Array) -> float:
    return float(np.linalg.norm(a - b))
