import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from planners.arrays import Array
from tests.planners.toy_spaces import BoxSpace

points = arrays(float, (3,), elements=st.integers(-20, 20).map(lambda k: k / 4))
corners = st.tuples(points, points)


@given(points, points, st.lists(corners, max_size=4))
def test_the_exact_edge_test_agrees_with_dense_samples(
    a: Array, b: Array, boxes: list[tuple[Array, Array]]
) -> None:
    sorted_boxes = [(np.minimum(p, q).tolist(), np.maximum(p, q).tolist()) for p, q in boxes]
    space = BoxSpace([-5.0] * 3, [5.0] * 3, sorted_boxes)
    samples = a + np.linspace(0.0, 1.0, 257)[:, np.newaxis] * (b - a)
    hits = [
        any((np.array(low) <= q).all() and (q <= np.array(high)).all() for low, high in sorted_boxes)
        for q in samples
    ]

    free = space.edge_is_free(a, b)

    assert not (free and any(hits))
    assert space.is_free(a) != hits[0]
    assert free == space.edge_is_free(b, a)


def test_the_exact_edge_test_finds_a_graze_that_samples_miss() -> None:
    space = BoxSpace([0.0, 0.0], [4.0, 4.0], [((1.0, 1.0), (2.0, 2.0))])

    assert not space.edge_is_free(np.array([0.0, 2.0]), np.array([2.0, 0.0]))  # through the corner (1, 1)
    assert space.edge_is_free(np.array([0.0, 1.999]), np.array([1.999, 0.0]))


def test_advance_stops_short_of_the_box_and_is_itself_free() -> None:
    space = BoxSpace([0.0, 0.0], [4.0, 4.0], [((1.0, 0.0), (2.0, 2.0))])
    a, b = np.array([0.0, 1.0]), np.array([4.0, 1.0])

    reached = space.advance(a, b)

    assert 0.999 < reached[0] < 1.0
    assert space.edge_is_free(a, reached)
    assert np.array_equal(space.advance(a, reached), reached)
