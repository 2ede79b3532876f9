from itertools import islice

import numpy as np

from planners.detector import Detector
from planners.region import Region, growing_regions
from planners.settings import AxisRule, PlannerSettings
from tests.planners.toy_spaces import BoxSpace


def empty(size: float = 10.0) -> BoxSpace:
    return BoxSpace([-size] * 2, [size] * 2)


def test_a_region_refuses_what_is_outside_it_and_asks_the_space_about_the_rest() -> None:
    space = BoxSpace([-10.0] * 2, [10.0] * 2, [((0.5, 0.5), (0.6, 0.6))])
    region = Detector(Region(space, np.full(2, -1.0), np.full(2, 1.0)), 100)

    assert region.is_free(np.array([1.0, -1.0]))
    assert not region.is_free(np.array([1.001, 0.0]))
    assert not region.is_free(np.array([0.55, 0.55]))
    assert region.edge_is_free(np.array([-1.0, -1.0]), np.array([1.0, -1.0]))
    assert not region.edge_is_free(np.array([-1.0, -1.0]), np.array([1.001, -1.0]))
    assert not region.edge_is_free(np.array([-1.001, -1.0]), np.array([1.0, -1.0]))
    assert not region.edge_is_free(np.array([0.0, 0.0]), np.array([1.0, 1.0]))


def test_regions_hold_the_ends_grow_with_their_budget_and_stop_at_the_bounds() -> None:
    settings = PlannerSettings(
        (AxisRule(0.1, weight=2.0), AxisRule(0.1, margin=0.0)),
        region_margin=1.0,
        region_growth=3.0,
        engine_detections=10,
    )
    start, goal = np.array([1.0, 2.0]), np.array([-1.0, 3.0])

    series = list(islice(growing_regions(empty(), start, goal, settings), 5))

    assert [budget for _, budget in series] == [10, 30, 90, 270, 810]
    assert [region.lower.tolist() for region, _ in series] == [
        [-1.5, 2],
        [-2.5, 2],
        [-5.5, 2],
        [-10, 2],
        [-10, 2],
    ]
    assert [region.upper.tolist() for region, _ in series] == [[1.5, 3], [2.5, 3], [5.5, 3], [10, 3], [10, 3]]
