"""The strict JSON reader: the traps of a default web framework, one by one."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.errors import InvalidInput
from service.strict_json import JsonLimits, MalformedJson, parse

LIMITS = JsonLimits(max_bytes=100_000, max_depth=20)

MALFORMED = {
    "nothing": (b"", "empty_document", ""),
    "only blanks": (b" \n", "empty_document", ""),
    "NaN": (b'{"a": [1, NaN]}', "not_a_number", "/a/1"),
    "Infinity": (b'{"a": Infinity}', "not_a_number", "/a"),
    "minus Infinity": (b'{"a": -Infinity}', "not_a_number", "/a"),
    "5,000 digits": (b'{"a": ' + b"7" * 5000 + b"}", "number_too_long", "/a"),
    "lone surrogate": (rb'{"a": "\ud800"}', "lone_surrogate", "/a"),
    "lone surrogate in a name": (rb'{"\udc00": 1}', "lone_surrogate", ""),
    "NUL": (rb'{"id": "a\u0000b"}', "nul_character", "/id"),
    "duplicate name": (b'{"x": {"a": 1, "b": 2, "a": 3}}', "duplicate_name", "/x/a"),
    "byte order mark": (b'\xef\xbb\xbf{"a": 1}', "byte_order_mark", ""),
    "UTF-16": ('{"a": 1}'.encode("utf-16"), "byte_order_mark", ""),
    "UTF-16 without mark": ('{"a": 1}'.encode("utf-16-le"), "syntax_error", ""),
    "Latin-1": ('{"a": "é"}'.encode("latin-1"), "not_utf8", ""),
    "deep arrays": (b"[" * 2000 + b"]" * 2000, "nested_too_deeply", ""),
    "deep and never closed": (b'{"a":' * 100_00, "nested_too_deeply", ""),
    "trailing comma": (b'{"a": 1,}', "syntax_error", ""),
    "two documents": (b"{} {}", "syntax_error", ""),
    "single quotes": (b"{'a': 1}", "syntax_error", ""),
    "control character in a string": (b'{"a": "\n"}', "syntax_error", ""),
    "too many bytes": (b'"' + b"x" * 100_000 + b'"', "document_too_large", ""),
}
OUT_OF_RANGE = {
    "1e999": (b'{"a": 1e999}', "/a"),
    "minus 1e999": (b"[-1e999]", "/0"),
    "400 digits": (b'{"a/b": ' + b"7" * 400 + b"}", "/a~1b"),
}


@pytest.mark.parametrize(("text", "code", "pointer"), MALFORMED.values(), ids=MALFORMED)
def test_malformed_text_is_refused_with_code_and_pointer(text: bytes, code: str, pointer: str) -> None:
    with pytest.raises(MalformedJson) as caught:
        parse(text, LIMITS)

    assert [(problem.code, problem.pointer) for problem in caught.value.problems] == [(code, pointer)]


@pytest.mark.parametrize(("text", "pointer"), OUT_OF_RANGE.values(), ids=OUT_OF_RANGE)
def test_numbers_out_of_range_are_refused_but_are_not_malformed(text: bytes, pointer: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        parse(text, LIMITS)

    assert not isinstance(caught.value, MalformedJson)
    assert [(problem.code, problem.pointer) for problem in caught.value.problems] == [
        ("number_out_of_range", pointer)
    ]


def test_all_problems_of_a_text_are_named_at_once_in_its_order() -> None:
    text = rb'{"a": NaN, "b": [1e999, "\ud800"], "c": {"d": 1, "d": 2}}'

    with pytest.raises(MalformedJson) as caught:
        parse(text, LIMITS)

    assert [problem.pointer for problem in caught.value.problems] == ["/a", "/b/0", "/b/1", "/c/d"]


def test_no_message_repeats_a_character_that_cannot_be_written() -> None:
    with pytest.raises(MalformedJson) as caught:
        parse(rb'{"\ud800": NaN, "\ud800": NaN}', LIMITS)

    assert str(caught.value).encode("utf-8")


def test_depth_up_to_the_limit_and_brackets_in_strings_are_accepted() -> None:
    text = b"[" * 20 + rb'"\"[[[{{{\\"' + b"]" * 20

    assert parse(text, LIMITS) == json.loads(text)


def test_a_whole_surrogate_pair_is_one_character() -> None:
    assert parse(rb'["\ud83d\udd29"]', LIMITS) == ["\U0001f529"]


values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63) + 1, 2**63 - 1)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(codec="utf-8", exclude_characters="\0")),
    lambda inner: (
        st.lists(inner)
        | st.dictionaries(st.text(st.characters(codec="utf-8", exclude_characters="\0")), inner)
    ),
    max_leaves=20,
)


@given(values, st.booleans())
def test_what_we_write_is_read_back_the_same(value: object, ascii_only: bool) -> None:
    text = json.dumps(value, ensure_ascii=ascii_only, allow_nan=False).encode()

    assert parse(text, JsonLimits(max_depth=64)) == value


@given(st.binary(max_size=60) | st.text('[]{}",:\\u0d8NaIfinty1e9-. ').map(str.encode))
def test_any_bytes_are_parsed_or_refused_with_problems_that_can_be_written(text: bytes) -> None:
    try:
        outcome = json.dumps(parse(text, LIMITS), allow_nan=False)
    except InvalidInput as refusal:
        outcome = str(refusal)

    assert outcome.encode("utf-8")
