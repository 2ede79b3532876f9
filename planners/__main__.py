"""`python -m planners`: compile the searches into their cache, so that no first request waits for them."""

from __future__ import annotations

import numpy as np

from planners import graux, rrt_connect
from planners.arrays import Array, frozen
from planners.blending import blended
from planners.detector import Detector
from planners.link_planner import LinkPlanner
from planners.overlap import Corner
from planners.retiming import exact_stop
from planners.settings import AxisRule, PlannerSettings


class Wall:
    """The plane with a wall of no thickness hanging down to y = -1 at x = 1: two links over it use it all."""

    lower, upper = frozen([-3.0, -3.0]), frozen([5.0, 3.0])

    def is_free(self, q: Array) -> bool:
        """Everywhere but on the wall."""
        return bool(q[0] != 1.0 or q[1] < -1.0)

    def edge_is_free(self, a: Array, b: Array) -> bool:
        """Whether the segment passes below the wall or stays on one side of it."""
        if (a[0] - 1.0) * (b[0] - 1.0) > 0.0:
            return True
        step = b[0] - a[0]
        at = a[1] + (b[1] - a[1]) * ((1.0 - a[0]) / step if step else 0.0)
        return bool(at < -1.0)

    def advance(self, a: Array, b: Array) -> Array:
        """All or nothing."""
        return b if self.edge_is_free(a, b) else a


def warm() -> None:
    """Search with every engine, replay an escape, smooth; round corners."""
    settings = PlannerSettings((AxisRule(0.5), AxisRule(0.5)), region_margin=2.0, branch_reach=1.0)
    space, rng, start, goal = Wall(), np.random.default_rng(0), np.zeros(2), np.array([2.0, 0.0])
    for engine in (graux.plan, rrt_connect.plan):
        engine(space, start, goal, settings, rng)
    planner = LinkPlanner(settings)
    for shift in (0.0, 0.01):
        planner.plan(space, start + shift, goal, [0.0], rng)
    rules = (AxisRule(0.5, v_max=1.0, a_max=1.0, j_max=1.0),) * 2
    path, finite = np.array([[0.0, 0.0], [1.0, -2.0], [2.0, 0.0]]), PlannerSettings(rules, region_margin=2.0)
    blended(Detector(space, 50), path, finite, lambda q: np.tile(np.eye(2), (len(q), 1, 1)), 0.1)
    block = exact_stop([1.0, 0.0], *finite.limits)
    corner = Corner(block, block, path[1], path[2] - path[1], finite.limits)
    corner.longest(corner.within(np.eye(2), 0.1))


if __name__ == "__main__":
    warm()
