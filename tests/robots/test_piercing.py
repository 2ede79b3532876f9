import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from planners.arrays import Array
from robots import bodies, hexahedra
from robots.broad_phase import TooCrowdedError
from robots.panel import Part
from robots.piercing import CONTACT, find_piercings, overlap_depths

MM = 1e-3
pair = np.array([0]), np.array([1])


def part(name: str, pieces: Array) -> Part:
    return Part(name, "box", pieces)


def cube(centre: list[float], size: list[float], angles: list[float] | None = None) -> Array:
    return bodies.box(np.array(size), bodies.pose(np.array(centre), np.array(angles or [0.0, 0.0, 0.0])))


def inscribed_radius(a: Array, b: Array) -> float:
    """Radius of the largest ball inside both solids, by linear programming; negative when they are apart."""
    normals, offsets = hexahedra.planes(np.stack([a, b]))
    A = np.hstack([normals.reshape(-1, 3), np.ones((12, 1))])
    result = linprog([0, 0, 0, -1], A_ub=A, b_ub=offsets.ravel(), bounds=[(None, None)] * 4)
    return float(result.x[3])


coordinate = st.floats(-0.02, 0.02)
angle = st.floats(-3.2, 3.2)
triple = st.tuples(coordinate, coordinate, coordinate)
angles = st.tuples(angle, angle, angle)
sizes = st.tuples(*[st.floats(0.001, 0.03)] * 3)


@settings(max_examples=300)
@given(triple, sizes, angles, sizes)
def test_separating_axes_agree_with_linear_programming(
    centre: tuple[float, ...], size: tuple[float, ...], turn: tuple[float, ...], other: tuple[float, ...]
) -> None:
    solids = np.concatenate([cube([0.0, 0.0, 0.0], list(other)), cube(list(centre), list(size), list(turn))])
    radius = inscribed_radius(solids[0], solids[1])

    (depth,) = overlap_depths(solids, *pair)

    if depth > CONTACT:
        assert radius > 0.0  # deep overlap: there is room for a ball in both
    if radius > 0.5 * CONTACT + 1e-9:
        assert depth > CONTACT  # a ball of that size cannot be left with less
    if radius < -1e-9:
        assert depth <= CONTACT  # apart, or nearly so along the axes looked at


@given(st.floats(-1.0, 1.0), st.floats(0.002, 0.02))
def test_depth_of_parallel_boxes_is_their_overlap(overlap_mm: float, size: float) -> None:
    a, b = cube([0, 0, 0], [size] * 3), cube([size - overlap_mm * MM, 0.0, 0.0], [size] * 3)

    found = find_piercings((part("a", a), part("b", b)))

    if abs(overlap_mm - 0.3) > 1e-6:
        assert len(found) == (overlap_mm > 0.3)
    if found:
        assert found[0].depth == pytest.approx(overlap_mm * MM)


def test_crossed_edges_need_more_than_face_normals() -> None:
    """Two long bars, edge above edge: every face normal sees an overlap, the crossed edges do not."""
    lower = cube([0.0, 0.0, 0.0], [0.1, 0.01, 0.01], [np.pi / 4, 0.0, 0.0])
    apart = cube([0.0, 0.0, 0.0143], [0.01, 0.1, 0.01], [0.0, np.pi / 4, 0.0])
    inside = cube([0.0, 0.0, 0.0135], [0.01, 0.1, 0.01], [0.0, np.pi / 4, 0.0])

    assert find_piercings((part("a", lower), part("b", apart))) == []
    (found,) = find_piercings((part("a", lower), part("b", inside)))
    assert found.depth == pytest.approx(2 * 0.01 / np.sqrt(2) - 0.0135)


def test_thin_sheets_crossing_each_other_are_found() -> None:
    upright = cube([0.0, 0.0, 0.0], [0.0016, 0.3, 0.1])
    across = cube([0.0, 0.0, 0.0], [0.3, 0.0016, 0.1])

    (found,) = find_piercings((part("a", upright), part("b", across)))

    assert (found.first, found.second) == (0, 1)


def test_pieces_of_one_part_may_overlap() -> None:
    pieces = np.concatenate([cube([0, 0, 0], [0.01] * 3), cube([0.001, 0, 0], [0.01] * 3)])

    assert find_piercings((part("a", pieces), part("b", cube([0.05, 0, 0], [0.01] * 3)))) == []


def test_each_pair_of_parts_is_told_once_with_its_worst_depth() -> None:
    comb = np.concatenate([cube([0.02 * i, 0, 0], [0.01, 0.01, 0.01]) for i in range(4)])
    bar = cube([0.03, 0.0, 0.008], [0.1, 0.004, 0.008], [0.0, np.radians(0.2), 0.0])

    (found,) = find_piercings((part("comb", comb), part("bar", bar)))

    deepest = max(float(d) for d in overlap_depths(np.concatenate([comb, bar]), np.arange(4), np.full(4, 4)))
    assert found.depth == deepest > CONTACT


def test_a_crowd_of_parts_is_refused() -> None:
    crowd = np.concatenate([cube([0.0, 0.0, 1e-5 * i], [0.01] * 3) for i in range(300)])

    with pytest.raises(TooCrowdedError):
        find_piercings((part("a", crowd), part("b", crowd)))
