"""Instances of the order problem, and their proven optimum: an integer programme with subtour cuts, solved
by HiGHS, which shares nothing with the solver.
"""

import math

import numpy as np
from scipy import sparse
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csgraph

from planners.arrays import Array
from planners.block_time import block_times
from planners.sequencing.problem import IntArray

_LIMITS = np.array([[0.6, 0.5], [1.0, 1.0], [5.0, 5.0]])


def times(points: Array, bays: IntArray, escape: float) -> IntArray:
    """Costs [us] between points (n + 1, 2), home last: blocks, and an escape from bay to bay."""
    costs = block_times(points, points, _LIMITS)
    costs = costs + escape * np.any(bays[:, None] != bays[None], axis=-1)
    np.fill_diagonal(costs, 0.0)
    return np.asarray(np.rint(1e6 * costs), dtype=np.int64)


def scattered(count: int, seed: int) -> IntArray:
    """Points at random over bays of 150 mm."""
    rng, side = np.random.default_rng(seed), 0.05 * math.sqrt(count)
    points = np.vstack([rng.uniform(0.0, side, (count, 2)), [[0.0, -2.0 * side]]])
    return times(points, np.floor(points / 0.15).astype(np.int64), 1.5)


def in_rows(count: int, seed: int) -> IntArray:
    """Rows of 22 mm pitch 150 mm apart, shuffled; a row is a bay, or several of 500 mm."""
    rng, rows = np.random.default_rng(seed), max(1, round(math.sqrt(count / 4)))
    per_row = -(-count // rows)
    places = [(0.022 * i, 0.15 * k) for k in range(rows) for i in range(per_row)][:count]
    points = np.vstack([np.array(places)[rng.permutation(count)], [[-1.0, -0.5]]])
    bays = np.stack([np.floor(points[:, 0] / 0.5), np.round(points[:, 1] / 0.15)], axis=1)
    return times(points, bays.astype(np.int64), 1.0)


def proven_optimum(costs: IntArray) -> int:
    """Cost of the best tour through symmetric costs: cuts for subtours are added until there are none."""
    size = len(costs)
    a, b = np.triu_indices(size, 1)
    edges = np.arange(len(a))
    degrees = sparse.csr_array((np.ones(2 * len(a)), (np.concatenate([a, b]), np.tile(edges, 2))))
    rows = [LinearConstraint(degrees, 2, 2)]
    while True:
        found = milp(
            costs[a, b].astype(float),
            constraints=rows,
            integrality=1,
            bounds=Bounds(0, 1),
            options={"mip_rel_gap": 0.0},
        )
        used = found.x > 0.5
        graph = sparse.coo_array((np.ones(used.sum()), (a[used], b[used])), shape=(size, size))
        parts, part_of = csgraph.connected_components(graph, directed=False)
        if parts == 1:
            return int(costs[a[used], b[used]].sum())
        for part in range(parts):
            inside = (part_of[a] == part) & (part_of[b] == part)
            rows.append(LinearConstraint(inside[None].astype(float), 0, int((part_of == part).sum()) - 1))
