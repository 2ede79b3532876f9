"""RRT-Connect: two trees that grow towards each other (Kuffner and LaValle, ICRA 2000).

Branches are certified edges; one that is refused costs little, mostly one pose. Distances are taken with the
axes scaled by their weights.
"""

from __future__ import annotations

from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array
from planners.compiled import compiled
from planners.detector import Asking, Detector, Ints, edge_is_free, never, spent
from planners.native import Stop
from planners.outcome import found, unfinished, unsafe_end
from planners.potential_field import copy, potential, same
from planners.region import Searched
from planners.request import checked_ends
from planners.result import PlanCounts, PlanResult
from planners.settings import PlannerSettings


class Tree(NamedTuple):
    """Configurations (N, n) with their parents (N,), the root first; size (1,): how many there are."""

    configurations: Array
    parents: Ints
    size: Ints


class Growth(NamedTuple):
    """What both trees need. weights (n,); reach: longest branch, in the weights' unit; candidate: work space
    (n,).
    """

    asking: Asking
    rng: np.random.Generator
    weights: Array
    reach: float
    candidate: Array


def plan(
    space: Searched,
    start: ArrayLike,
    goal: ArrayLike,
    settings: PlannerSettings,
    rng: np.random.Generator,
    stop: Stop = never,
) -> PlanResult:
    """Search a path from `start` to `goal`, shape (n,) each, with two trees, and smooth it.

    Same answers and errors as `graux.plan`. Samples come from the bounds of `space`, so a Region keeps the
    trees small.
    """
    q0, qf = checked_ends(space, start, goal, settings)
    begin = perf_counter()
    detector = Detector(space, settings.max_detections, stop)
    unsafe = unsafe_end(detector, q0, qf)
    if unsafe is not None:
        return unsafe
    growth = Growth(
        detector.asking,
        rng,
        np.array(settings.weights),
        settings.branch_reach,
        np.empty(len(q0)),
    )
    trees = new_tree(q0, detector.limit + 1), new_tree(qf, detector.limit + 1)
    path = np.empty((2 * detector.limit + 2, len(q0)))
    count = grow_until_joined(growth, *trees, path)
    seconds = perf_counter() - begin
    if count:
        return found(detector, path[:count], settings, PlanCounts(), seconds, "planned")
    sizes = [int(tree.size[0]) for tree in trees]
    reason = f"stopped with trees of {sizes[0]} and {sizes[1]} configurations: the budget is spent"
    return unfinished(detector, q0[np.newaxis], PlanCounts(), seconds, reason)


def new_tree(root: Array, most: int) -> Tree:
    """A tree of its root (n,) with room for `most` configurations."""
    tree = Tree(np.empty((most, len(root))), np.zeros(most, dtype=np.int64), np.ones(1, dtype=np.int64))
    tree.configurations[0] = root
    return tree


@compiled
def grow_until_joined(growth: Growth, from_start: Tree, from_goal: Tree, path: Array) -> int:
    """Write the configurations from root to root into `path`; return how many, 0 when the budget is spent
    first.
    """
    growing, other = from_start, from_goal
    forward = True
    sample = np.empty(len(growth.candidate))
    while not spent(growth.asking):
        for i in range(len(sample)):
            lower, upper = growth.asking.lower[i], growth.asking.upper[i]
            sample[i] = lower + growth.rng.random() * (upper - lower)
        tip = extend(growth, growing, sample, nearest(growing, sample, growth.weights))
        if tip >= 0:
            target = growing.configurations[tip]
            joint = connect(growth, other, target)
            if joint >= 0:
                if forward:
                    return _joined(from_start, tip, from_goal, joint, path)
                return _joined(from_start, joint, from_goal, tip, path)
        growing, other, forward = other, growing, not forward
    return 0


@compiled
def extend(growth: Growth, tree: Tree, target: Array, parent: int) -> int:
    """Grow `tree` from the configuration `parent` towards `target`, at most `reach`; return the new index, -1
    where the branch is not free.
    """
    near, candidate = tree.configurations[parent], growth.candidate
    distance = potential(near, target, growth.weights)
    copy(target, candidate)
    if distance > growth.reach:
        for i in range(len(candidate)):
            candidate[i] = near[i] + (target[i] - near[i]) * (growth.reach / distance)
    if not edge_is_free(growth.asking, near, candidate):
        return -1
    return add(tree, candidate, parent)


@compiled
def connect(growth: Growth, tree: Tree, target: Array) -> int:
    """Grow `tree` towards `target` branch by branch; return the index of the target in it, -1 where the way
    is not free.
    """
    tip = nearest(tree, target, growth.weights)
    while not same(tree.configurations[tip], target):
        tip = extend(growth, tree, target, tip)
        if tip < 0:
            return -1
    return tip


@compiled
def nearest(tree: Tree, q: Array, weights: Array) -> int:
    """Index of the nearest configuration in the weighted metric; the oldest of equals."""
    best, least = 0, np.inf
    for index in range(tree.size[0]):
        square = 0.0
        for i in range(len(q)):
            square += (weights[i] * (tree.configurations[index, i] - q[i])) ** 2
        if square < least:
            best, least = index, square
    return best


@compiled
def add(tree: Tree, q: Array, parent: int) -> int:
    """Append `q` below `parent`; return its index."""
    index = tree.size[0]
    copy(q, tree.configurations[index])
    tree.parents[index] = parent
    tree.size[0] = index + 1
    return int(index)


@compiled
def _joined(from_start: Tree, tip: int, from_goal: Tree, joint: int, path: Array) -> int:
    """The branch from the root of one tree to `tip`, and on from `joint`, which is the same place, to the
    root of the other.
    """
    count = branch(from_start, tip, path, 0)
    for k in range(count // 2):
        for i in range(path.shape[1]):
            path[k, i], path[count - 1 - k, i] = path[count - 1 - k, i], path[k, i]
    return branch(from_goal, joint, path, count - 1)


@compiled
def branch(tree: Tree, index: int, path: Array, count: int) -> int:
    """Write the configurations from `index` down to the root into `path` behind the first `count`; return how
    many there are now.
    """
    while True:
        copy(tree.configurations[index], path[count])
        count += 1
        if index == 0:
            return count
        index = tree.parents[index]
