"""Numbers as the program's text holds them: the formats, and rounding without the text."""

import math
import random
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from decimal import ROUND_FLOOR, Context, Decimal
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.errors import InvalidInput
from robots.machine_file import load_machine
from robots.nc import Certificate, NcChecker, NcMinClearance, NcProgram
from robots.nc_codec import Decimals, DecimalsDown, SignificantDown
from robots.nc_json import from_json, rounded, to_json
from tests.robots.nc_samples import sample

PROGRAM = sample(load_machine("riveter"))
FLOATS = st.floats(min_value=-1e9, max_value=1e9, allow_nan=False)
CERTIFICATE = Certificate(
    checker=NcChecker("test", "1"),
    result="clean",
    findings=(),
    min_clearance=NcMinClearance(1.25, ("arm", "skin"), 10, 0.5),
    certified_blocks=1,
    samples=0,
    program_sha256="0" * 64,
    inputs=PROGRAM.header.inputs,
)


def number(rng: random.Random) -> float:
    """Some number, often with a format's digits, or nearly: where a short way of rounding may go wrong."""
    sort = rng.randrange(6)
    if sort == 0:
        return rng.choice(
            [0.0, -0.0, 5e-324, -1e-9, 0.00005, 2.675, 1e10, 123456.7, 999999.5, 1234567.0, 0.1]
        )
    if sort == 1:
        return rng.choice([-1.0, 1.0]) * math.exp(rng.uniform(-27.0, 34.5))
    digits, decimals = rng.randrange(1, 16), rng.randrange(-3, 12)
    exact: float = rng.randrange(-(10**digits), 10**digits) / 10.0**decimals
    exact = exact if abs(exact) < 1e15 else 0.25
    return exact if sort < 5 else math.nextafter(exact, rng.choice([-math.inf, math.inf]))


NUMBERS = st.integers(0, 2**63).map(lambda seed: number(random.Random(seed)))


def altered(tree: Any, value: Callable[[Any], Any]) -> Any:
    """A tree of dataclasses and tuples with `value` of every leaf that is no text."""
    if is_dataclass(tree) and not isinstance(tree, type):
        return replace(tree, **{f.name: altered(getattr(tree, f.name), value) for f in fields(tree)})
    if isinstance(tree, tuple):
        return tuple(altered(item, value) for item in tree)
    return value(tree)


def by_the_text(program: NcProgram) -> NcProgram | str:
    """The program as a reader of its text sees it, or what is wrong with it."""
    return outcome(lambda: from_json(to_json(program)))


def outcome(work: Callable[[], NcProgram]) -> NcProgram | str:
    try:
        return work()
    except (InvalidInput, ValueError, TypeError, AttributeError) as error:
        return f"{type(error).__name__}: {error}"


class TestRounding:
    """`rounded` is writing and reading back, without the text."""

    @given(st.integers(0, 2**63).map(random.Random))
    def test_every_number_is_what_is_read_back(self, rng: random.Random) -> None:
        part = replace(
            PROGRAM, blocks=PROGRAM.blocks[1:4], fasteners=PROGRAM.fasteners[:1], verification=CERTIFICATE
        )
        program = altered(part, lambda leaf: number(rng) if type(leaf) is float else leaf)

        assert repr(outcome(lambda: rounded(program))) == repr(by_the_text(program))

    def test_what_is_rounded_already_stays_the_object_it_is(self) -> None:
        assert rounded(PROGRAM) is PROGRAM

    def test_a_negative_zero_is_none_in_the_text(self) -> None:
        program = altered(PROGRAM, lambda leaf: -0.0 if leaf == 0.0 and type(leaf) is float else leaf)

        assert program == PROGRAM
        assert repr(program) != repr(PROGRAM)
        assert repr(rounded(program)) == repr(PROGRAM)

    @pytest.mark.parametrize(
        "change",
        [
            {"n": True}, {"n": 10.0}, {"n": 2**63}, {"n": None}, {"n": np.int64(10)}, {"kind": "dance"},
            {"kind": None}, {"die_id": None}, {"die_id": "\ud800"}, {"die_id": "\U0001f600 é"}, {"die_id": 3},
            {"t_end_s": math.nan}, {"t_end_s": -math.inf}, {"t_end_s": 1e15}, {"t_end_s": 2e15},
            {"t_end_s": np.float64(0.1)}, {"t_end_s": True}, {"t_end_s": "1"}, {"t_end_s": None},
            {"t_end_s": 7}, {"axes": None},
            {"dynamics": 1.0}, {"allowed_contacts": (("a",),)}, {"allowed_contacts": (("a", "b", "c"),)},
            {"allowed_contacts": [["a", "b"]]}, {"allowed_contacts": None}, {"events": ()},
        ],
        ids=str,
    )  # fmt: skip
    def test_what_no_reader_takes_is_refused_alike(self, change: dict[str, Any]) -> None:
        program = replace(PROGRAM, blocks=(replace(PROGRAM.blocks[1], **change),))

        assert repr(outcome(lambda: rounded(program))) == repr(by_the_text(program))

    def test_another_dataclass_in_the_place_of_one_is_refused_alike(self) -> None:
        program = replace(PROGRAM, header=PROGRAM.header.inputs)  # type: ignore[arg-type]

        for work in (rounded, lambda p: from_json(to_json(p))):
            with pytest.raises((AttributeError, InvalidInput)):
                work(program)


class TestFormats:
    @given(NUMBERS)
    def test_decimals_down_are_the_floor_of_the_shortest_decimal(self, value: float) -> None:
        exact = Decimal(repr(value)).quantize(Decimal("0.0001"), rounding=ROUND_FLOOR)

        assert DecimalsDown(4).text(value) == f"{abs(exact) if exact == 0 else exact:f}"

    @given(NUMBERS)
    def test_significant_digits_down_are_the_floor_of_the_shortest_decimal(self, value: float) -> None:
        exact = Context(prec=6, rounding=ROUND_FLOOR).plus(Decimal(repr(value)))

        assert SignificantDown(6).text(value) == f"{abs(exact) if exact == 0 else exact:f}"

    @given(NUMBERS)
    def test_the_rounded_number_is_the_one_in_the_text(self, value: float) -> None:
        for form in (Decimals(4), Decimals(6), Decimals(9), DecimalsDown(4), SignificantDown(6)):
            assert repr(form.rounded(value)) == repr(float(form.text(value)))

    @given(FLOATS)
    def test_decimals_are_the_nearest(self, value: float) -> None:
        text = Decimals(4).text(value)

        assert abs(float(text) - value) <= 0.5e-4 * (1 + 1e-9) + abs(value) * 1e-15
        assert Decimals(4).text(float(text)) == text
        assert not (text.startswith("-") and float(text) == 0.0)

    @given(FLOATS)
    def test_decimals_down_never_rise(self, value: float) -> None:
        text = DecimalsDown(4).text(value)

        assert value - 1.0001e-4 - abs(value) * 1e-15 <= float(text) <= value
        assert DecimalsDown(4).text(float(text)) == text

    @given(st.floats(min_value=1e-6, max_value=1e9))
    def test_significant_digits_down_never_rise(self, value: float) -> None:
        text = SignificantDown(6).text(value)

        assert value * (1.0 - 1e-5) <= float(text) <= value
        assert SignificantDown(6).text(float(text)) == text
        assert "e" not in text.lower()

    def test_a_limit_with_few_digits_stays_as_it_is(self) -> None:
        assert SignificantDown(6).text(0.1) == "0.1"
        assert DecimalsDown(4).text(2.3) == "2.3000"
        assert DecimalsDown(4).text(-0.00001) == "-0.0001"
