"""Escape files: written and read back to the last digit, and everything wrong with one told at once."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from planners.escapes import Escape
from robots.errors import InvalidInput
from robots.escape_file import FamilyEscapes, kinematics_sha256, read_escapes
from robots.riveter_search import planner_settings
from robots.surroundings import FARTHEST, WAYS, joined
from tests.robots.rigs import MACHINE


def escape(name: str, free: float = 0.03, X: float = 0.1, detour: float = 0.05) -> Escape:
    ends = [
        joined(np.full(WAYS, free), np.array([0.02, -0.01])),
        joined(np.full(WAYS, FARTHEST), np.zeros(2)),
    ]
    offsets = np.zeros((3, 7))
    offsets[1, 5], offsets[2, 0], offsets[2, 6] = -detour, X, np.radians(30.0)
    return Escape(name, np.array(ends), offsets)


def family(**of_die: tuple[Escape, ...]) -> FamilyEscapes:
    return FamilyEscapes("shell", MACHINE, {}).with_found(of_die)


SAMPLE = family(straight=(escape("a"), escape("b", free=0.05)), offset35=(escape("c"),))


def equal(one: FamilyEscapes, other: FamilyEscapes) -> bool:
    return one.id == other.id and all(
        (a.name == b.name and np.array_equal(a.where, b.where) and np.array_equal(a.offsets, b.offsets))
        for die in one.of_die.keys() | other.of_die.keys()
        for a, b in zip(one.of_die[die], other.of_die[die], strict=True)
    )


def test_what_is_written_is_read_back_to_the_last_digit() -> None:
    again = read_escapes(SAMPLE.text, MACHINE)

    assert equal(again, SAMPLE)
    assert again.text == SAMPLE.text
    assert again.sha256 == SAMPLE.sha256
    assert SAMPLE.text.endswith(b"}\n")


def test_the_identity_is_that_of_the_content_not_of_its_layout() -> None:
    spread = json.dumps(json.loads(SAMPLE.text), indent=2).encode()

    assert read_escapes(spread, MACHINE).sha256 == SAMPLE.sha256
    assert family(straight=(escape("a"),)).sha256 != SAMPLE.sha256


def test_units_stand_in_the_names() -> None:
    first = json.loads(SAMPLE.text)["dies"][1]["escapes"][0]

    assert first["offsets"][2]["X_mm"] == 100.0
    assert first["offsets"][2]["C_deg"] == 30.0
    assert first["start"]["free_mm"] == [30.0] * WAYS
    assert first["start"]["die_mm"] == [20.0, -10.0]


def test_what_is_found_is_added_without_twins_and_the_quicker_one_stays() -> None:
    more = SAMPLE.with_found({"straight": [escape("slow", detour=0.2), escape("new", free=0.07)]})
    quick = SAMPLE.with_found({"straight": [escape("quick", detour=0.01)]})

    assert [each.name for each in more.of_die["straight"]] == ["a", "b", "new"]
    assert [each.name for each in quick.of_die["straight"]] == ["quick", "b"]
    assert [each.name for each in more.of_die["offset35"]] == ["c"]


def test_a_die_keeps_so_many_and_forgets_the_oldest() -> None:
    kept = planner_settings(MACHINE).escapes_kept
    many = tuple(escape(f"{i}", X=0.05 + 0.03 * i) for i in range(kept + 3))

    full = family(straight=many)

    assert [each.name for each in full.of_die["straight"]] == [f"{i}" for i in range(3, kept + 3)]
    assert equal(read_escapes(full.text, MACHINE), full)


def problems(change: Callable[[Any], object]) -> list[tuple[str, str]]:
    """Code and place of every problem of the sample after a change of its document."""
    document = json.loads(SAMPLE.text)
    change(document)
    with pytest.raises(InvalidInput) as raised:
        read_escapes(json.dumps(document).encode(), MACHINE)
    assert all(problem.remedy for problem in raised.value.problems)
    return [(problem.code, problem.pointer) for problem in raised.value.problems]


def at(document: Any) -> Any:
    return document["dies"][1]["escapes"][0]


@pytest.mark.parametrize(
    ("change", "code", "pointer"),
    [
        (lambda d: d["machine"].update(id="mill"), "other_machine", "/machine/id"),
        (
            lambda d: d["machine"].update(kinematics_sha256="0" * 64),
            "other_kinematics",
            "/machine/kinematics_sha256",
        ),
        (lambda d: d["dies"][0].update(die_id="spoon"), "unknown_die", "/dies/0/die_id"),
        (lambda d: d["dies"][0].update(die_id="straight"), "duplicate_die", "/dies/1/die_id"),
        (lambda d: d["dies"][0].update(escapes=d["dies"][0]["escapes"] * 65), "too_many", "/dies/0/escapes"),
        (lambda d: at(d)["goal"]["free_mm"].pop(), "wrong_length", "/dies/1/escapes/0/goal/free_mm"),
        (
            lambda d: at(d)["goal"]["free_mm"].__setitem__(3, 101.0),
            "out_of_range",
            "/dies/1/escapes/0/goal/free_mm/3",
        ),
        (lambda d: at(d)["offsets"][0].update(X_mm=1.0), "bad_path", "/dies/1/escapes/0/offsets"),
        (lambda d: at(d).update(offsets=at(d)["offsets"][:1]), "bad_path", "/dies/1/escapes/0/offsets"),
        (lambda d: at(d)["offsets"][1].update(W_mm=-63000.0), "out_of_range", "/dies/1/escapes/0/offsets/1"),
        (lambda d: at(d)["offsets"][1].update(W_m=-0.05), "unknown_field", "/dies/1/escapes/0/offsets/1/W_m"),
        (
            lambda d: at(d)["offsets"][1].update(W_mm=float("nan")),
            "wrong_type",
            "/dies/1/escapes/0/offsets/1/W_mm",
        ),
        (lambda d: d.pop("units"), "missing_field", "/units"),
        (lambda d: d.update(schema_version="2.0"), "wrong_type", "/schema_version"),
    ],
)
def test_what_is_wrong_is_told_with_place_and_remedy(
    change: Callable[[Any], object], code: str, pointer: str
) -> None:
    assert problems(change) == [(code, pointer)]


def test_problems_of_several_places_are_told_together() -> None:
    def change(document: Any) -> None:
        document["machine"]["id"] = "mill"
        at(document)["start"]["free_mm"][0] = -1.0
        at(document)["offsets"][2]["A_deg"] = 4000.0

    assert len(problems(change)) == 3


def test_a_machine_with_other_axes_has_another_digest_and_one_that_is_only_slower_has_not() -> None:
    axes = MACHINE.axes
    slower = replace(MACHINE, axes=(replace(axes[0], v_max=0.1), *axes[1:]))
    turned = replace(MACHINE, axes=(replace(axes[0], direction=np.array([0.0, 1.0, 0.0])), *axes[1:]))

    assert kinematics_sha256(slower) == kinematics_sha256(MACHINE)
    assert kinematics_sha256(turned) != kinematics_sha256(MACHINE)
