"""Adjustments: one fastener of a row moved over the skin or tilted, and all that can be wrong with that."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.panel import Fastener, Panel
from robots.panel_adjustments import moved, tilted
from robots.panel_file import load_panel
from robots.surface import Surface
from tests.robots.panels import SURFACES, found, problems_of, small_panel

NAME = "R1.S1.003"


def panel(*adjustments: dict[str, Any], surface: dict[str, Any] | None = None) -> Panel:
    return load_panel(small_panel(adjustments=list(adjustments), surface=surface or {}))


def fastener_of(of: Panel, name: str = NAME) -> Fastener:
    return next(fastener for fastener in of.fasteners if fastener.id == name)


@pytest.mark.parametrize("surface", SURFACES[:2])
def test_one_fastener_of_a_row_is_moved_along_it_and_the_others_stay(surface: dict[str, Any]) -> None:
    before, after = panel(surface=surface), panel({"fastener": NAME, "x_mm": 4.0}, surface=surface)

    assert [f.id for f in after.fasteners] == [f.id for f in before.fasteners]
    for old, new in zip(before.fasteners, after.fasteners, strict=True):
        apart = np.linalg.norm(new.p - old.p)
        assert apart == pytest.approx(0.004 if new.id == NAME else 0.0, abs=1e-12)
        assert np.allclose(new.n, old.n, atol=1e-12)
    assert after.stacks == before.stacks


def test_a_tilted_axis_leans_as_far_as_it_is_told_and_its_stack_is_found_anew() -> None:
    before, after = panel(), panel({"fastener": NAME, "tilt_x_deg": 1.0, "tilt_arc_deg": -0.5})

    n = fastener_of(after).n
    assert math.degrees(math.atan(n[0] / n[2])) == pytest.approx(1.0)
    assert math.degrees(math.atan(n[1] / n[2])) == pytest.approx(-0.5)
    assert np.array_equal(fastener_of(after).p, fastener_of(before).p)
    i = [f.id for f in after.fasteners].index(NAME)
    assert after.stacks[i].grip == pytest.approx(before.stacks[i].grip / n[2], rel=1e-9)
    assert after.sha256 != before.sha256


@settings(max_examples=50, deadline=None)
@given(
    st.sampled_from(SURFACES),
    *[st.floats(-0.15, 0.15)] * 4,
    *[st.floats(-0.03, 0.03)] * 2,
)
def test_moving_and_tilting_are_undone_by_their_opposites(
    surface: dict[str, float], u: float, v: float, x: float, arc: float, a: float, b: float
) -> None:
    skin = Surface(
        *(1e-3 * surface[k] if k in surface else None for k in ("section_radius_mm", "length_radius_mm"))
    )
    there = Fastener("f", skin.point(u, v), skin.normal(u, v), 0.004, 0.003, "solid_rivet")

    away = moved(tilted(there, skin, a, b), skin, x, arc)

    u_away, v_away, depth = skin.locate(away.p)
    assert float(v_away - v) == pytest.approx(arc, abs=1e-9)
    assert float(u_away - u) * skin.arc_scale(v) == pytest.approx(x, abs=1e-9)
    assert float(depth) == pytest.approx(0.0, abs=1e-9)
    lean = math.atan(math.hypot(math.tan(a), math.tan(b)))
    assert math.acos(min(1.0, float(away.n @ skin.normal(u_away, v_away)))) == pytest.approx(lean, abs=1e-6)
    if skin.length_radius is None:
        back = tilted(moved(away, skin, -x, -arc), skin, -a, -b)
        assert np.allclose(back.p, there.p, atol=1e-9)
        assert np.allclose(back.n, there.n, atol=2e-3)


@pytest.mark.parametrize(
    ("adjustments", "faults"),
    [
        ([{"fastener": "R1.S1.999"}], [("/adjustments/0/fastener", "unknown_fastener")]),
        ([{"fastener": NAME}, {"fastener": NAME}], [("/adjustments/1/fastener", "duplicate_adjustment")]),
        ([{"fastener": NAME, "tilt_x_deg": 3.0}], [("/adjustments/0/tilt_x_deg", "out_of_range")]),
        (
            [{"fastener": NAME, "tilt_x_deg": 1.9, "tilt_arc_deg": 1.9}],
            [("/adjustments/0", "off_normal")],
        ),
        ([{"fastener": "tack", "x_mm": 150.0}], [("/adjustments/0", "off_skin")]),
        ([{"fastener": NAME, "arc_mm": 60.0}], [("/rows/0/members/0", "misses_member")]),
        ([{"fastener": NAME, "x_mm": 22.0}], [("/rows/0/members/0", "fasteners_overlap")]),
        ([{"fastener": NAME, "x_in": 1.0}], [("/adjustments/0/x_in", "unknown_field")]),
    ],
)
def test_what_cannot_be_is_told_with_its_place(
    adjustments: list[dict[str, Any]], faults: list[tuple[str, str]]
) -> None:
    assert faults == [each for each in found(small_panel(adjustments=adjustments)) if each in faults]


def test_a_fault_of_a_moved_fastener_names_the_adjustment() -> None:
    (problem,) = problems_of(small_panel(adjustments=[{"fastener": NAME, "arc_mm": 60.0}]))

    assert NAME in problem.message
    assert problem.remedy.startswith("It is adjusted by /adjustments/0. ")
