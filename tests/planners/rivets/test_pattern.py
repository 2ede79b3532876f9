"""Where rivets of sheets, lap joints and stringers stand: laws over every size, and what does not fit."""

from collections.abc import Callable
from typing import Any, cast, get_args

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from planners.accessibility.rules import RowPlacement
from planners.arrays import Array
from planners.errors import InvalidSetting
from planners.rivets.pattern import (
    DoesNotFit,
    Layout,
    Material,
    Pattern,
    end_shortfall,
    lap_joint,
    sheet_pattern,
    stringer_rows,
)
from planners.rivets.sizing import DIAMETER_GRID, INCH

lengths = st.floats(0.02, 3.0)
diameters = st.integers(2, 12).map(lambda n: n * DIAMETER_GRID)
layouts = st.sampled_from(get_args(Layout))
placements = st.sampled_from(get_args(RowPlacement))
OFFSET = {"metal": 0.03 * INCH, "composite": 0.05 * INCH}
DIAMOND, WOOD, LEFT = (cast("Any", name) for name in ("diamond", "wood", "left"))
EDGE = {"metal": 2.0, "composite": 2.5}


def least_distance(points: Array) -> float:
    """The least distance of two points; infinite where there is one."""
    return float(cKDTree(points).query(points, k=2)[0][:, 1].min())


def fitting(pattern: Pattern | DoesNotFit) -> Pattern:
    assert isinstance(pattern, Pattern), pattern
    return pattern


@settings(max_examples=40)
@given(st.floats(0.05, 0.6), st.floats(0.02, 0.6), diameters, layouts, placements)
def test_sheet_keeps_its_distances(
    length: float, width: float, D: float, layout: Layout, placement: RowPlacement
) -> None:
    pattern = sheet_pattern(length, width, D, layout, placement)
    assume(isinstance(pattern, Pattern))

    pattern = fitting(pattern)
    S, B = pattern.spacing.side, pattern.spacing.pitch
    along, across = np.abs(pattern.points).T
    assert along.max() <= 0.5 * length - S + 1e-12
    assert across.max() <= 0.5 * width - S + 1e-9
    assert least_distance(pattern.points) >= B * (1.0 - 1e-9)
    assert np.allclose(np.diff(np.unique(pattern.points[:, 1])), B, rtol=1e-9)
    assert np.array_equal(pattern.rows, np.sort(pattern.rows))
    assert pattern.row_count == int(np.floor(width / B + 1e-9))


@settings(max_examples=40)
@given(lengths, st.floats(0.02, 1.0), diameters)
def test_zigzag_stands_midway_in_every_other_row(length: float, width: float, D: float) -> None:
    chain = sheet_pattern(length, width, D, "chain", "centred")
    zigzag = sheet_pattern(length, width, D, "zigzag", "centred")
    assume(isinstance(zigzag, Pattern))

    chain, zigzag = fitting(chain), fitting(zigzag)
    n = chain.spacing.count
    for row in range(zigzag.row_count):
        full, here = chain.points[chain.rows == row], zigzag.points[zigzag.rows == row]
        expected = full if row % 2 == 0 else 0.5 * (full[1:] + full[:-1])
        assert len(here) == n - row % 2
        assert np.allclose(here, expected)


def test_far_edge_rows_leave_the_rest_to_the_near_edge() -> None:
    pattern = fitting(sheet_pattern(1.0, 0.09, 0.005, "chain", "from_far_edge"))
    S = pattern.spacing.side

    across = np.unique(pattern.points[:, 1])

    assert 0.045 - across.max() == pytest.approx(S)
    assert across.min() + 0.045 > S


def test_a_sheet_narrower_than_a_pitch_does_not_fit() -> None:
    found = sheet_pattern(1.0, 0.019, 0.005, "chain", "centred")

    assert isinstance(found, DoesNotFit)
    assert found.needs == pytest.approx(0.02)
    assert found.has == 0.019


@given(diameters, st.floats(0.1, 1.99))
def test_a_row_too_short_for_one_rivet_does_not_fit(D: float, part: float) -> None:
    length = part * D

    for found in (
        sheet_pattern(length, length, D, "chain", "centred"),
        lap_joint(length, None, D, 1, "chain"),
        stringer_rows(length, 0.1, D, "metal", "zigzag", [0.0]),
    ):
        assert isinstance(found, DoesNotFit)
        assert found.needs == pytest.approx(2.0 * D)
        assert found.has == length


@settings(max_examples=40)
@given(lengths, diameters, st.integers(1, 3), layouts)
def test_lap_joint_fits_the_overlap_it_asks_for_and_no_less(
    length: float, D: float, rows: int, layout: Layout
) -> None:
    open_ended = lap_joint(length, None, D, rows, layout)
    assume(isinstance(open_ended, Pattern))

    pattern = fitting(open_ended)
    needs = rows * pattern.spacing.pitch
    assert np.array_equal(fitting(lap_joint(length, needs, D, rows, layout)).points, pattern.points)
    assert pattern.row_count == rows
    assert np.abs(pattern.points[:, 1]).max() == pytest.approx(0.5 * needs - pattern.spacing.side, abs=1e-12)
    tight = lap_joint(length, 0.999 * needs, D, rows, layout)
    assert isinstance(tight, DoesNotFit)
    assert (tight.needs, tight.has) == (needs, 0.999 * needs)


def test_a_zigzag_of_single_rivets_does_not_fit() -> None:
    assert isinstance(lap_joint(0.015, None, 0.004, 2, "zigzag"), DoesNotFit)
    assert isinstance(lap_joint(0.015, None, 0.004, 2, "chain"), Pattern)
    assert isinstance(lap_joint(0.015, None, 0.004, 1, "zigzag"), Pattern)


@given(
    lengths, st.floats(0.01, 0.06), diameters, st.sampled_from(get_args(Material)), layouts, st.integers(1, 4)
)
def test_stringer_rivets_keep_off_bend_and_edge(
    length: float, flange: float, D: float, material: Material, layout: Layout, stringers: int
) -> None:
    offsets = [0.1 * n for n in range(stringers)]
    assume(length >= 2.0 * D)

    found = stringer_rows(length, flange, D, material, layout, offsets)

    least = OFFSET[material] + D + EDGE[material] * D
    if isinstance(found, DoesNotFit):
        assert flange < least
        assert found.needs == pytest.approx(least)
        return
    assert flange >= least - 1e-9
    assert len(found.points) == stringers * found.spacing.count
    for row, offset in enumerate(offsets):
        along, across = found.points[found.rows == row].T
        assert np.allclose(np.diff(along), found.spacing.pitch)
        assert np.abs(along).max() == pytest.approx(0.5 * length - found.spacing.side)
        assert (across - offset).min() - D >= OFFSET[material] - 1e-9  # heads of 2 D
        assert flange - (across - offset).max() >= EDGE[material] * D - 1e-9
        if layout == "zigzag":
            assert np.allclose(across[::2] - offset, OFFSET[material] + D)
            assert np.allclose(across[1::2] - offset, flange - EDGE[material] * D)
        else:
            assert np.ptp(across) == 0.0


def test_flanges_that_lie_on_each_other_do_not_fit() -> None:
    found = stringer_rows(1.0, 0.03, 0.004, "metal", "chain", [0.2, 0.0, 0.029])

    assert isinstance(found, DoesNotFit)
    assert (found.needs, found.has) == pytest.approx((0.03, 0.029))


@pytest.mark.parametrize(("material", "edge"), EDGE.items())
def test_the_end_of_a_stringer_is_told_where_it_is_short_of_the_edge_distance(
    material: Material, edge: float
) -> None:
    pattern = fitting(stringer_rows(0.61, 0.03, 0.004, material, "zigzag", [0.0]))

    assert end_shortfall(pattern, 0.004, material) == pytest.approx(edge * 0.004 - pattern.spacing.side)
    assert end_shortfall(pattern, 0.001, material) == 0.0


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("rivets", lambda: sheet_pattern(90.0, 90.0, 0.001, "chain", "centred")),
        ("rivets", lambda: lap_joint(99.0, None, 0.0004, 3, "chain")),
        ("rivets", lambda: stringer_rows(99.0, 0.1, 0.0004, "metal", "chain", [0.0])),
        ("rivets", lambda: stringer_rows(60.0, 0.1, 0.001, "metal", "chain", [0.0, 1.0, 2.0, 3.0])),
        ("rows", lambda: lap_joint(1.0, None, 0.004, 4, "chain")),
        ("rows", lambda: lap_joint(1.0, None, 0.004, 0, "chain")),
        ("layout", lambda: lap_joint(1.0, None, 0.004, 1, DIAMOND)),
        ("layout", lambda: stringer_rows(1.0, 0.1, 0.004, "metal", DIAMOND, [0.0])),
        ("material", lambda: stringer_rows(1.0, 0.1, 0.004, WOOD, "chain", [0.0])),
        ("row_placement", lambda: sheet_pattern(1.0, 0.1, 0.004, "chain", LEFT)),
    ],
)
def test_what_no_pattern_is_made_of_is_refused_by_name(name: str, call: Callable[[], object]) -> None:
    with pytest.raises(InvalidSetting) as caught:
        call()

    assert caught.value.field == name
