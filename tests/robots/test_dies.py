"""The four dies: shapes, heights, one connected piece each, and the library."""

import math
from itertools import combinations
from pathlib import Path

import coal
import numpy as np
import pytest

from robots.coal_shapes import to_coal
from robots.dies import TIP, Die
from robots.errors import UnknownName
from robots.machine_file import load_dies, load_machine
from robots.solids import Cylinder, Prism, Solid, reach_about_axis
from tests.robots.test_solids import placed_points

DIES = load_dies()
each_die = pytest.mark.parametrize("die", DIES.dies, ids=lambda die: die.id)


def gap(a: Solid, b: Solid) -> float:
    """Distance of two solids on one link [m]; zero or negative where they touch."""
    result = coal.DistanceResult()
    placed = [coal.Transform3s(s.T_link_solid[:3, :3], s.T_link_solid[:3, 3]) for s in (a, b)]
    shapes = to_coal(a.shape), to_coal(b.shape)
    return float(coal.distance(shapes[0], placed[0], shapes[1], placed[1], coal.DistanceRequest(), result))


def test_the_library_has_the_four_dies_in_order() -> None:
    assert DIES.ids == ("straight", "j20", "offset35", "long_reach")
    assert len(DIES) == 4
    assert [die.axisymmetric for die in DIES] == [True, False, False, True]


def test_an_unknown_die_is_answered_with_the_ones_there_are() -> None:
    with pytest.raises(UnknownName, match="straight, j20, offset35, long_reach"):
        DIES["j21"]
    assert DIES["j20"] is tuple(DIES)[1]


@each_die
def test_the_tip_ends_at_zero_on_the_tool_axis_and_nothing_is_above_it(die: Die) -> None:
    tip = die.solids[0]

    assert tip.name == TIP
    assert [solid.name for solid in die.solids].count(TIP) == 1
    assert isinstance(tip.shape, Cylinder)
    assert tip.shape.radius == pytest.approx(0.007)
    np.testing.assert_allclose(tip.T_link_solid[:2, 3], 0.0)
    heights = [placed_points(solid)[:, 2].max() for solid in die.solids]
    assert heights[0] == pytest.approx(0.0, abs=1e-15)
    assert max(heights) <= 1e-15


@each_die
def test_every_piece_hangs_together_with_the_tip_and_reaches_the_mounting_face(die: Die) -> None:
    touching = {frozenset((a.name, b.name)) for a, b in combinations(die.solids, 2) if gap(a, b) < 1e-9}
    joined = {TIP}
    for _ in die.solids:
        joined |= {name for pair in touching if pair & joined for name in pair}

    assert joined == set(die.solid_names)
    assert min(placed_points(solid)[:, 2].min() for solid in die.solids) == pytest.approx(-0.250, abs=1e-12)
    assert die.mounting_z == -0.250


def test_pieces_that_do_not_touch_have_a_gap() -> None:
    """The check above can fail: the tip of the J die does not touch its shank."""
    j20 = {solid.name: solid for solid in DIES["j20"].solids}

    assert gap(j20["tip"], j20["shank"]) > 0.02


@each_die
def test_every_die_sits_on_the_slide(die: Die) -> None:
    slide = next(solid for solid in load_machine("riveter").solids if solid.name == "slide")
    foot_of_die = min(die.solids, key=lambda solid: float(placed_points(solid)[:, 2].min()))

    assert gap(slide, foot_of_die) < 1e-9


@pytest.mark.parametrize(
    ("die_id", "name", "u", "z", "half_width"),
    [
        ("straight", "tip", (-7, 7), (-45, 0), 7),
        ("straight", "shank", (-30, 30), (-250, -45), 30),
        ("j20", "tip", (-7, 7), (-4, 0), 7),
        ("j20", "arm", (-7, 31), (-22, -4), 7),
        ("j20", "neck", (9, 31), (-60, -4), 11),
        ("j20", "shank", (-10, 50), (-250, -60), 30),
        ("offset35", "tip", (-7, 7), (-4, 0), 7),
        ("offset35", "arm", (-7, 46), (-24, -4), 7),
        ("offset35", "neck", (24, 46), (-150, -4), 11),
        ("offset35", "shank", (5, 65), (-250, -150), 30),
        ("long_reach", "tip", (-7, 7), (-10, 0), 7),
        ("long_reach", "body", (-14, 14), (-250, -10), 14),
    ],
)
def test_extents_are_those_of_the_drawings(
    die_id: str, name: str, u: tuple[float, float], z: tuple[float, float], half_width: float
) -> None:
    solid = next(solid for solid in DIES[die_id].solids if solid.name == name)

    points = placed_points(solid) * 1000.0

    np.testing.assert_allclose(points.min(axis=0), [u[0], -half_width, z[0]], atol=1e-9)
    np.testing.assert_allclose(points.max(axis=0), [u[1], half_width, z[1]], atol=1e-9)


def test_the_arms_are_chamfered_below() -> None:
    """The lower corner of the arm beside the tip: 12 mm down at the tip, full depth at the neck."""
    for die_id, deep, at in (("j20", -0.022, 0.009), ("offset35", -0.024, 0.024)):
        arm = next(solid for solid in DIES[die_id].solids if solid.name == "arm")
        assert isinstance(arm.shape, Prism)
        corners = {tuple(corner) for corner in arm.shape.profile.tolist()}
        assert {(-0.007, -0.012), (at, deep)} < corners


def test_reach_about_the_tool_axis_is_that_of_the_shank_or_neck() -> None:
    reach = {die.id: max(reach_about_axis(s, (0, 0, 0), (0, 0, 1)) for s in die.solids) for die in DIES}

    assert reach["straight"] == pytest.approx(0.030)
    assert reach["j20"] == pytest.approx(0.050)
    assert reach["offset35"] == pytest.approx(0.065)
    assert reach["long_reach"] == pytest.approx(0.014)
    neck = DIES["j20"].solids[2]
    assert reach_about_axis(neck, (0, 0, 0), (0, 0, 1)) == pytest.approx(math.hypot(0.031, 0.011))


def test_the_hash_depends_on_content_and_not_on_layout(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "robots/data/dies.json").read_text()
    (tmp_path / "same.json").write_text("".join(line.strip() for line in text.splitlines()))
    (tmp_path / "other.json").write_text(text.replace("[31, -22]", "[31, -22.001]"))

    assert load_dies(tmp_path / "same.json").sha256 == DIES.sha256
    assert load_dies(tmp_path / "other.json").sha256 != DIES.sha256
