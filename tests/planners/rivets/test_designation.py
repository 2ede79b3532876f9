from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.errors import InvalidSetting
from planners.rivets.designation import Designation, Standard, designation_of, parse_designation
from planners.rivets.sizing import INCH, rivet_size

designations = st.builds(
    Designation,
    standard=st.sampled_from(get_args(Standard)),
    head=st.text("0123456789", min_size=3, max_size=4),
    alloy=st.text("ABCDEKMXZ", min_size=1, max_size=2),
    diameter_32nds=st.integers(1, 999),
    length_16ths=st.integers(1, 999),
)


@settings(max_examples=40)
@given(designations)
def test_parsing_is_the_inverse_of_writing(code: Designation) -> None:
    assert parse_designation(str(code)) == code


def test_the_code_of_the_thesis_is_read_with_and_without_blanks() -> None:
    code = parse_designation("MS20 426 AD 5 - 8")

    assert str(code) == "MS20426AD5-8"
    assert (code.diameter, code.length) == pytest.approx((5 / 32 * INCH, 8 / 16 * INCH))


@pytest.mark.parametrize(
    "text",
    ["", "MS20426AD5", "MS20426AD-8", "MS2426AD5-8", "ms20426ad5-8", "MS20426AD5-8x", "MS20426AD0-8",
     "MS20426AD5-0", "MS20426AD5--8", "MS20426AD5.5-8", "MS20426AD\u0665-8", "MS20426ADX5-8",
     "MS20426AD5-1000"],
)  # fmt: skip
def test_what_is_no_code_is_refused(text: str) -> None:
    with pytest.raises(InvalidSetting):
        parse_designation(text)


@pytest.mark.parametrize(
    ("field", "value"),
    [("standard", "EN"), ("head", "42"), ("alloy", "ad"), ("diameter_32nds", 0), ("length_16ths", 1000)],
)
def test_parts_that_no_code_has_are_refused_by_name(field: str, value: object) -> None:
    parts: dict[str, object] = {
        "standard": "MS20", "head": "426", "alloy": "AD", "diameter_32nds": 5, "length_16ths": 8,
    }  # fmt: skip

    with pytest.raises(InvalidSetting, match=field):
        Designation(**(parts | {field: value}))  # type: ignore[arg-type]


def test_only_a_rounded_size_has_a_code() -> None:
    sheets = [0.0016, 0.0016]

    assert str(designation_of(rivet_size(sheets, "standard"), "NAS", "1097", "KE")) == "NAS1097KE7-8"
    assert designation_of(rivet_size(sheets, "diameter"), "MS20", "426", "AD") is None
    assert designation_of(rivet_size(sheets, "none"), "MS20", "426", "AD") is None
