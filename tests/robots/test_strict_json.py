from pathlib import Path

import pytest

from robots.errors import InvalidInput
from robots.strict_json import parse_document, pointer_to, read_document


def codes(text: bytes) -> list[tuple[str, str]]:
    with pytest.raises(InvalidInput) as caught:
        parse_document(text)
    return [(problem.pointer, problem.code) for problem in caught.value.problems]


def test_an_object_is_read() -> None:
    assert parse_document('{"a": [1, 2.5, "é"]}'.encode()) == {"a": [1, 2.5, "é"]}


@pytest.mark.parametrize("mark", [b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"])
def test_byte_order_marks_are_refused(mark: bytes) -> None:
    assert codes(mark + b"{}") == [("", "byte_order_mark")]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (b'{"a": "\xe9"}', "not_utf8"),
        (b"", "not_json"),
        (b'{"a": 1,}', "not_json"),
        (b"{} {}", "not_json"),
        (b'{"a": ' + b"9" * 5000 + b"}", "not_json"),
        (b"[" * 100_000, "not_json"),
        (b"[1]", "wrong_type"),
        (b"null", "wrong_type"),
    ],
)
def test_what_is_no_object_is_refused_with_its_reason(text: bytes, code: str) -> None:
    assert codes(text) == [("", code)]


def test_every_repeated_field_is_named_with_its_place() -> None:
    text = b'{"a": 1, "b": [{"x/y": 1, "x/y": 2, "z": {"n": 1, "n": 1, "n": 1}}], "a": 2}'

    assert codes(text) == [
        ("/a", "duplicate_field"),
        ("/b/0/x~1y", "duplicate_field"),
        ("/b/0/z/n", "duplicate_field"),
    ]


def test_repeated_field_is_found_in_a_value_that_is_then_replaced() -> None:
    assert ("/a", "duplicate_field") in codes(b'{"a": {"n": 1, "n": 2}, "a": 3}')


def test_half_characters_are_refused_where_they_stand() -> None:
    text = rb'{"a": ["ok", "\ud800"], "b": {"\udfff": 1}, "c": "\ud83d\ude00"}'

    assert codes(text) == [("/a/1", "bad_text"), ("/b", "bad_text")]
    for half in (rb"\uD800", rb"\uDbfF", rb"\udC00", rb"\uDFFF", rb"\\\uD9ab"):
        assert codes(b'{"a": "' + half + b'"}') == [("/a", "bad_text")]


def test_what_only_looks_like_half_a_character_is_text() -> None:
    assert parse_document(rb'{"a": "\\ud800", "b": "\uD83D\uDE00"}') == {"a": r"\ud800", "b": "\U0001f600"}


def test_nan_is_left_to_the_schema() -> None:
    document = parse_document(b'{"a": NaN, "b": [Infinity, -Infinity, 1e999]}')

    assert str(document) == "{'a': nan, 'b': [inf, -inf, inf]}"


@pytest.mark.parametrize("name", ["missing.json", ".", "a\0b"])
def test_unreadable_files_are_a_problem_not_a_crash(tmp_path: Path, name: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        read_document(str(tmp_path) + "/" + name)

    assert [problem.code for problem in caught.value.problems] == ["unreadable_file"]


def test_file_and_bytes_give_the_same(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_bytes(b'{"a": 1}')

    assert read_document(path) == read_document(str(path)) == read_document(b'{"a": 1}') == {"a": 1}


def test_pointers_escape_what_rfc_6901_asks_for() -> None:
    assert pointer_to("a/b", 0, "m~n") == "/a~1b/0/m~0n"
    assert pointer_to() == ""
