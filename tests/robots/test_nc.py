"""The NC program's text: canonical, exact on reading back, and a reader that names all that is wrong."""

import json
import math
import pickle
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.errors import InvalidInput
from robots.machine_file import load_machine
from robots.nc import Certificate, NcAxes, NcChecker, NcProgram
from robots.nc_codec import encode
from robots.nc_json import from_json, program_id, program_sha256, rounded, to_json, with_certificate
from tests.robots.nc_samples import sample

MACHINE = load_machine("riveter")
PROGRAM = sample(MACHINE)
FLOATS = st.floats(min_value=-1e9, max_value=1e9, allow_nan=False)


def certificate(program: NcProgram) -> Certificate:
    inputs = program.header.inputs
    return Certificate(
        NcChecker("test", "1"), "clean", (), None, len(program.blocks), 0, program_sha256(program), inputs
    )


def problems(text: str | bytes) -> dict[str, str]:
    """Pointer to code of everything the reader finds wrong."""
    with pytest.raises(InvalidInput) as caught:
        from_json(text)
    return {problem.pointer: problem.code for problem in caught.value.problems}


def edited(edit: Callable[[Any], Any]) -> str:
    """The sample's text after `edit` changed its parsed form in place."""
    data = json.loads(to_json(PROGRAM))
    edit(data)
    return json.dumps(data)


CERTIFICATE = certificate(PROGRAM)


class TestWriting:
    def test_the_file_is_the_hashed_text_with_the_certificate_at_its_end(self) -> None:
        certified = with_certificate(PROGRAM, CERTIFICATE)

        for program in (PROGRAM, certified, with_certificate(replace(PROGRAM, dies=()), CERTIFICATE)):
            assert to_json(program) == f"{encode(program)}\n".encode()
        assert json.loads(to_json(certified))["verification"]["result"] == "clean"

    def test_a_program_crosses_a_process_and_stays_what_it_is(self) -> None:
        certified = with_certificate(PROGRAM, CERTIFICATE)

        assert pickle.loads(pickle.dumps(certified)) == certified

    def test_what_cannot_be_written_can_have_a_certificate_that_says_so(self) -> None:
        broken = replace(PROGRAM, blocks=(replace(PROGRAM.blocks[1], t_end_s=math.nan),))

        assert with_certificate(broken, CERTIFICATE).verification == CERTIFICATE

    def test_a_changed_program_has_its_own_text(self) -> None:
        before = to_json(PROGRAM)

        assert to_json(replace(PROGRAM, blocks=PROGRAM.blocks[:2])) != before
        assert to_json(PROGRAM) == before

    def test_what_is_written_is_read_back_exactly(self) -> None:
        for program in (PROGRAM, with_certificate(PROGRAM, certificate(PROGRAM))):
            assert from_json(to_json(program)) == program

    def test_the_text_is_canonical(self) -> None:
        text = to_json(PROGRAM)

        assert to_json(from_json(text)) == text
        assert text.isascii()
        assert b" :" not in text
        keys = list(json.loads(text))
        assert keys == sorted(keys)

    def test_every_number_has_the_digits_of_its_unit(self) -> None:
        moved = replace(PROGRAM.blocks[1], axes=NcAxes(1.0, -0.00004, 1 / 3, 1 / 3, -1e-9, 2.5, 90.0))
        text = to_json(replace(PROGRAM, blocks=(moved,))).decode()

        assert (
            '"axes":{"A_deg":0.333333,"B_deg":0.000000,"C_deg":90.000000,"W_mm":2.5000,"X_mm":1.0000,'
            '"Y_mm":0.0000,"Z_mm":0.3333}' in text
        )

    def test_numbers_that_are_none_cannot_be_written(self) -> None:
        broken = replace(PROGRAM.blocks[1], t_end_s=math.nan)

        with pytest.raises(ValueError, match="cannot hold nan"):
            to_json(replace(PROGRAM, blocks=(broken,)))

    def test_rounding_twice_changes_nothing(self) -> None:
        raw = replace(PROGRAM, blocks=(replace(PROGRAM.blocks[1], t_end_s=math.pi),))

        assert rounded(rounded(raw)) == rounded(raw)
        assert rounded(raw).blocks[0].t_end_s == 3.141593

    def test_axes_and_configuration_convert_into_each_other(self) -> None:
        q = np.array([6.1, -0.2, 0.3, 0.4, -0.1, 0.25, -2.0])

        assert np.allclose(NcAxes.of(q).q, q, atol=1e-7)
        assert NcAxes.of(NcAxes.of(q).q) == NcAxes.of(q)
        assert NcAxes.of(np.zeros(7)).X_mm == 0.0
        assert not NcAxes.of(q).q.flags.writeable

    @given(st.lists(FLOATS.map(lambda x: x / 1e9 * 4.0), min_size=7, max_size=7))
    def test_axes_of_a_configuration_are_already_rounded(self, values: list[float]) -> None:
        axes = NcAxes.of(np.array(values))
        block = replace(PROGRAM.blocks[1], axes=axes)

        assert rounded(replace(PROGRAM, blocks=(block,))).blocks[0].axes == axes


class TestIdentity:
    def test_the_certificate_is_not_part_of_it(self) -> None:
        assert program_sha256(with_certificate(PROGRAM, certificate(PROGRAM))) == program_sha256(PROGRAM)

    def test_any_other_change_is(self) -> None:
        block = PROGRAM.blocks[3]
        nudged = replace(block, axes=replace(block.axes, W_mm=block.axes.W_mm + 1e-4))
        others = (
            replace(PROGRAM, blocks=(*PROGRAM.blocks[:3], nudged, *PROGRAM.blocks[4:])),
            replace(PROGRAM, header=replace(PROGRAM.header, title="x")),
            replace(PROGRAM, fasteners=PROGRAM.fasteners[::-1]),
        )

        assert len({program_sha256(p) for p in (PROGRAM, *others)}) == 4

    def test_a_change_below_the_last_digit_is_none(self) -> None:
        block = PROGRAM.blocks[3]
        same = replace(block, axes=replace(block.axes, W_mm=block.axes.W_mm + 1e-6))

        assert program_sha256(replace(PROGRAM, blocks=(*PROGRAM.blocks[:3], same, *PROGRAM.blocks[4:]))) == (
            program_sha256(PROGRAM)
        )

    def test_the_program_id_depends_on_inputs_and_seed(self) -> None:
        header = PROGRAM.header
        other = replace(header.planner, seed=8)

        assert program_id(header.inputs, header.planner) == header.program_id
        assert len(header.program_id) == 16
        assert program_id(header.inputs, other) != header.program_id


class TestReading:
    def test_all_problems_come_at_once_with_their_pointers(self) -> None:
        def break_it(data: Any) -> None:
            del data["blocks"][1]["axes"]["X_mm"]
            data["blocks"][2]["kind"] = "dance"
            data["blocks"][3]["n"] = "40"
            data["policy"]["clearance_mm"]["default"] = None
            data["surprise"] = 1

        assert problems(edited(break_it)) == {
            "/blocks/1/axes/X_mm": "missing_field",
            "/blocks/2/kind": "wrong_type",
            "/blocks/3/n": "wrong_type",
            "/policy/clearance_mm/default": "wrong_type",
            "/surprise": "unknown_field",
        }

    @pytest.mark.parametrize("value", ["NaN", "Infinity", "-Infinity", "1e400", "1e16", "true", '"1"', "[1]"])
    def test_what_is_no_finite_number_is_refused(self, value: str) -> None:
        text = to_json(PROGRAM).decode().replace('"W_mm":331.8000', f'"W_mm":{value}', 1)

        assert list(problems(text).values()) == ["wrong_type"]

    @pytest.mark.parametrize("value", [True, 1.0, "1", None, 2**63, -(2**70)])
    def test_what_is_no_integer_is_refused(self, value: object) -> None:
        text = edited(lambda d: d["header"]["planner"].update(seed=value))

        assert problems(text) == {"/header/planner/seed": "wrong_type"}

    @pytest.mark.parametrize(
        ("text", "code"),
        [
            *((text, "not_json") for text in ("", "{", "[1,2", "9" * 5000, "[" * 100_000, "nul")),
            (b"\xff\xfe\xff", "byte_order_mark"),
            (b"{}\xed\xa0\x80", "not_utf8"),
            ("\ud800", "not_utf8"),
        ],
    )
    def test_what_is_no_json_is_refused(self, text: str | bytes, code: str) -> None:
        assert problems(text) == {"": code}

    @pytest.mark.parametrize("text", ["null", "1", '"x"', "[]"])
    def test_json_that_is_no_program_is_refused(self, text: str) -> None:
        assert problems(text) == {"": "wrong_type"}

    def test_a_doubled_field_is_refused(self) -> None:
        text = to_json(PROGRAM).decode().replace('"kind":"approach"', '"kind":"move","kind":"approach"', 1)

        assert list(problems(text).values()) == ["duplicate_field"]

    def test_rows_of_the_wrong_length_are_refused(self) -> None:
        text = edited(lambda d: d["fasteners"][0].update(n=[0, 1]))

        assert problems(text) == {"/fasteners/0/n": "wrong_type"}

    def test_another_schema_version_and_other_units_are_refused(self) -> None:
        def change(data: Any) -> None:
            data["header"]["schema_version"] = "2.0"
            data["header"]["units"]["length"] = "m"

        assert problems(edited(change)) == {
            "/header/schema_version": "wrong_type",
            "/header/units/length": "wrong_type",
        }

    def test_pointers_escape_odd_names(self) -> None:
        assert problems(edited(lambda d: d.update({"a/b~c": 1}))) == {"/a~1b~0c": "unknown_field"}

    def test_a_file_of_another_kind_gives_a_bounded_answer(self) -> None:
        with pytest.raises(InvalidInput) as caught:
            from_json(edited(lambda d: d.update(blocks=[1] * 100_000)))

        assert len(caught.value.problems) <= 201

    def test_the_error_crosses_a_process(self) -> None:
        with pytest.raises(InvalidInput) as caught:
            from_json("{")

        assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)

    @given(st.data())
    def test_any_single_value_replaced_is_read_or_refused(self, data: st.DataObject) -> None:
        """Never another exception, and what is read is what the text says."""
        tree = json.loads(to_json(PROGRAM))
        node: Any = tree
        keys: list[Any] = []
        while (
            isinstance(node, dict | list) and node and (not keys or data.draw(st.booleans()) or len(keys) < 2)
        ):
            key = data.draw(st.sampled_from(sorted(node) if isinstance(node, dict) else range(len(node))))
            keys.append(key)
            node = node[key]
        parent = tree
        for key in keys[:-1]:
            parent = parent[key]
        parent[keys[-1]] = data.draw(
            st.one_of(
                st.none(),
                st.booleans(),
                st.integers(),
                st.floats(),
                st.text(max_size=5),
                st.just([]),
                st.just({}),
            )
        )

        try:
            program = from_json(json.dumps(tree))
        except InvalidInput:
            return
        assert from_json(to_json(program)) == rounded(program)
