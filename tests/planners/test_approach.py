import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.approach import (
    HIGHEST_ORDER,
    approach_count,
    approach_heights,
    approach_points,
    approach_spacing,
)
from planners.errors import InvalidSetting, NotFinite, WrongShape

orders = st.integers(0, 12)
heights = st.tuples(st.floats(0.0, 0.1), st.floats(0.0, 0.5)).map(lambda h: (h[0], h[0] + h[1]))
UP = [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]


@given(orders, st.floats(0.001, 12.0), heights)
def test_points_stand_above_the_line_evenly_and_mirrored(
    order: int, pitch: float, height: tuple[float, float]
) -> None:
    points = approach_points([[0.0, 0.0, 0.0], [0.0, pitch, 0.0]], UP, order, *height)

    assert len(points) == approach_count(order)
    assert np.allclose(np.diff(points[:, 1]), approach_spacing(order, pitch), rtol=1e-12)
    assert np.allclose(points[:, 2], points[::-1, 2], rtol=0.0, atol=1e-15)
    assert points[[0, -1], 2].tolist() == [height[0], height[0]]
    if order:
        assert points[order, 2] == pytest.approx(height[1])
        assert np.allclose(
            np.diff(points[:, 2], 2)[: order - 1], 0.0, atol=1e-12
        )  # straight up to the middle


@given(orders, heights, st.floats(0.01, 1.0))
def test_on_a_cylinder_points_stand_on_the_normals(
    order: int, height: tuple[float, float], angle: float
) -> None:
    normals = np.array([[math.sin(a), 0.0, math.cos(a)] for a in (-0.5 * angle, 0.5 * angle)])
    targets = 2.0 * normals + [0.0, 0.3, 0.0]

    points = approach_points(targets, normals, order, *height)

    assert np.allclose(points[0], targets[0] + height[0] * normals[0])
    assert np.allclose(points[-1], targets[1] + height[0] * normals[1])
    if order:
        middle = targets.mean(axis=0) + np.array([0.0, 0.0, height[1]])
        assert np.allclose(points[order], middle)
    share = np.linspace(0.0, 1.0, len(points))[:, np.newaxis]
    above = points - ((1 - share) * targets[0] + share * targets[1])
    assert np.allclose(np.linalg.norm(above, axis=1), approach_heights(order, *height))


def test_wrong_requests_are_errors() -> None:
    for order in (-1, HIGHEST_ORDER + 1):
        with pytest.raises(InvalidSetting):
            approach_count(order)
    for wrong in ((-0.1, 0.2), (0.2, 0.1), (0.1, math.inf), (math.nan, 0.1)):
        with pytest.raises(InvalidSetting):
            approach_heights(1, *wrong)
    with pytest.raises(InvalidSetting):
        approach_points(np.eye(3)[:2], [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], 1, 0.1, 0.2)
    with pytest.raises(WrongShape):
        approach_points([[0.0, 0.0, 0.0]], UP, 1, 0.1, 0.2)
    with pytest.raises(NotFinite):
        approach_points([[0.0, 0.0, 0.0], [math.nan, 0.0, 0.0]], UP, 1, 0.1, 0.2)
