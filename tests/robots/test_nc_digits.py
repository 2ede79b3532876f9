"""A program that has its digits already is not rounded number by number; any other one is."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.machine_file import load_machine
from robots.nc import AXIS_FIELDS, NcProgram
from robots.nc_digits import as_written, have_digits
from robots.nc_json import from_json, rounded, to_json
from robots.panel_file import load_panel
from service.programming import program_panel
from service.timing import Timing
from tests.service.conftest import CROSSING

MACHINE = load_machine("riveter")


@pytest.fixture(scope="module")
def program() -> NcProgram:
    made = program_panel(load_panel(CROSSING), MACHINE, list(MACHINE.dies), timing=Timing("overlap"))
    few = replace(made.program, blocks=made.program.blocks[:24], verification=None)
    return from_json(to_json(few))


def test_what_was_read_has_its_digits(program: NcProgram) -> None:
    assert have_digits(program.blocks)
    assert as_written(program).blocks is program.blocks
    assert as_written(program) == rounded(program) == program


NUMBERS = st.one_of(
    st.floats(-2e4, 2e4),
    st.floats(-2e4, 2e4).map(lambda value: round(value, 4)),
    st.floats(-2e4, 2e4).map(lambda value: round(value, 6)),
    st.sampled_from([0.0, -0.0, 5e-5, 1e-12, 2.0**49, 1e14, 0.1 + 0.2]),
)


@given(at=st.integers(0, 20), axis=st.sampled_from(AXIS_FIELDS), value=NUMBERS)
def test_axis_values_are_told_as_rounding_tells_them(
    program: NcProgram, at: int, axis: str, value: float
) -> None:
    blocks = list(program.blocks)
    blocks[at] = replace(blocks[at], axes=replace(blocks[at].axes, **{axis: value}))
    changed = replace(program, blocks=tuple(blocks))

    assert to_json(as_written(changed)) == to_json(rounded(changed))
    assert repr(as_written(changed)) == repr(rounded(changed))  # which tells 0.0 from -0.0
    if have_digits(changed.blocks):
        assert repr(rounded(changed)) == repr(changed)


@pytest.mark.parametrize("wrong", [float("nan"), float("inf"), 1e16])
def test_numbers_that_cannot_be_written_are_refused_as_ever(program: NcProgram, wrong: float) -> None:
    first, *rest = program.blocks
    changed = replace(program, blocks=(replace(first, t_end_s=wrong), *rest))

    for make in (as_written, rounded):
        with pytest.raises(ValueError, match=r"."):
            make(changed)


def test_limits_clearances_and_corners_are_looked_at(program: NcProgram) -> None:
    row = next(i for i, block in enumerate(program.blocks) if block.blend is not None)
    block = program.blocks[row]
    assert block.dynamics is not None
    assert block.blend is not None
    assert block.clearance is not None
    for other in (
        replace(block, dynamics=replace(block.dynamics, v_per_s=1.0000001)),
        replace(block, blend=replace(block.blend, deviation_mm=1.00001)),
        replace(block, clearance=replace(block.clearance, min_mm=1.00001)),
    ):
        assert not have_digits([other])
