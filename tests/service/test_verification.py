"""Programs and texts verified as a product: what passes, what is found, and where it is said to be."""

import hashlib
import re
from dataclasses import replace

import pytest

from robots.errors import InvalidInput
from robots.nc_json import program_sha256, to_json
from robots.post.dialects import DIALECTS, post
from robots.post.form import token
from robots.post.recognise import recognised
from service.verification import check_left_out, not_understood, of_document, of_text, verification
from service.verification_schemas import Verification
from tests.robots.nc_samples import flat_panel
from tests.robots.post.programs import small
from tests.robots.rigs import MACHINE

PANEL = flat_panel()
CONTROLLERS = ["sinumerik840d", "fanuc30i", "apt"]
SIEMENS = "sinumerik840d"


def text_of(dialect: str = SIEMENS) -> str:
    return post(small(), dialect)


def verified(text: str, dialect: str = SIEMENS, left_out: tuple[str, ...] = ()) -> Verification:
    data = text.encode()
    try:
        judged = of_text(data, dialect, PANEL, MACHINE, left_out)
    except InvalidInput as invalid:
        return not_understood(invalid, data, dialect, PANEL, MACHINE)
    return verification(judged, PANEL, MACHINE)


def codes(found: Verification) -> set[str]:
    return {finding.code for finding in found.findings}


def line_with(text: str, what: str) -> int:
    """Number of the one line that has this in it."""
    (number,) = (n for n, line in enumerate(text.split("\n"), 1) if what in line)
    return number


def edited(before: str, after: str, text: str | None = None) -> str:
    text = text or text_of()
    assert text.count(before) >= 1, before
    return text.replace(before, after)


def without_blocks(text: str, first: int, last: int) -> str:
    """The text without the lines of some blocks."""
    numbers = {f"N{n} " for n in range(first, last + 1, 10)}
    kept, skipped = [], False
    for line in text.split("\n"):
        if re.match(r"N\d+ |M30", line):
            skipped = any(line.startswith(number) for number in numbers)
        kept += [] if skipped else [line]
    return "\n".join(kept)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_posted_text_is_clean_and_stands_for_the_motion_of_its_program(dialect: str) -> None:
    text = text_of(dialect)
    judged = of_text(text.encode(), dialect, PANEL, MACHINE)
    found = verification(judged, PANEL, MACHINE)

    assert (found.result, found.findings) == ("clean", [])
    assert found.source.sha256 == hashlib.sha256(text.encode()).hexdigest()
    assert found.program_sha256 == program_sha256(judged.meaning.program)
    assert found.certified_blocks == found.blocks == len(small().blocks)
    assert found.cycle_time_s == pytest.approx(small().summary.cycle_time_s, rel=1e-4)
    assert found.fasteners.installed == found.fasteners.total == 3
    for ours, theirs in zip(judged.meaning.program.blocks, small().blocks, strict=True):
        assert ours.axes == theirs.axes
        assert [(e.code, e.handshake) for e in ours.events] == [(e.code, e.handshake) for e in theirs.events]
        assert (ours.kind, ours.fastener_id, ours.die_id) == (theirs.kind, theirs.fastener_id, theirs.die_id)
        assert ours.allowed_contacts == theirs.allowed_contacts
    if dialect != "ndjson":
        assert found.source.stated_sha256 == program_sha256(small())


def test_speeds_of_a_text_are_never_less_than_it_commands_and_ours_are_the_programs() -> None:
    """Where the digits of a feed reach, the program's own limits come back."""
    judged = of_text(text_of("csv").encode(), "csv", PANEL, MACHINE)
    rows = [line.split(",") for line in text_of("csv").split("\n") if re.match(r"\d+,", line)]

    same = 0
    for row, ours, theirs in zip(rows, judged.meaning.program.blocks, small().blocks, strict=True):
        if ours.dynamics and theirs.dynamics:
            assert float(row[9]) / 60.0 <= ours.dynamics.v_per_s <= theirs.dynamics.v_per_s
            assert ours.dynamics.a_per_s2 == theirs.dynamics.a_per_s2
            same += ours.dynamics == theirs.dynamics
    assert same > 5


def test_one_digit_that_brings_the_die_too_close_is_named_with_block_and_line() -> None:
    text = edited(" Y0.0000 Z0.0000 A0.000000 B0.000000 W331.8000 C90.000000", " Y0.0000 @@")
    number = re.findall(r"N(\d+) [^\n]*@@[^\n]*move F2", text)[0]
    text = re.sub(rf"(N{number} [^\n]*) Y0.0000 @@", r"\1 Y-9.0000 @@", text)
    text = text.replace("@@", "Z0.0000 A0.000000 B0.000000 W331.8000 C90.000000")

    found = verified(text)

    assert found.result == "rejected"
    clearance = next(finding for finding in found.findings if finding.code == "clearance")
    assert clearance.block_n == int(number)
    assert clearance.line == line_with(text, f"N{number} ")
    assert clearance.pair is not None
    assert clearance.clearance_mm is not None
    assert found.min_clearance is not None
    assert found.min_clearance.line == clearance.line


Changes = tuple[tuple[str, str], ...]
"""Patterns and what stands in their place, one after the other."""

_FEED_TO_F2 = r" F[0-9.]+ ; move F2"
_REST = r"Y0.0000 Z0.0000 A0.000000 B0.000000 W0"
_SECOND = r"(N20 [^\n]*\n)"

HARMLESS: dict[str, Changes] = {
    "a waypoint far from everything": ((f"X6220.0000 {_REST}", f"X6220.3000 {_REST}"),),
    "a slower feed": ((_FEED_TO_F2, " F1.5 ; move F2"),),
    "where a link came from": (("move F2 direct", "move F2 planned"),),
    "room between words": ((" Z0.0000 ", "   Z0.0000  "),),
    "a comment": (("G93\n", "; tried out\nG93\n"),),
    "who made it": (("generator .*", "generator somebody"),),
}
FAULTS: dict[str, tuple[Changes, str]] = {
    "quicker than an axis": (((_FEED_TO_F2, " F9999.0 ; move F2"),), "speed_limit"),
    "no feed": (((_FEED_TO_F2, " F0.0 ; move F2"),), "dynamics_invalid"),
    "beyond travel": ((("X6280.0000", "X99280.0000"),), "axis_limit"),
    "two events changed over": ((("M101", "?"), ("M102", "M101"), (r"\?", "M102")), "event_order"),
    "a hand-shake less": (((r"H3=1 M62\n", ""),), "calls"),
    "an event less": (((r"M102\n", ""),), "event_order"),
    "events of another kind of block": ((("; process F1 ", "; move F1 "),), "event_outside_process"),
    "another fastener is told": (((" F1 ", " F7 "),), "fastener_unknown"),
    "fasteners told for one another": (
        ((" F1 ", " ? "), (" F2 ", " F1 "), (r" \? ", " F2 ")),
        "position_off",
    ),
    "dies told for one another": (
        (("straight\n", "?\n"), ("j20\n", "straight\n"), (r"\?\n", "j20\n")),
        "clearance",
    ),
    "a die the machine has not": ((("die 1 straight", "die 1 crooked"),), "unknown_die"),
    "a process the machine has not": ((("process 1 solid_rivet", "process 1 glue"),), "unknown_process"),
    "a wait of another time": ((("DIE_CONTACT-2s", "DIE_CONTACT-9s"),), "header"),
    "another machine": ((("; machine riveter", "; machine mill"),), "machine_data"),
    "another definition of the machine": ((("machine-sha256 .", "machine-sha256 ?"),), "unreadable_line"),
    "a machine of other data": ((("machine-sha256 ...", "machine-sha256 xyz"),), "input_hash"),
    "another panel": ((("; panel flat", "; panel bent"),), "input_hash"),
    "other units": ((("mm deg 1/min", "in deg 1/min"),), "units"),
    "another law": ((("law exact_stop", "law overlap"),), "timing_law"),
    "less clearance": (((r"policy-mm \d+", "policy-mm 0"),), "policy_weakened"),
    "clearances that are none": ((("policy-mm .*", "policy-mm some"),), "policy_weakened"),
    "a motion to the same place": (((_SECOND, r"\1\1"), ("^N20 ", "N15 ")), "no_motion"),
    "a block twice": (((_SECOND, r"\1\1"),), "block_order"),
}


def changed(changes: Changes) -> str:
    text = text_of()
    for pattern, instead in changes:
        count = 1 if pattern.startswith("^") else 0
        text, times = re.subn(pattern, instead, text, count=count, flags=re.MULTILINE)
        assert times > 0, pattern
    return text


@pytest.mark.parametrize("changes", HARMLESS.values(), ids=HARMLESS)
def test_harmless_edit_passes(changes: Changes) -> None:
    found = verified(changed(changes))

    assert (found.result, found.findings) == ("clean", [])


@pytest.mark.parametrize(("changes", "code"), FAULTS.values(), ids=FAULTS)
def test_faulty_edit_is_found(changes: Changes, code: str) -> None:
    found = verified(changed(changes))

    assert found.result == "rejected"
    assert code in codes(found), found.findings


def test_fastener_that_a_text_lacks_is_missed_unless_the_request_leaves_it_out() -> None:
    text = without_blocks(text_of(), 70, 100)
    assert "F2" not in text

    found, expected = verified(text), verified(text, left_out=("F2",))

    assert codes(found) == {"fastener_missed"}
    assert (found.fasteners.installed, found.fasteners.missed) == (2, ["F2"])
    assert (expected.result, expected.fasteners.not_installed) == ("clean", ["F2"])
    assert "fastener_status" in codes(verified(text_of(), left_out=("F2",)))


def test_fasteners_too_many_are_told_apart() -> None:
    rest = text_of().replace(" F2 ", " F1 ")

    twice, extra = verified(rest).fasteners, verified(text_of().replace(" F2 ", " F9 ")).fasteners

    assert (twice.duplicate, twice.missed, twice.installed) == (["F1"], ["F2"], 1)
    assert (extra.extra, extra.missed) == (["F9"], ["F2"])


def test_line_that_cannot_be_understood_is_named() -> None:
    text = edited("G60 G601", "G64")

    found = verified(text)

    assert (found.result, found.program_sha256) == ("rejected", None)
    assert [(each.code, each.line) for each in found.findings] == [
        ("unreadable_line", line_with(text, "G64"))
    ]
    assert found.fasteners.missed == ["F1", "F2", "F3"]


def test_events_are_told_in_their_order_with_what_they_wait_for() -> None:
    events = verified(text_of()).events

    assert [event.code for event in events].count("DIE j20") == 1
    assert [event.t_s for event in events] == sorted(event.t_s for event in events)
    first = [event for event in events if event.fastener_id == "F1"]
    assert [event.code for event in first] == [e.code for b in small().blocks[:5] for e in b.events]
    assert first[0].wait_for == "DIE_CONTACT"


def test_axes_are_told_beside_their_limits() -> None:
    used = {each.axis: each for each in verified(text_of()).axes}

    for stated in small().machine.axes:
        axis = used[stated.name]
        limits = (axis.min, axis.max, axis.v_max, axis.a_max, axis.j_max)
        assert axis.unit == stated.unit
        assert limits == pytest.approx((stated.min, stated.max, stated.v, stated.a, stated.j), abs=2e-6)
        assert axis.min <= axis.least <= axis.most <= axis.max
        assert axis.v <= axis.v_max * (1 + 1e-9)
        assert axis.a <= axis.a_max * (1 + 1e-9)
        assert axis.j <= axis.j_max * (1 + 1e-9)
    assert (used["X"].least, used["X"].most) == (0.0, 6340.0)
    assert used["X"].v > 0.99 * used["X"].v_max
    assert used["A"].v == 0.0


def test_edited_program_is_judged_without_the_certificate_it_brings_along() -> None:
    retitled = replace(small(), header=replace(small().header, title="Edited by hand"))

    found, own = (verification(of_document(to_json(each)), PANEL, MACHINE) for each in (retitled, small()))

    assert (found.result, found.own_certificate) == ("clean", "for_another_program")
    assert (own.result, own.own_certificate) == ("clean", "agrees")
    assert found.program_sha256 != own.program_sha256


def test_certificate_that_says_other_than_the_verifier_is_found() -> None:
    certificate = small().verification
    assert certificate is not None
    forged = replace(small(), verification=replace(certificate, samples=1))

    found = verification(of_document(to_json(forged)), PANEL, MACHINE)

    assert (codes(found), found.own_certificate) == ({"certificate_changed"}, "differs")


def test_program_with_digits_that_no_reader_sees_is_rejected() -> None:
    text = to_json(replace(small(), verification=None)).replace(b'"X_mm":6220.0000', b'"X_mm":6220.00001', 1)

    assert "digits" in codes(verification(of_document(text), PANEL, MACHINE))


@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects_are_told_by_name_and_by_content(dialect: str) -> None:
    data = text_of(dialect).encode()

    assert recognised(data) == recognised(data, DIALECTS[dialect].suffix.upper()) == dialect
    assert recognised(b"\n\n" + data, ".txt") == dialect
    assert recognised(b"nothing known", DIALECTS[dialect].suffix) == dialect


@pytest.mark.parametrize(("suffix", "text"), [(".txt", "G1 X5"), ("", ""), (".apt", text_of())])
def test_doubtful_dialect_is_an_error_that_names_the_choices(suffix: str, text: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        recognised(text.encode(), suffix)

    (problem,) = caught.value.problems
    assert all(dialect in problem.remedy for dialect in DIALECTS)


@pytest.mark.parametrize(("names", "dialect"), [(["F9"], SIEMENS), (["F1"], "ndjson")])
def test_fasteners_that_cannot_be_left_out_are_problems(names: list[str], dialect: str) -> None:
    with pytest.raises(InvalidInput):
        check_left_out(names, PANEL, dialect, "/left_out")


def test_loose_names_of_a_panel_are_found_again() -> None:
    """Names that no controller can hold stand in the text as tokens."""
    names = {"F1": "Reihe 1/Niet 3 (oben)", "F2": "F2", "F3": "ü" * 40}
    panel = replace(PANEL, fasteners=tuple(replace(f, id=names[f.id]) for f in PANEL.fasteners))
    text = text_of()
    for old, new in names.items():
        text = text.replace(f" {old} ", f" {token(new)} ")
    found = verification(of_text(text.encode(), SIEMENS, panel, MACHINE), panel, MACHINE)

    assert (found.result, found.findings) == ("clean", [])
