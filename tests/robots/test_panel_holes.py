"""Holes that cut a web or run over an edge, and points, normals and sizes in other units."""

import math
import warnings
from typing import Any

import numpy as np
import pytest

from robots.errors import InputProblem
from robots.schema_problems import unit_hint
from robots.surface import Surface
from tests.robots.panels import Document, changed, problems_of, small_panel


def tack(**changes: Any) -> Document:
    """The small panel with other values of its explicit fastener, a 4 mm rivet on the foot of S1."""
    document = small_panel()
    document["fasteners"][0] |= {"grip_mm": "from_stack"} | changes
    return document


def only(document: Document) -> InputProblem:
    (problem,) = problems_of(document)
    return problem


@pytest.mark.parametrize(
    ("y_mm", "sound"), [(0.0, False), (0.7, False), (2.7, False), (2.9, True), (19.1, True), (19.3, False)]
)
def test_a_hole_keeps_off_the_web_and_the_edge_of_its_member(y_mm: float, sound: bool) -> None:
    """S1's web is 1.6 mm thick about y = 0, its foot ends at 21.2 mm; the hole has 2 mm radius."""
    problems = problems_of(tack(p_mm=[100.0, y_mm, 0.0]))

    assert [(p.pointer, p.code) for p in problems] == ([] if sound else [("/fasteners/0", "uneven_stack")])


def test_the_message_names_both_stacks() -> None:
    in_web = only(tack(p_mm=[100.0, 0.0, 0.0]))

    assert "31.60 mm (skin, S1)" in in_web.message
    assert "3.20 mm (skin, S1)" in in_web.message


@pytest.mark.parametrize(("x_mm", "sound"), [(197.9, True), (198.1, False)])
def test_a_hole_keeps_off_the_edge_of_the_skin(x_mm: float, sound: bool) -> None:
    drilled = tack(p_mm=[x_mm, 100.0, 0.0], process="drill_only")

    assert (problems_of(drilled) == []) == sound


def test_a_row_over_the_end_of_its_member_is_told_once_a_member() -> None:
    over_both_ends = problems_of(
        changed("rows/1", small_panel()["rows"][1] | {"start_mm": 0.0, "end_mm": 0.0})
    )

    assert [(p.pointer, p.code) for p in over_both_ends] == [("/rows/1/members/0", "uneven_stack")]
    assert "and 1 more" in over_both_ends[0].message


@pytest.mark.parametrize(("factor", "unit"), [(1000.0, "metres"), (25.4, "inches")])
def test_a_normal_that_is_off_because_the_point_is_in_another_unit_says_so(factor: float, unit: str) -> None:
    surface = Surface(section_radius=1.975)
    p, n = 1000.0 * surface.point(0.1, 0.15), surface.normal(0.1, 0.15)

    problem = only(
        tack(p_mm=(p / factor).tolist(), n=n.tolist()) | {"surface": {"section_radius_mm": 1975.0}}
    )

    assert (problem.pointer, problem.code) == ("/fasteners/0/n", "off_normal")
    assert unit in problem.remedy


@pytest.mark.parametrize("length", [1e-5, 1e160, 1e300, 1e308])
def test_only_the_direction_of_a_normal_counts(length: float) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert problems_of(tack(n=[0.0, 0.0, length])) == []


@pytest.mark.parametrize(
    ("value", "hint"), [(0.0032, "metres"), (3200.0, "micrometres"), (0.126, "inches"), (0.0, ""), (-3.2, "")]
)
def test_a_hint_at_a_unit_names_the_one_that_fits(value: float, hint: str) -> None:
    told = unit_hint(value, 0.5, 100.0)

    assert bool(told) == bool(hint)
    assert f"like {hint}" in told or not hint


def test_a_null_is_shown() -> None:
    assert only(changed("title", None)).value == "null"


def test_a_program_in_place_of_a_panel_is_one_problem() -> None:
    assert [p.code for p in problems_of({"blocks": [], "header": {}, "fasteners": [{"block_n": 1}]})] == [
        "not_a_panel"
    ]


def test_the_rim_follows_the_skin_however_it_is_curved() -> None:
    """A fastener in the middle of the foot is sound at any place of a doubly curved skin."""
    surface = Surface(section_radius=0.6, length_radius=2.0)
    document = small_panel(
        surface={"section_radius_mm": 600.0, "length_radius_mm": 2000.0}, clips=[], rows=[]
    )
    document["fasteners"] = []
    for i, x in enumerate(np.linspace(-0.19, 0.19, 77).tolist()):
        if math.fabs(x) > 0.03:
            p, n = surface.point(x, 0.0132), surface.normal(x, 0.0132)
            document["fasteners"].append(
                {
                    "id": f"f{i}",
                    "p_mm": (1000.0 * p).tolist(),
                    "n": n.tolist(),
                    "diameter_mm": 4.0,
                    "grip_mm": "from_stack",
                    "process": "solid_rivet",
                }
            )

    assert problems_of(document) == []
