"""Laws of rivet sizes and rows (spec.md, section 6), for every input."""

import math
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.errors import InvalidSetting
from planners.rivets.sizing import (
    DIAMETER_GRID,
    INCH,
    LENGTH_GRID,
    LONGEST,
    THICKEST,
    THINNEST,
    Rounding,
    rivet_size,
    row_spacing,
    rows_across,
)

thicknesses = st.floats(THINNEST, THICKEST)
sheets = st.lists(thicknesses, min_size=2, max_size=8)
lengths = st.floats(0.001, 20.0)
diameters = st.integers(1, 80).map(lambda n: n * DIAMETER_GRID)


@given(sheets)
def test_standard_sizes_are_multiples_of_the_grid_and_never_less_than_computed(stack: list[float]) -> None:
    size = rivet_size(stack, "standard")

    assert size.diameter_32nds is not None
    assert size.length_16ths is not None
    assert size.diameter == pytest.approx(size.diameter_32nds * DIAMETER_GRID, rel=1e-12)
    assert size.length == pytest.approx(size.length_16ths * LENGTH_GRID, rel=1e-12)
    assert 0.0 <= size.diameter - size.diameter_raw + 1e-12 < DIAMETER_GRID + 1e-12
    assert 0.0 <= size.length - size.length_raw + 1e-12 < LENGTH_GRID + 1e-12
    assert size.diameter_raw == 3.0 * max(stack)
    assert size.length_raw == pytest.approx(sum(stack) + 1.5 * size.diameter)


@given(thicknesses, thicknesses, st.floats(0.0, 0.01), st.sampled_from(get_args(Rounding)))
def test_sizes_never_shrink_when_a_sheet_grows(a: float, b: float, more: float, rounding: Rounding) -> None:
    thin, thick = rivet_size([a, b], rounding), rivet_size([min(a + more, THICKEST), b], rounding)

    assert thick.diameter >= thin.diameter
    assert thick.length >= thin.length - 1e-15


@given(st.integers(1, 200), st.integers(1, 200))
def test_mm_and_inch_give_the_same_rivet(a: int, b: int) -> None:
    inches = [max(each, 5) / 1000.0 for each in (a, b)]

    by_inch = rivet_size([each * INCH for each in inches], "standard")
    by_mm = rivet_size([each * 25.4 / 1000.0 for each in inches], "standard")

    assert (by_inch.diameter_32nds, by_inch.length_16ths) == (by_mm.diameter_32nds, by_mm.length_16ths)


@given(st.integers(1, 24))
def test_an_exact_multiple_is_not_bumped_up(steps: int) -> None:
    sheet = steps * DIAMETER_GRID / 3.0

    assert rivet_size([sheet, sheet], "standard").diameter_32nds == steps


@given(sheets)
def test_rounding_is_what_was_asked_for(stack: list[float]) -> None:
    standard, diameter, none = (rivet_size(stack, rounding) for rounding in get_args(Rounding))

    assert (diameter.diameter, diameter.length_raw) == (standard.diameter, standard.length_raw)
    assert (diameter.length, diameter.length_16ths) == (diameter.length_raw, None)
    assert (none.diameter, none.diameter_32nds) == (none.diameter_raw, None)
    assert (none.length, none.length_16ths) == (none.length_raw, None)


@given(lengths, diameters)
def test_laws_of_a_row(W: float, D: float) -> None:
    row = row_spacing(W, D)

    n, S, B = row.count, row.side, row.pitch
    assert (n - 1) * B + 2.0 * S == pytest.approx(W, rel=1e-12)
    assert pytest.approx(2.0 * S) == B
    assert B <= 4.0 * D * (1.0 + 1e-8)
    assert 4.0 * D * (n - 1) / n < B or n == 1


@given(diameters, st.integers(1, 300))
def test_a_row_that_is_an_exact_multiple_gets_no_rivet_more(D: float, n: int) -> None:
    assert row_spacing(4.0 * D * n, D).count == n


@given(st.floats(0.001, 10.0), st.floats(0.001, 1.0))
def test_rows_fill_the_width_and_no_more_would_fit(width: float, pitch: float) -> None:
    rows = rows_across(width, pitch)

    assert rows * pitch <= width + 1e-8 * pitch
    assert (rows + 1) * pitch > width


@pytest.mark.parametrize(
    "thickness", [0.0, -0.001, 0.99 * THINNEST, 1.01 * THICKEST, math.nan, math.inf], ids=str
)
def test_negative_and_absurd_thicknesses_are_refused_by_place(thickness: float) -> None:
    with pytest.raises(InvalidSetting, match=r"thicknesses\[1\]"):
        rivet_size([0.002, thickness], "standard")


@pytest.mark.parametrize("stack", [[], [0.002], [0.002] * 9], ids=len)
def test_a_joint_has_two_to_eight_sheets(stack: list[float]) -> None:
    with pytest.raises(InvalidSetting, match="thicknesses"):
        rivet_size(stack, "standard")


@pytest.mark.parametrize("length", [0.0, -1.0, math.nan, math.inf, 1.01 * LONGEST], ids=str)
def test_absurd_lengths_are_refused(length: float) -> None:
    with pytest.raises(InvalidSetting, match="row_length"):
        row_spacing(length, 0.004)
    with pytest.raises(InvalidSetting, match="diameter"):
        row_spacing(1.0, length)
    with pytest.raises(InvalidSetting, match="width"):
        rows_across(length, 0.02)


def test_unknown_rounding_is_refused() -> None:
    with pytest.raises(InvalidSetting, match="rounding"):
        rivet_size([0.002, 0.002], "nearest")  # type: ignore[arg-type]
