"""What a changed text is found to be: unreadable at a line, different at a block, or the same in meaning."""

import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

import pytest

from robots.errors import InvalidInput
from robots.post.compare import Difference, differences
from robots.post.content import content_of
from robots.post.dialects import DIALECTS, GRAMMARS, check, post
from robots.post.form import AXES
from tests.robots.post.programs import small

CONTROLLERS = ["sinumerik840d", "fanuc30i", "apt"]
Lines = list[str]


def lines_of(dialect: str) -> Lines:
    return post(small(), dialect).splitlines()


def found(lines: Sequence[str], dialect: str) -> tuple[Difference, ...]:
    return check("\n".join(lines).encode(), small(), dialect)


def refused_line(lines: Sequence[str], dialect: str) -> str:
    with pytest.raises(InvalidInput) as refused:
        found(lines, dialect)
    (problem,) = refused.value.problems
    assert problem.code == "unreadable_line"
    return problem.pointer


def place(lines: Lines, pattern: str, which: int = 0) -> int:
    return [i for i, line in enumerate(lines) if re.search(pattern, line)][which]


MOTION = {
    "sinumerik840d": r"^N\d+ G1",
    "fanuc30i": r"^N\d+ G1",
    "apt": r"^GOTO/",
    "csv": r"^\d+,\w+,[-\d.,]+,\d",
}


@pytest.mark.parametrize("dialect", ["sinumerik840d", "fanuc30i", "csv"])
@pytest.mark.parametrize("axis", AXES)
def test_last_digit_of_every_axis_value_of_every_motion_is_found(axis: str, dialect: str) -> None:
    lines = lines_of(dialect)
    column = 2 + AXES.index(axis)
    value = (
        rf"^((?:[^,]*,){{{column}}}[-\d.]*)(\d),"
        if dialect == "csv"
        else rf"^(N\d+ G1 .*?{axis}[-\d.]*)(\d) "
    )

    for i, line in enumerate(lines):
        if re.search(MOTION[dialect], line):
            changed = re.sub(value, lambda m: f"{m[1]}{(int(m[2]) + 1) % 10}{m[0][-1]}", line)
            assert changed != line
            at_line = [
                each for each in found([*lines[:i], changed, *lines[i + 1 :]], dialect) if each.line == i + 1
            ]
            assert [each.code for each in at_line] == ["axis_value"]
            unit = "deg" if axis in "ABC" else "mm"
            assert re.search(
                rf" {axis} is -?[\d.]+ {unit}, the program's is -?[\d.]+ {unit}$", at_line[0].text
            )


@pytest.mark.parametrize("word", ["AAXIS", "BAXIS", "CAXIS", "WAXIS", "GOTO", "FROM"])
def test_last_digit_of_an_axis_value_is_found_in_apt_too(word: str) -> None:
    lines = lines_of("apt")
    i = place(lines, word, -1)
    lines[i] = re.sub(r"(\d)(,NEXT)?$", lambda m: f"{(int(m[1]) + 1) % 10}{m[2] or ''}", lines[i])

    assert {each.code for each in found(lines, "apt")} == {"axis_value"}


@pytest.mark.parametrize("dialect", CONTROLLERS)
def test_every_line_counts(dialect: str) -> None:
    lines = lines_of(dialect)

    for i in range(len(lines)):
        with suppress(InvalidInput):
            assert found([*lines[:i], *lines[i + 1 :]], dialect), lines[i]


@pytest.mark.parametrize("dialect", CONTROLLERS)
def test_every_line_of_the_opening_must_be_as_it_was_posted(dialect: str) -> None:
    lines = lines_of(dialect)
    first = place(lines, r"^N10 |^SEQNO/10$")

    for i in range(first):
        is_head = re.match(r"; |\(|\$\$", lines[i]) is not None
        changed = [*lines[:i], lines[i].replace("6", "7").replace("0", "1") + "9", *lines[i + 1 :]]
        if is_head:
            continue
        assert refused_line(changed, dialect) == f"line {i + 1}"


@pytest.mark.parametrize("dialect", CONTROLLERS)
def test_header_of_another_program_is_a_difference(dialect: str) -> None:
    lines = lines_of(dialect)
    i = place(lines, r" sha256 |\(sha256 ")
    lines[i] = lines[i].replace("1", "f")
    j = place(lines, "die 2 ")
    lines[j] = lines[j].replace("j20", "j21")

    first, *others = found(lines, dialect)
    assert (first.code, first.line) == ("header", i + 1)
    assert {each.code for each in others} == {"header", "calls"}


def swapped(lines: Lines, a: int, b: int) -> Lines:
    lines = list(lines)
    lines[a], lines[b] = lines[b], lines[a]
    return lines


EVENT = {"sinumerik840d": r"^M10\d$", "fanuc30i": r"^M10\d$", "apt": r"^AUXFUN/10\d$"}


@pytest.mark.parametrize("dialect", CONTROLLERS)
def test_events_in_another_order_missing_or_doubled_are_found_at_their_block(dialect: str) -> None:
    lines = lines_of(dialect)
    i = place(lines, EVENT[dialect])

    for changed in (
        swapped(lines, i, i + 1),
        swapped(lines, i - 1, i),
        [*lines[:i], *lines[i + 1 :]],
        [*lines[:i], lines[i], *lines[i:]],
    ):
        (difference,) = found(changed, dialect)
        assert (difference.code, difference.block_n) == ("calls", 50)


@pytest.mark.parametrize("dialect", ["sinumerik840d", "fanuc30i"])
def test_blocks_missing_doubled_swapped_and_extra_are_named(dialect: str) -> None:
    lines = lines_of(dialect)
    i = place(lines, r"^N20 ")

    missing = found([*lines[:i], *lines[i + 1 :]], dialect)
    doubled = found([*lines[: i + 1], *lines[i:]], dialect)
    moved = found(swapped(lines, i, i + 1), dialect)
    extra = found([*lines[: i + 1], lines[i].replace("N20 ", "N25 "), *lines[i + 1 :]], dialect)

    assert [(each.code, each.block_n, each.line) for each in missing] == [("block_missing", 20, None)]
    assert [(each.code, each.block_n, each.line) for each in doubled] == [("block_doubled", 20, i + 2)]
    assert [(each.code, each.block_n, each.line) for each in moved] == [("block_order", 30, i + 1)]
    assert [(each.code, each.block_n, each.line) for each in extra] == [("block_extra", 25, i + 2)]


@pytest.mark.parametrize("dialect", CONTROLLERS)
def test_another_die_feed_kind_or_fastener_is_named(dialect: str) -> None:
    text = "\n".join(lines_of(dialect))
    changes = {
        "calls": (r"H1=2 M60|T2 M6|LOADTL/2", lambda m: m[0].replace("2", "3", 1)),
        "feed": (r"(F|FEDRAT/)(?=\d+\.)", lambda m: m[0] + "1"),
        "kind": (r"\bretreat\b", lambda m: "approach"),
        "fastener": (r"\bF2\b(?! is)", lambda m: "F3"),
        "origin": (r" direct\b", lambda m: " planned"),
    }

    for code, (pattern, change) in changes.items():
        changed = re.sub(pattern, change, text, count=1)
        assert changed != text
        assert {each.code for each in found(changed.split("\n"), dialect)} == {code}


@pytest.mark.parametrize("dialect", CONTROLLERS)
def test_spaces_line_ends_fewer_decimals_and_comments_change_nothing(dialect: str) -> None:
    lines = lines_of(dialect)
    note = {"sinumerik840d": "; looked at", "fanuc30i": "(looked at)", "apt": "$$ looked at"}[dialect]
    first = place(lines, r"^N10 |^SEQNO/10$")
    short = [*lines[:first], *(re.sub(r"\.0000\b", ".0", line) for line in lines[first:])]

    assert found([*short[:first], note, "", *(f"  {line} \r" for line in short[first:])], dialect) == ()


@pytest.mark.parametrize("dialect", CONTROLLERS)
def test_rapid_motion_another_frame_or_text_behind_the_end_is_refused(dialect: str) -> None:
    lines = lines_of(dialect)
    i = place(lines, MOTION[dialect])
    wrong = {
        "sinumerik840d": ("SUPA ", ""),
        "fanuc30i": ("G1", "G0"),
        "apt": ("GOTO", "GODLTA"),
    }[dialect]

    assert refused_line([*lines[:i], lines[i].replace(*wrong), *lines[i + 1 :]], dialect) == f"line {i + 1}"
    assert refused_line([*lines, lines[i]], dialect) == f"line {len(lines) + 1}"
    assert refused_line(lines[:-1], dialect) == f"line {len(lines)}"


@pytest.mark.parametrize("note", [b"\xc3\xa4", b"\x1b[2J", 5000 * b"x"])
@pytest.mark.parametrize("dialect", CONTROLLERS)
def test_not_even_a_comment_may_hold_what_a_controller_cannot(dialect: str, note: bytes) -> None:
    start, end = {"sinumerik840d": (b"; ", b""), "fanuc30i": (b"(", b")"), "apt": (b"$$ ", b"")}[dialect]
    lines = [line.encode() for line in lines_of(dialect)]
    first = place(lines_of(dialect), r"^N10 |^SEQNO/10$")
    text = b"\n".join([*lines[:first], start + note + end, *lines[first:]])

    with pytest.raises(InvalidInput, match=f"line {first + 1}:"):
        check(text, small(), dialect)


@pytest.mark.parametrize("dialect", ["sinumerik840d", "fanuc30i"])
def test_first_block_must_not_move(dialect: str) -> None:
    lines = lines_of(dialect)
    i = place(lines, "^N10 ")
    lines[i] = lines[place(lines, "^N20 ")].replace("N20 ", "N10 ")

    with pytest.raises(InvalidInput, match="the first block must state where the machine stands"):
        found(lines, dialect)


def test_line_longer_than_the_controller_takes_is_never_written() -> None:
    narrow = replace(GRAMMARS["apt"], width=40)

    with pytest.raises(RuntimeError, match="40 characters"):
        narrow.write(content_of(small(), narrow.form))


def test_contents_are_never_called_equal_for_want_of_a_name_for_what_differs() -> None:
    once = content_of(small(), GRAMMARS["apt"].form)
    twice = replace(once, steps=(*once.steps, once.steps[-1]))

    assert [each.code for each in differences(twice, once)] == ["blocks"]


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("data", [b"", b"\n", b"\xff\xfe", b"\0", b"%", b"{}\n{}", 5000 * b"x", b"\n" * 9])
def test_what_is_no_text_of_the_dialect_is_refused_with_a_line(data: bytes, dialect: str) -> None:
    with pytest.raises(InvalidInput, match="line "):
        check(data, small(), dialect)


def test_motion_between_two_comments_is_no_comment() -> None:
    lines = lines_of("fanuc30i")
    i = place(lines, "^N20 ")
    lines.insert(i, "(a) G0 X0.0 (b)")

    assert refused_line(lines, "fanuc30i") == f"line {i + 1}"


@pytest.mark.parametrize("dialect", CONTROLLERS)
def test_more_decimals_than_the_controller_takes_are_refused(dialect: str) -> None:
    lines = lines_of(dialect)
    i = place(lines, MOTION[dialect])
    lines[i] = re.sub(r"(\.\d\d\d\d)(?=[ ,])", r"\g<1>4", lines[i], count=1)

    assert refused_line(lines, dialect) == f"line {i + 1}"


@pytest.mark.parametrize(
    "edit",
    [
        lambda rows: rows[:-1],
        lambda rows: [*rows[:-2], rows[-1]],
        lambda rows: [rows[1], rows[0], *rows[2:]],
        lambda rows: [rows[0], *rows],
        lambda rows: [*rows[:2], *rows[3:-1], rows[2], rows[-1]],
        lambda rows: [rows[0].replace('"blocks":[]', f'"blocks":[{rows[1][9:-1]}]'), *rows[1:]],
        lambda rows: [*rows, rows[-1]],
        lambda rows: [rows[0], rows[1] + " ", *rows[2:]],
        lambda rows: [rows[0], rows[1][:-1] + "x", *rows[2:]],
        lambda rows: [rows[0], rows[1].replace('"X_mm":0.0000', '"X_mm":0.00001'), *rows[2:]],
    ],
)
def test_records_of_ndjson_stand_in_their_order_whole_and_counted(edit: Callable[[Lines], Lines]) -> None:
    lines = lines_of("ndjson")
    changed = edit(lines)
    assert changed != lines

    assert refused_line(changed, "ndjson")


def test_record_changed_in_ndjson_is_named_with_its_line() -> None:
    lines = lines_of("ndjson")
    i = place(lines, '"n":30,')
    lines[i] = lines[i].replace('"at_s":0.', '"at_s":1.').replace('"t_end_s":', '"t_end_s":1')

    assert {(each.code, each.line) for each in found(lines, "ndjson")} == {
        ("header", None),
        ("record", i + 1),
    }
