"""What has no text, and why: a controller gets only what was certified and what its text can say."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from robots.errors import InvalidInput
from robots.nc import NcBlock, NcDie, NcDynamics, NcEvent, NcProgram
from robots.nc_process import NcHandshake
from robots.post import sinumerik840d
from robots.post.dialects import DIALECTS, GRAMMARS, check, post
from robots.post.refusals import unsayable
from tests.robots.nc_samples import with_block
from tests.robots.post.programs import certified, small

Edit = Callable[[NcProgram], NcProgram]


def block(n: int) -> NcBlock:
    return next(each for each in small().blocks if each.n == n)


def dynamics_of(n: int) -> NcDynamics:
    dynamics = block(n).dynamics
    assert dynamics is not None
    return dynamics


def edited(n: int, **changes: Any) -> Edit:
    return lambda program: with_block(program, n, **changes)


def numbered(old: int, new: int) -> Edit:
    return lambda program: replace(
        program, blocks=tuple(replace(each, n=new) if each.n == old else each for each in program.blocks)
    )


def other_law(program: NcProgram) -> NcProgram:
    policy = replace(program.policy)
    object.__setattr__(policy, "timing_law", "time_optimal")
    return replace(program, policy=policy)


def other_block_law(program: NcProgram) -> NcProgram:
    dynamics = replace(dynamics_of(20))
    object.__setattr__(dynamics, "law", "time_optimal")
    return with_block(program, 20, dynamics=dynamics)


def slow(program: NcProgram) -> NcProgram:
    return with_block(program, 20, dynamics=replace(dynamics_of(20), v_per_s=1e-7))


CASES: dict[str, tuple[Edit, str, str]] = {
    "no blocks": (lambda p: replace(p, blocks=()), "no_blocks", "/blocks"),
    "another law": (other_law, "timing_law", "/policy"),
    "another law of a block": (other_block_law, "timing_law", "/blocks/1/dynamics/law"),
    "no exact stop": (
        lambda p: replace(p, policy=replace(p.policy, exact_stop_at_events=False)),
        "timing_law",
        "/policy",
    ),
    "die twice": (lambda p: replace(p, dies=(*p.dies, p.dies[0])), "not_numbered", "/dies"),
    "too many dies": (
        lambda p: replace(p, dies=(*p.dies, *(NcDie(f"d{k}", True) for k in range(99)))),
        "not_numbered",
        "/dies",
    ),
    "number too large": (numbered(20, 100_000_000), "block_number", "/blocks/1/n"),
    "number zero": (numbered(10, 0), "block_number", "/blocks/0/n"),
    "numbers do not rise": (numbered(30, 20), "block_number", "/blocks/2/n"),
    "infinite value": (
        edited(20, axes=replace(block(20).axes, X_mm=float("inf"))),
        "axis_value",
        "/blocks/1/axes/X_mm",
    ),
    "huge value": (edited(20, axes=replace(block(20).axes, C_deg=1e7)), "axis_value", "/blocks/1/axes/C_deg"),
    "too slow": (slow, "feed", "/blocks/1/dynamics/v_per_s"),
    "event in motion": (edited(20, events=(NcEvent("CLAMP", 0.0),)), "event_in_motion", "/blocks/1/events"),
    "die change in motion": (edited(20, kind="die_change"), "event_in_motion", "/blocks/1/events"),
    "event without process": (edited(50, process_id=None), "no_process", "/blocks/4/events"),
    "unknown event": (edited(50, events=(NcEvent("GLUE", 0.0),)), "unknown_event", "/blocks/4/events"),
    "unknown hand-shake": (
        edited(50, events=(NcEvent("CLAMP", 0.0, NcHandshake("DIE_CONTACT", 9.0)),)),
        "unknown_handshake",
        "/blocks/4/events",
    ),
    "unknown process": (edited(50, process_id="glue"), "unknown_process", "/blocks/4/process_id"),
    "unknown die": (edited(50, die_id="spoon"), "unknown_die", "/blocks/4/die_id"),
    "die without change": (edited(50, die_id="j20"), "no_die_change", "/blocks/4/die_id"),
    "moves without dynamics": (edited(20, dynamics=None), "no_feed", "/blocks/1/dynamics"),
    "begins in motion": (edited(10, dynamics=block(20).dynamics), "no_start", "/blocks/0/dynamics"),
}


@pytest.mark.parametrize("case", CASES)
def test_what_a_text_cannot_say_is_refused_with_its_place(case: str) -> None:
    edit, code, pointer = CASES[case]
    form, events = GRAMMARS["sinumerik840d"].form, sinumerik840d.CALLS.events
    assert list(unsayable(small(), form, events)) == []

    problems = list(unsayable(edit(small()), form, events))

    assert (pointer, code) in [(problem.pointer, problem.code) for problem in problems]
    assert all(problem.remedy for problem in problems)


@pytest.mark.parametrize("dialect", GRAMMARS)
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: replace(small(), verification=None), "no certificate"),
        (lambda: certified(with_block(small(), 40, axes=block(30).axes)), "rejected"),
        (lambda: with_block(small(), 20, t_end_s=9.0), "another program"),
    ],
)
def test_a_controller_gets_no_text_without_a_clean_certificate_for_just_this_program(
    make: Callable[[], NcProgram], message: str, dialect: str
) -> None:
    with pytest.raises(InvalidInput, match=message) as refused:
        post(make(), dialect)

    assert refused.value.problems[0].code == "uncertified"


@pytest.mark.parametrize("dialect", ["csv", "ndjson"])
def test_tables_are_for_any_program(dialect: str) -> None:
    program = with_block(replace(small(), verification=None), 20, t_end_s=9.0)

    assert check(post(program, dialect).encode(), program, dialect) == ()


def test_ndjson_says_even_what_no_controller_can() -> None:
    program = with_block(numbered(30, 20)(small()), 50, die_id="spoon")

    assert check(post(program, "ndjson").encode(), program, "ndjson") == ()


@pytest.mark.parametrize("dialect", DIALECTS)
def test_text_of_one_program_is_not_that_of_another(dialect: str) -> None:
    other = with_block(small(), 20, t_end_s=9.0)

    assert check(post(small(), dialect).encode(), other, dialect)
