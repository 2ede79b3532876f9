"""RRT-Connect: two trees that grow towards each other (Kuffner and LaValle, ICRA 2000): the fallback.

Departure from the source: a branch is as long as its certified advance, so trees stay small and every branch
is certified. Distances are taken with the axes scaled by their weights.
"""

from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array
from planners.detector import Detector, Stop, never
from planners.outcome import found, unfinished, unsafe_end
from planners.request import checked_ends
from planners.result import PlanCounts, PlanResult
from planners.settings import PlannerSettings
from planners.space import Space

_PROGRESS = 1e-3  # of the branch reach: a shorter advance is a node on top of its parent


class Tree:
    """Configurations with their parents, in arrays that double when full.

    root: shape (n,). weights: shape (n,).
    """

    def __init__(self, root: Array, weights: Array) -> None:
        self._weights = weights
        self._configurations = np.empty((64, len(root)))
        self._scaled = np.empty((64, len(root)))
        self._parents = np.empty(64, dtype=np.intp)
        self.size = 0
        self.add(root, 0)

    def __getitem__(self, index: int) -> Array:
        q: Array = self._configurations[index]
        return q

    def add(self, q: Array, parent: int) -> int:
        """Append `q` below `parent`; return its index."""
        if self.size == len(self._parents):
            self._grow()
        index = self.size
        self._configurations[index] = q
        self._scaled[index] = q * self._weights
        self._parents[index] = parent
        self.size += 1
        return index

    def nearest(self, q: Array) -> int:
        """Index of the nearest configuration in the weighted metric; the oldest of equals."""
        difference = self._scaled[: self.size] - q * self._weights
        return int(np.argmin(np.einsum("ij,ij->i", difference, difference)))

    def branch(self, index: int) -> list[Array]:
        """Configurations from the root to `index`."""
        indices = [index]
        while indices[-1] != 0:
            indices.append(int(self._parents[indices[-1]]))
        return [self._configurations[i].copy() for i in reversed(indices)]

    def _grow(self) -> None:
        self._configurations = np.concatenate([self._configurations, np.empty_like(self._configurations)])
        self._scaled = np.concatenate([self._scaled, np.empty_like(self._scaled)])
        self._parents = np.concatenate([self._parents, np.empty_like(self._parents)])


def plan(
    space: Space,
    start: ArrayLike,
    goal: ArrayLike,
    settings: PlannerSettings,
    rng: np.random.Generator,
    stop: Stop = never,
) -> PlanResult:
    """Search a path from `start` to `goal`, shape (n,) each, with two trees, and smooth it.

    Same answers and errors as `graux.plan`; an `advance` is one detection. Samples come from the bounds of
    `space`, so a Region keeps the trees small.
    """
    q0, qf = checked_ends(space, start, goal, settings)
    begin = perf_counter()
    detector = Detector(space, settings.max_detections, stop)
    unsafe = unsafe_end(detector, q0, qf)
    if unsafe is not None:
        return unsafe
    trees = Tree(q0, settings.weights), Tree(qf, settings.weights)
    record = _grow_until_joined(detector, trees, settings, rng)
    seconds = perf_counter() - begin
    if record:
        return found(detector, record, settings, PlanCounts(), seconds, "fallback")
    reason = f"stopped with trees of {trees[0].size} and {trees[1].size} configurations: the budget is spent"
    return unfinished(detector, [q0], PlanCounts(), seconds, reason)


def _grow_until_joined(
    detector: Detector, trees: tuple[Tree, Tree], settings: PlannerSettings, rng: np.random.Generator
) -> list[Array]:
    """Configurations from root to root, or nothing when the budget is spent first."""
    space = detector.space
    growing, other = trees
    while not detector.spent:
        sample = space.lower + rng.random(len(space.lower)) * (space.upper - space.lower)
        tip = _extend(detector, growing, sample, settings, settings.branch_reach)
        if tip is not None:
            joint = _extend(detector, other, growing[tip], settings, np.inf)
            if joint is not None and _meet(detector, other[joint], growing[tip], settings):
                return _joined(growing.branch(tip), other.branch(joint), growing is trees[0])
        growing, other = other, growing
    return []


def _extend(
    detector: Detector, tree: Tree, target: Array, settings: PlannerSettings, reach: float
) -> int | None:
    """Grow `tree` from its nearest configuration towards `target`, at most `reach`; None for no gain."""
    parent = tree.nearest(target)
    near = tree[parent].copy()
    distance = _distance(near, target, settings)
    aim = target if distance <= reach else near + (target - near) * (reach / distance)
    tip = detector.advance(near, aim)
    if _distance(near, tip, settings) < _PROGRESS * settings.branch_reach:
        return None
    return tree.add(tip, parent)


def _meet(detector: Detector, a: Array, b: Array, settings: PlannerSettings) -> bool:
    """Whether `a` is `b`; but for rounding, where the space computed its way to `b`, and then by a certified
    edge."""
    if np.array_equal(a, b):
        return True
    return _distance(a, b, settings) < _PROGRESS * settings.branch_reach and detector.edge_is_free(a, b)


def _distance(a: Array, b: Array, settings: PlannerSettings) -> float:
    return float(np.linalg.norm((b - a) * settings.weights))


def _joined(branch: list[Array], other: list[Array], forward: bool) -> list[Array]:
    if np.array_equal(branch[-1], other[-1]):
        other = other[:-1]
    from_start, from_goal = (branch, other) if forward else (other, branch)
    return from_start + from_goal[::-1]
