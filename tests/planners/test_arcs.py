"""Arcs: through their points, the same however they are given, and none where there is none."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planners.arcs import angle_of_chord, arc_of_radius, arc_through
from planners.arrays import Array
from planners.errors import Collinear, InvalidSetting, NotFinite, WrongShape
from planners.rotations import matrix_of_euler

turns = st.builds(matrix_of_euler, *[st.floats(-3.0, 3.0)] * 3)
centres = st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3).map(np.array)
radii = st.floats(0.01, 20.0)
angles = st.floats(0.05, 6.2)


def circle(R: Array, centre: Array, radius: float, theta: float) -> Array:
    return centre + radius * (R @ [math.cos(theta), math.sin(theta), 0.0])


@given(turns, centres, radii, angles, st.floats(0.1, 0.9))
def test_arc_through_three_points_is_the_one_they_were_taken_from(
    R: Array, centre: Array, radius: float, angle: float, part: float
) -> None:
    F1, F2, F3 = (circle(R, centre, radius, theta) for theta in (0.0, angle, part * angle))

    arc = arc_through(F1, F2, F3)

    assert np.allclose(arc.centre, centre, atol=1e-7)
    assert arc.radius == pytest.approx(radius, rel=1e-7)
    assert arc.angle == pytest.approx(angle, rel=1e-6)
    assert arc.length == pytest.approx(radius * angle, rel=1e-6)
    assert np.allclose(arc.at([0.0, arc.angle, part * arc.angle]), [F1, F2, F3], atol=1e-7)
    assert np.allclose([arc.e1 @ arc.e1, arc.e2 @ arc.e2, arc.e1 @ arc.e2], [1.0, 1.0, 0.0])


@settings(max_examples=40)
@given(turns, centres, radii, angles, st.permutations([0, 1, 2]))
def test_centre_and_radius_do_not_depend_on_the_order_of_the_points(
    R: Array, centre: Array, radius: float, angle: float, order: list[int]
) -> None:
    points = [circle(R, centre, radius, theta) for theta in (0.0, angle, 0.5 * angle)]

    arc, other = arc_through(*points), arc_through(*(points[i] for i in order))

    assert np.allclose(arc.centre, other.centre, atol=1e-7)
    assert arc.radius == pytest.approx(other.radius, rel=1e-7)


@given(turns, centres, radii, st.floats(0.05, math.pi))
def test_two_points_and_a_radius_give_the_arc_that_three_points_give(
    R: Array, centre: Array, radius: float, angle: float
) -> None:
    F1, F2, F3 = (circle(R, centre, radius, theta) for theta in (0.0, angle, 0.5 * angle))

    arc, other = arc_of_radius(F1, F2, radius, centre - F3), arc_through(F1, F2, F3)

    assert np.allclose(arc.centre, centre, atol=1e-6)
    assert arc.angle == pytest.approx(angle, rel=1e-6)
    assert np.allclose(arc.at([0.0, arc.angle, 0.5 * arc.angle]), [F1, F2, F3], atol=1e-6)
    assert np.allclose(arc.e2, other.e2, atol=1e-6)


@given(radii, st.floats(0.01, 100.0))
def test_the_length_of_the_direction_to_the_centre_does_not_matter(radius: float, length: float) -> None:
    ends = [0.0, 0.0, 0.0], [radius, 0.0, 0.0]

    assert np.allclose(
        arc_of_radius(*ends, radius, [0.0, 0.0, -length]).centre,
        arc_of_radius(*ends, radius, [0.0, 0.0, -1.0]).centre,
    )


def test_a_half_circle_may_be_too_long_by_rounding_only() -> None:
    half = arc_of_radius([0.0, 0.0, 0.0], [2.0 + 1e-10, 0.0, 0.0], 1.0, [0.0, 1.0, 0.0])

    assert half.angle == math.pi
    assert np.allclose(half.at(0.5 * math.pi), [1.0, -1.0, 0.0])
    with pytest.raises(InvalidSetting, match="radius"):
        arc_of_radius([0.0, 0.0, 0.0], [2.0 + 1e-7, 0.0, 0.0], 1.0, [0.0, 1.0, 0.0])


@given(turns, centres, st.floats(-3.0, 3.0), st.floats(1e-3, 1e3))
def test_points_on_a_line_have_no_arc(R: Array, start: Array, part: float, scale: float) -> None:
    way = scale * R[:, 0]

    with pytest.raises(Collinear):
        arc_through(start, start + way, start + round(part, 2) * way)


@settings(max_examples=40)
@given(centres, centres)
def test_points_that_coincide_have_no_arc(a: Array, b: Array) -> None:
    assume(np.abs(a - b).max() > 1e-6)

    for points in ((a, a, b), (a, b, a), (b, a, a), (a, a, a)):
        with pytest.raises(Collinear):
            arc_through(*points)
    with pytest.raises(Collinear):
        angle_of_chord(a, a, 1.0)


@pytest.mark.parametrize(
    ("radius", "direction"),
    [(0.4, [0.0, 1.0, 0.0]), (math.nan, [0.0, 1.0, 0.0]), (math.inf, [0.0, 1.0, 0.0]),
     (-1.0, [0.0, 1.0, 0.0]), (1.0, [0.0, 0.0, 0.0]), (1.0, [0.1, 1.0, 0.0])],
)  # fmt: skip
def test_radii_and_directions_that_fit_no_arc_are_refused(radius: float, direction: list[float]) -> None:
    with pytest.raises(InvalidSetting):
        arc_of_radius([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], radius, direction)


def test_points_have_three_finite_parts() -> None:
    with pytest.raises(WrongShape, match="F3"):
        arc_through([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0])
    with pytest.raises(NotFinite, match="F2"):
        arc_through([0.0, 0.0, 0.0], [math.nan, 0.0, 0.0], [0.0, 1.0, 0.0])
