"""Escapes: displacement sequences that freed the die earlier (Graux 1992, Path generation)."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from planners.block_time import block_time
from planners.compiled import compiled
from planners.detector import Asking, Detector, Ints, edge_is_free
from planners.errors import InvalidSetting, WrongShape
from planners.path import Path
from planners.potential_field import copy

SAME = 0.02
"""In the common unit of places and weighted displacements: less apart, two escapes serve the same links."""


@dataclass(frozen=True, eq=False)
class Escape:
    """A smoothed path, stored relative to its departure.

    name: says where it came from. where: the link's place for "nearest first": a vector (k,), or one for each
    of its two ends, (2, k). offsets: configurations less the first one, shape (N, n), N >= 2; less the last
    one they are what the goal sees.
    """

    name: str
    where: Array
    offsets: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "where", frozen(self.where))
        object.__setattr__(self, "offsets", frozen(self.offsets))
        _check_place(self.where)
        if self.offsets.ndim != 2 or len(self.offsets) < 2:
            raise WrongShape("offsets", "(N, n) with N >= 2", str(self.offsets.shape))

    def __reduce__(self) -> tuple[type[Escape], tuple[str, Array, Array]]:
        return type(self), (self.name, self.where, self.offsets)

    @cached_property
    def backwards(self) -> Escape:
        """The same motion the other way round, under the same name."""
        return Escape(self.name, _turned(self.where), self.offsets[::-1] - self.offsets[-1])


class _Index(NamedTuple):
    """Where m escapes were found, also turned round, (m, ...), and how far they lead, (m, n), for ranking."""

    where: Array
    turned: Array
    moves: Array

    @staticmethod
    def of(escapes: Iterable[Escape]) -> _Index:
        places = [(e.where.ravel(), _turned(e.where).ravel(), e.offsets[-1]) for e in escapes]
        return _Index(*(np.array(column) for column in zip(*places, strict=True)))

    def with_latest(self, escape: Escape, kept: int) -> _Index:
        """With one more escape, and the latest `kept` of all."""
        latest = zip(self, _Index.of([escape]), strict=True)
        return _Index(*(np.concatenate(columns)[-kept:] for columns in latest))

    def distances(self, where: Array, move: Array, weights: Array) -> Array:
        """Of each escape as it is and turned round, (m, 2): between the places plus between displacements."""
        found = np.empty((len(self.moves), 2))
        # Copies, for numba takes read-only arrays for another type to compile for.
        measure(*self, np.array(where.ravel()), np.array(move), np.array(weights), found)
        return found

    def nearest(self, where: Array, move: Array, weights: Array, count: int) -> list[int]:
        """The `count` best escapes in order, each as 2 i or, turned round, 2 i + 1; the latest of equals."""
        best = np.empty(min(count, 2 * len(self.moves)), dtype=np.int64)
        choose(*self, np.array(where.ravel()), np.array(move), np.array(weights), best)
        chosen: list[int] = best.tolist()
        return chosen


@compiled
def measure(
    where: Array, turned: Array, moves: Array, here: Array, move: Array, weights: Array, found: Array
) -> None:
    """Compiled `_Index.distances`, into `found` (m, 2)."""
    for escape in range(len(moves)):
        for way in range(2):
            found[escape, way] = _apart(where, turned, moves, here, move, weights, escape, way)


@compiled
def choose(
    where: Array, turned: Array, moves: Array, here: Array, move: Array, weights: Array, best: Ints
) -> None:
    """Compiled `_Index.nearest`, into `best` (k,); k is at most twice the number of escapes."""
    distances, filled = np.empty(len(best)), 0
    for index in range(2 * len(moves) - 1, -1, -1):
        apart = _apart(where, turned, moves, here, move, weights, index // 2, index % 2)
        at = filled
        while at > 0 and apart < distances[at - 1]:
            at -= 1
        if at == len(best):
            continue
        filled = min(filled + 1, len(best))
        for k in range(filled - 1, at, -1):
            distances[k], best[k] = distances[k - 1], best[k - 1]
        distances[at], best[at] = apart, index


@compiled
def _apart(
    where: Array,
    turned: Array,
    moves: Array,
    here: Array,
    move: Array,
    weights: Array,
    escape: int,
    way: int,
) -> float:
    """Distance of an escape, as it is (way 0) or turned round (1): of places plus displacements."""
    place = displacement = 0.0
    for k in range(len(here)):
        there = where[escape, k] if way == 0 else turned[escape, k]
        place += (there - here[k]) ** 2
    for i in range(len(move)):
        moved = moves[escape, i] if way == 0 else -moves[escape, i]
        displacement += ((moved - move[i]) * weights[i]) ** 2
    return math.sqrt(place) + math.sqrt(displacement)


class EscapeLibrary:
    """The escapes of the latest links, oldest forgotten first. Picklable; same calls, same answers.

    escapes: those it begins with, oldest first; of one shape of `where`.
    """

    def __init__(self, kept: int = 64, escapes: Iterable[Escape] = ()) -> None:
        if kept < 1:
            raise InvalidSetting("kept", kept, "1 or more")
        self._escapes: deque[Escape] = deque(escapes, maxlen=kept)
        self._index: _Index | None = None
        self._numbered = 0
        self._added = 0

    def __len__(self) -> int:
        return len(self._escapes)

    @property
    def added(self) -> tuple[Escape, ...]:
        """Those remembered since the library was made, oldest first."""
        return tuple(self._escapes)[max(0, len(self._escapes) - self._added) :]

    def remember(self, path: Path, where: ArrayLike, name: str | None = None) -> Escape:
        """Store a smoothed path found at `where`, see `Escape`; `name` is a running number if not given."""
        name = str(self._numbered) if name is None else name
        escape = Escape(name, self._position(where), path.configurations - path.start)
        self._escapes.append(escape)
        if self._index is not None:
            self._index = self._index.with_latest(escape, len(self._escapes))
        self._numbered += 1
        self._added += 1
        return escape

    def recall(self, where: ArrayLike, move: Array, weights: Array, count: int) -> list[Escape]:
        """At most `count` escapes, as they are or turned round: best first, the latest of equals.

        The best is the one found in the most similar place whose own displacement is most like `move`, the
        goal less the start, (n,): the distance between the places plus the weighted one between the
        displacements.
        """
        here = self._position(where)
        if count == 0 or not self._escapes:
            return []
        if self._index is None:
            self._index = _Index.of(self._escapes)
        best = self._index.nearest(here, move, weights, count)
        found = [self._escapes[i // 2] for i in best]
        return [escape.backwards if i % 2 else escape for i, escape in zip(best, found, strict=True)]

    def _position(self, where: ArrayLike) -> Array:
        """`where` as an array of the same shape as those before it; raises `WrongShape`."""
        position = frozen(where)
        _check_place(position)
        expected = self._escapes[0].where.shape if self._escapes else position.shape
        if position.shape != expected:
            raise WrongShape("where", str(expected), str(position.shape))
        return position


def _check_place(where: Array) -> None:
    if where.ndim not in (1, 2) or (where.ndim == 2 and len(where) != 2):
        raise WrongShape("where", "(k,) or (2, k)", str(where.shape))


def _turned(where: Array) -> Array:
    """The place of the link the other way round."""
    return where[::-1] if where.ndim == 2 else where


def merged(
    known: Iterable[Escape], found: Iterable[Escape], weights: Array, limits: Array, kept: int
) -> tuple[Escape, ...]:
    """`known` and then `found`; of those that lead the same way in the same place only the quickest, in the
    oldest one's turn. At most `kept`, oldest forgotten first.

    weights: (n,), as in `EscapeLibrary.recall`. limits: (3, n), as in `block_time`.
    """
    escapes = list(known)
    for escape in found:
        twin = _twin(escape, escapes, weights)
        if twin is None:
            escapes.append(escape)
        elif _duration(escape, limits) < _duration(escapes[twin], limits):
            escapes[twin] = escape
    return tuple(escapes[-kept:])


def _twin(escape: Escape, others: Sequence[Escape], weights: Array) -> int | None:
    """Which of the `others` serves the same links, if one does."""
    if not others:
        return None
    apart = _Index.of(others).distances(escape.where, escape.offsets[-1], weights).min(axis=1)
    nearest = int(apart.argmin())
    return nearest if apart[nearest] <= SAME else None


def _duration(escape: Escape, limits: Array) -> float:
    """[s] From end to end of the path with a stop at each waypoint."""
    return sum(block_time(a, b, limits) for a, b in pairwise(escape.offsets))


def replay(detector: Detector, escape: Escape, start: Array, goal: Array) -> Array:
    """Certified configurations (N, n) from `start` to `goal`, shape (n,) each, following `escape`; none if it
    fails.

    The escape is followed from the start as far as it is free, and backwards from the goal as far as needed.
    The two are joined by one straight segment: first from a waypoint to the one after it as the goal sees it
    (the last waypoint straight to the goal and the start straight to the first waypoint are the two ends of
    that series), then between the two images of one and the same waypoint.
    """
    offsets = np.array(escape.offsets)
    path = np.empty((2 * len(offsets), len(start)))
    return path[: join_ends(detector.asking, offsets, np.array(start), np.array(goal), path)]


@compiled
def join_ends(asking: Asking, offsets: Array, start: Array, goal: Array, path: Array) -> int:
    """Compiled `replay`: write the configurations into `path` (2 N, n); return how many, 0 if it fails."""
    size = len(offsets)
    departure, arrival = np.empty((size - 1, len(start))), np.empty((size - 1, len(goal)))
    for k in range(size - 1):
        for i in range(len(start)):
            departure[k, i] = offsets[k, i] - offsets[0, i] + start[i]
            arrival[k, i] = offsets[size - 1 - k, i] - offsets[size - 1, i] + goal[i]
    left, right, most = _follow(asking, departure, 1, size - 1), 1, size - 1
    for shared in (size - 2, size - 1):
        for i in range(min(shared, left - 1), -1, -1):
            j = shared - i
            if right <= j < most:  # the goal's side is followed no farther than it is asked for
                right = _follow(asking, arrival, right, j + 1)
                most = right if right <= j else most
            if j < right and edge_is_free(asking, departure[i], arrival[j]):
                for k in range(i + j + 2):
                    copy(departure[k] if k <= i else arrival[i + j + 1 - k], path[k])
                return i + j + 2
    return 0


@compiled
def _follow(asking: Asking, configurations: Array, first: int, end: int) -> int:
    """How many of the leading `configurations` (N, n), at most `end`, are joined by certified segments; those
    before `first` are.
    """
    for k in range(first, end):
        # At a joint stop the shifted waypoint is held at the stop: the test decides whether that still frees.
        for i in range(configurations.shape[1]):
            configurations[k, i] = min(max(configurations[k, i], asking.lower[i]), asking.upper[i])
        if not edge_is_free(asking, configurations[k - 1], configurations[k]):
            return k
    return end
