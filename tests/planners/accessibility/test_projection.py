"""Views, segments' corner cases and totals."""

import numpy as np
import pytest

from planners.accessibility.obstacles import Box
from planners.accessibility.projection import orthographic, outline
from planners.accessibility.segments import meeting
from planners.accessibility.summary import AccessClass, AccessStatus, AccessSummary
from planners.accessibility.tool import Tool

BOX = Box(1.0, 2.0, 4.0, 2.0, 0.0, 0.5, 3.0)


def test_views_keep_true_sizes_without_depth() -> None:
    points = np.array([[1.0, 2.0, 3.0], [-4.0, 5.0, -6.0]])

    assert orthographic(points, "top").tolist() == [[1.0, 2.0], [-4.0, 5.0]]
    assert orthographic(points, "side").tolist() == [[1.0, 3.0], [-4.0, -6.0]]
    assert orthographic(points, "left", scale=0.5).tolist() == [[1.0, 1.5], [2.5, -3.0]]


def test_outlines_of_a_box_are_its_faces() -> None:
    assert outline(BOX, "top").bounds == (1.0, 2.0, 5.0, 4.0)
    assert outline(BOX, "side").bounds == (1.0, 0.5, 5.0, 3.5)
    assert outline(BOX, "left").bounds == (2.0, 0.5, 4.0, 3.5)
    assert outline(BOX, "top").equals(BOX.footprint)


def test_turned_box_has_its_footprint_from_above() -> None:
    turned = Box(1.0, 2.0, 4.0, 2.0, 0.7, 0.5, 3.0)

    assert outline(turned, "top").symmetric_difference(turned.footprint).area == pytest.approx(0.0, abs=1e-9)
    assert outline(turned, "side").area > 4.0 * 3.0


def test_body_of_a_tool_is_a_box_about_its_rivet() -> None:
    body = Tool(4.0, 2.0, 0.3, 6.0, 1.0, default_axis=0.5 * np.pi).body_at(np.array([10.0, 20.0]))

    assert outline(body, "top").bounds == pytest.approx((9.0, 18.0, 11.0, 22.0))
    assert outline(body, "side").bounds == pytest.approx((9.0, 1.0, 11.0, 7.0))


@pytest.mark.parametrize(
    ("first", "second", "kind"),
    [
        ([[1, 0], [2, 0]], [[0, 0], [4, 0]], "overlap"),
        ([[0, 0], [0, 4]], [[0, 4], [0, 9]], "point"),
        ([[0, 0], [0, 4]], [[0, 5], [0, 9]], "none"),
        ([[0, 0], [4, 0]], [[5, -1], [5, 1]], "none"),
    ],
)
def test_segments_that_the_printed_tests_get_wrong(
    first: list[list[float]], second: list[list[float]], kind: str
) -> None:
    assert meeting(np.array(first, dtype=np.float64), np.array(second, dtype=np.float64)) == kind


@pytest.mark.parametrize(
    ("counts", "status", "name"),
    [
        ((81, 0, 19), "Has some limitations", "accessible"),
        ((40, 40, 20), "Has some limitations", "modify_tool"),
        ((0, 50, 50), "Has some limitations", "modify_tool"),
        ((49, 0, 51), "Has some limitations", "crowded"),
        ((0, 7, 0), "Accessible", "accessible"),
        ((0, 0, 3), "Has some limitations", "crowded"),
        ((0, 0, 0), "Has some limitations", None),
    ],
)
def test_status_and_class_follow_the_counts(
    counts: tuple[int, int, int], status: AccessStatus, name: AccessClass | None
) -> None:
    summary = AccessSummary(*counts)

    assert (summary.status, summary.access_class) == (status, name)
    assert (summary.percent is None) == (summary.total == 0)
