"""Outlines: what is read of a previous program, and what is not believed."""

import json
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.errors import InvalidInput
from robots.nc import NcProgram
from robots.nc_json import from_json, program_sha256, to_json
from robots.outline import Outline, outline_of, read_outline
from tests.robots.nc_samples import sample
from tests.robots.rigs import MACHINE

PROGRAM: NcProgram = sample(MACHINE)
TEXT = to_json(PROGRAM)


def content(outline: Outline) -> tuple[Any, ...]:
    passes = {die: (each.stations, each.ways) for die, each in outline.passes.items()}
    return outline.header, outline.fasteners, outline.cycle_time_s, passes, outline.changes


def edited(edit: Callable[[dict[str, Any]], object]) -> bytes:
    document = json.loads(TEXT)
    edit(document)
    return json.dumps(document).encode()


def test_a_file_reads_as_the_program_itself() -> None:
    assert content(read_outline(TEXT)) == content(outline_of(from_json(TEXT)))


@pytest.mark.parametrize("text", [TEXT, json.dumps(json.loads(TEXT), indent=1).encode()])
def test_the_hash_is_that_of_the_program_however_its_file_is_laid_out(text: bytes) -> None:
    assert read_outline(text).sha256 == program_sha256(PROGRAM)


def test_stations_and_links_are_those_of_the_blocks() -> None:
    outline = read_outline(TEXT)
    installed = [block for block in PROGRAM.blocks if block.kind == "approach"]

    found = {name: at for each in outline.passes.values() for name, at in each.stations.items()}
    ends = {end for each in outline.passes.values() for end in each.ways}

    assert {name: at[1] for name, at in found.items()} == {b.fastener_id: b.axes for b in installed}
    assert {leads for _, leads in ends if leads is not None} == set(found)
    assert (None, installed[0].fastener_id) in ends
    assert (installed[-1].fastener_id, None) in ends
    moves = sum(block.kind == "move" for block in PROGRAM.blocks[1:])
    assert sum(len(way.inner) + 1 for each in outline.passes.values() for way in each.ways.values()) == moves


@pytest.mark.parametrize(
    ("edit", "place"),
    [
        (lambda d: d["blocks"][1]["axes"].update(X_mm=None), "/blocks/1/axes/X_mm"),
        (lambda d: d["blocks"].append(7), "/blocks/"),
        (lambda d: d["blocks"][2].update(kind="jump"), "/blocks/2/kind"),
        (lambda d: d.pop("header"), "/header"),
        (lambda d: d.update(fasteners={}), "/fasteners"),
        (lambda d: d.update(blocks=3), "/blocks"),
    ],
)
def test_what_is_no_program_is_refused_with_its_place(
    edit: Callable[[dict[str, Any]], object], place: str
) -> None:
    with pytest.raises(InvalidInput) as caught:
        read_outline(edited(edit))

    assert caught.value.problems[0].pointer.startswith(place)


@given(at=st.integers(0, len(TEXT) - 1), byte=st.integers(0, 255))
def test_a_broken_file_is_read_or_refused(at: int, byte: int) -> None:
    broken = TEXT[:at] + bytes([byte]) + TEXT[at + 1 :]
    try:
        found = read_outline(broken)
    except InvalidInput:
        return
    assert found.sha256 == program_sha256(PROGRAM) or broken[: TEXT.rfind(b',"ver')] != TEXT[: len(broken)]


def test_a_program_without_blocks_has_an_outline() -> None:
    empty = read_outline(edited(lambda d: d.update(blocks=[])))

    assert empty.passes == {}
