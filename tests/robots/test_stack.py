import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots.members import Plate, Stringer
from robots.panel import Part
from robots.sections import Section
from robots.stack import GAP, find_stacks
from robots.surface import Surface
from robots.sweeps import Grid
from tests.robots.panels import inside

FLAT = Grid(Surface(), 1.0, 1.0)
thicknesses = st.lists(st.floats(0.4e-3, 6e-3), min_size=1, max_size=6)
curved = st.builds(
    lambda rv, rh: Grid(Surface(rv, rh), 1.0, 1.0),
    st.one_of(st.none(), st.floats(1.0, 10.0)),
    st.one_of(st.none(), st.floats(1.0, 10.0)),
)


def layers(grid: Grid, sheets: list[float], gaps: list[float] | None = None) -> tuple[Part, ...]:
    """Sheets on each other from the skin inwards, with a gap before each of them if given."""
    parts, depth = [], 0.0
    for i, thickness in enumerate(sheets):
        depth += 0.0 if gaps is None else gaps[i]
        pieces = Plate((-0.4, 0.4), (-0.4, 0.4), depth, thickness).pieces(grid)
        parts.append(Part(f"sheet{i}", "doubler" if i else "skin", pieces))
        depth += thickness
    return tuple(parts)


def places(grid: Grid, seed: int, count: int = 20) -> tuple[Array, Array]:
    u, v = np.random.default_rng(seed).uniform(-0.39, 0.39, (2, count))
    return grid.surface.point(u, v), grid.surface.normal(u, v)


@given(thicknesses, st.integers(0, 2**31))
def test_flat_stack_is_exactly_the_sum_of_its_sheets(sheets: list[float], seed: int) -> None:
    parts = layers(FLAT, sheets)

    for stack in find_stacks(parts, *places(FLAT, seed)):
        assert stack.parts == tuple(part.id for part in parts)
        assert stack.depth == pytest.approx(sum(sheets), abs=1e-11)
        assert stack.grip == pytest.approx(sum(sheets), abs=1e-11)


def test_a_piece_within_another_of_its_part_does_not_end_the_part() -> None:
    (thick,), (first, thin) = layers(FLAT, [4e-3]), layers(FLAT, [1e-3, 1e-3])
    part = Part("skin", "skin", np.concatenate([thick.pieces, thin.pieces, first.pieces]))

    for stack in find_stacks((part,), *places(FLAT, 0)):
        assert (stack.depth, stack.grip) == pytest.approx((4e-3, 4e-3), abs=1e-11)


@settings(max_examples=40)
@given(curved, thicknesses, st.integers(0, 2**31))
def test_curved_stack_is_the_sum_within_the_chords(grid: Grid, sheets: list[float], seed: int) -> None:
    parts = layers(grid, sheets)
    deviation = grid.deviation(grid.along(-0.4, 0.4), grid.across(-0.4, 0.4))

    for stack in find_stacks(parts, *places(grid, seed)):
        assert stack.parts == tuple(part.id for part in parts)
        assert stack.grip == pytest.approx(sum(sheets), rel=2e-3)
        assert sum(sheets) - 1e-8 <= stack.depth <= sum(sheets) * 1.002 + deviation + 1e-8


@settings(max_examples=40)
@given(curved, st.integers(0, 2**31))
def test_depth_is_that_of_brute_force_along_the_axis(grid: Grid, seed: int) -> None:
    parts = layers(grid, [1.6e-3, 2.0e-3])
    pieces = np.concatenate([part.pieces for part in parts])
    points, normals = places(grid, seed, 4)

    for stack, p, n in zip(find_stacks(parts, points, normals), points, normals, strict=True):
        assert inside(pieces, p - (stack.depth - 1e-6) * n)
        assert not inside(pieces, p - (stack.depth + 1e-6) * n)


@given(st.floats(0.0, 1e-3), st.floats(0.0, 1e-3))
def test_stack_ends_at_the_first_real_gap(first: float, second: float) -> None:
    parts = layers(FLAT, [1.6e-3, 1.2e-3, 2.0e-3], [0.0, first, second])
    if min(abs(first - GAP), abs(second - GAP)) < 1e-6:
        return

    (stack,) = find_stacks(parts, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))

    joined = 1 if first > GAP else 2 if second > GAP else 3
    assert len(stack.parts) == joined
    assert stack.grip == pytest.approx(sum([1.6e-3, 1.2e-3, 2.0e-3][:joined]), abs=1e-11)


def test_a_point_a_little_off_the_skin_still_finds_it() -> None:
    parts = layers(FLAT, [1.6e-3, 1.6e-3])
    points = np.array([[0.0, 0.0, 0.5e-3], [0.0, 0.0, -0.5e-3], [0.0, 0.0, 2e-3], [2.0, 0.0, 0.0]])

    stacks = find_stacks(parts, points, np.tile([0.0, 0.0, 1.0], (4, 1)))

    assert [len(stack.parts) for stack in stacks] == [2, 2, 0, 0]
    assert stacks[0].depth == pytest.approx(3.7e-3)
    assert stacks[1].depth == pytest.approx(2.7e-3)


def test_axes_that_meet_nothing_have_stacks_without_parts() -> None:
    points, normals = places(FLAT, 1, 3)

    stacks = find_stacks(layers(FLAT, [1.6e-3]), points + np.array([2.0, 0.0, 0.0]), normals)

    assert [(stack.parts, stack.depth, stack.grip) for stack in stacks] == [((), 0.0, 0.0)] * 3


def test_axes_along_seams_between_facets_are_not_lost() -> None:
    grid = Grid(Surface(1.975, 8.1), 1.0, 1.0)
    parts = layers(grid, [1.6e-3, 1.6e-3])
    u, v = np.meshgrid(grid.along(-0.4, 0.4)[1:-1], grid.across(-0.4, 0.4)[1:-1])
    points, normals = grid.surface.point(u.ravel(), v.ravel()), grid.surface.normal(u.ravel(), v.ravel())

    for stack in find_stacks(parts, points, normals):
        assert stack.parts == ("sheet0", "sheet1")
        assert stack.depth == pytest.approx(3.2e-3, abs=1e-11)  # vertices are on the true surface


def test_an_axis_in_the_web_runs_through_foot_and_web() -> None:
    z = Section("Z", 0.030, 0.022, 0.0016, top=0.022)
    skin = layers(FLAT, [1.6e-3])
    stringer = Part("S", "stringer", Stringer(z, 0.0, -0.4, 0.4, 1.6e-3).pieces(FLAT))

    (stack,) = find_stacks((*skin, stringer), np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))

    assert stack.parts == ("sheet0", "S")
    assert stack.depth == pytest.approx(0.0316)
