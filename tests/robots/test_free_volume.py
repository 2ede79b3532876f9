"""GAV: volumes known in closed form, the laws, the file."""

import io
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.free_volume import (
    FreeVolume,
    Section,
    Tool,
    box_tool,
    cylinder_tool,
    die_tool,
    free_volume,
    section_at,
    to_glb,
)
from robots.free_volume.booleans import box, mesh_of
from robots.free_volume.outer import ROUNDING
from robots.panel import Panel, Part
from tests.robots.flat_crossing import MM, part
from tests.robots.free_volumes import cube, flat, mm3, section, shifted, walls
from tests.robots.rigs import MACHINE, crossing

WITHIN = 3e-4
"""Of a length of a centimetre, what the obstacles are grown by against rounding."""

ROUNDED = 2e-9
"""[m^3] Ten nanometres on the surface of a section."""


def test_under_a_bare_skin_everything_below_the_clearance_is_accessible() -> None:
    found = free_volume(flat(), cube(20.0, clearance=2.0), section(100, 80, 60))

    height = 60.0 - 1.6 - 2.0 - ROUNDING / MM
    assert mm3(found.accessible_volume) == pytest.approx(200 * 160 * height, rel=1e-6)
    assert mm3(found.blocked_volume) == pytest.approx(200 * 160 * (60.0 - height), rel=1e-5)
    assert found.pockets == ()


def test_place_behind_a_lid_is_an_unreachable_pocket_of_known_volume() -> None:
    found = free_volume(flat(*walls(height=80)), cube(20.0), section(49, 49, 300))

    (pocket,) = found.pockets
    assert mm3(pocket.volume) == pytest.approx(80.0**2 * (80 - 1.6 - 20), rel=WITHIN)
    np.testing.assert_allclose(pocket.lower / MM, [-40, -40, -60], atol=0.01)
    np.testing.assert_allclose(pocket.upper / MM, [40, 40, -1.6], atol=0.01)
    assert found.state_at(np.array([0.0, 0.0, -0.03])) == "unreachable"
    assert found.state_at(np.array([0.0, 0.0, -0.2])) == "accessible"
    assert found.state_at(np.array([0.0, 0.0, -0.07])) == "blocked"
    assert found.blocking(np.array([0.0, 0.0, -0.07])) == [("lid", "box")]
    assert found.blocking(np.array([0.0, 0.0, -0.03])) == []


@pytest.mark.parametrize(("hole", "opens"), [(20.0 + 2.02, True), (20.0 + 1.98, False), (19.0, False)])
def test_mouse_hole_opens_the_pocket_where_it_is_wide_enough_for_tool_and_clearance(
    hole: float, opens: bool
) -> None:
    found = free_volume(flat(*walls(height=80, hole=hole)), cube(20.0, clearance=1.0), section(49, 49, 300))

    inside = np.array([0.0, 0.0, -0.03])
    assert found.state_at(inside) == ("accessible" if opens else "unreachable")
    assert len(found.pockets) == (0 if opens else 1)


def test_section_that_ends_inside_a_hollow_part_has_no_false_way_in() -> None:
    found = free_volume(flat(*walls(height=80)), cube(20.0), section(30, 30, 50))

    assert found.accessible is None
    assert found.accessible_volume == 0.0
    (pocket,) = found.pockets
    assert mm3(pocket.volume) == pytest.approx(60.0**2 * (50 - 1.6), rel=WITHIN)


def test_hole_in_the_free_volume_and_a_pocket_in_that_hole_are_told_apart() -> None:
    """A hollow block floats in the middle: outside free, block blocked, its inside a pocket."""
    block = part(
        "block",
        "box",
        ((-40, -40, -200), (40, 40, -190)),
        ((-40, -40, -130), (40, 40, -120)),
        ((-40, -40, -190), (-30, 40, -130)),
        ((30, -40, -190), (40, 40, -130)),
        ((-30, -40, -190), (30, -30, -130)),
        ((-30, 30, -190), (30, 40, -130)),
    )

    found = free_volume(flat(block), cube(10.0), section(100, 100, 300))

    (pocket,) = found.pockets
    assert mm3(pocket.volume) == pytest.approx(50.0**2 * 50.0, rel=WITHIN)
    outside = 200.0**2 * (300 - 1.6) - 90.0**2 * 90.0
    assert mm3(found.accessible_volume) == pytest.approx(outside, rel=WITHIN)
    assert found.state_at(np.array([0.0, 0.0, -0.155])) == "unreachable"
    assert found.state_at(np.array([0.035, 0.0, -0.15])) == "blocked"


def test_tool_larger_than_the_space_fits_nowhere() -> None:
    found = free_volume(flat(*walls(height=80)), cube(99.0), section(30, 30, 50))

    assert (found.accessible, found.pockets) == (None, ())
    assert mm3(found.blocked_volume) == pytest.approx(60 * 60 * 50)
    assert to_glb(found)


def test_nothing_near_leaves_the_whole_section() -> None:
    far = Section(np.eye(4), np.array([2.0, 2.0, -0.1]), np.array([2.1, 2.1, 0.0]))

    found = free_volume(flat(), cube(10.0), far)

    assert found.accessible_volume == pytest.approx(1e-3, rel=1e-12)
    assert found.blocked is None


offsets_mm = st.integers(-60, 60)


@st.composite
def blocks(draw: st.DrawFn) -> Part:
    x, y, z = draw(offsets_mm), draw(offsets_mm), draw(st.integers(-150, -10))
    w, d, h = (draw(st.integers(3, 80)) for _ in range(3))
    return part("block", "box", ((x, y, z - h), (x + w, y + d, z)))


def volume_of(panel: Panel, tool: Tool, around: Section | None = None) -> FreeVolume:
    return free_volume(panel, tool, around or section(90, 90, 200))


@given(blocks(), blocks(), st.floats(5.0, 60.0), st.floats(0.0, 20.0), st.floats(0.0, 5.0))
@settings(max_examples=6)
def test_another_obstacle_a_larger_tool_or_more_clearance_never_makes_more_accessible(
    first: Part, second: Part, size: float, more: float, clearance: float
) -> None:
    base = volume_of(flat(first), cube(size, clearance))
    others = [
        volume_of(flat(first, replace(second, id="other")), cube(size, clearance)),
        volume_of(flat(first), cube(size + more, clearance)),
        volume_of(flat(first), cube(size, clearance + more)),
    ]
    points = np.random.default_rng(4).uniform(base.section.lower, base.section.upper, (25, 3))

    for other in others:
        assert other.accessible_volume <= base.accessible_volume + ROUNDED
        if other.accessible is not None:
            within = points[other.accessible.windings(points) > 0.5]
            assert {base.state_at(point) for point in within} <= {"accessible"}


@given(blocks(), st.floats(-3.0, 3.0), st.tuples(*[st.floats(-1.0, 1.0)] * 3), st.floats(-0.4, 0.4))
@settings(max_examples=5)
def test_moving_everything_changes_nothing(
    block: Part, about_z: float, by: tuple[float, float, float], tilt: float
) -> None:
    c, s, ct, tt = np.cos(about_z), np.sin(about_z), np.cos(tilt), np.sin(tilt)
    T = shifted(np.array(by))
    T[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array(
        [[1, 0, 0], [0, ct, -tt], [0, tt, ct]]
    )
    panel = flat(*walls(height=120), block)
    moved = replace(
        panel,
        parts=tuple(replace(p, pieces=p.pieces @ T[:3, :3].T + T[:3, 3]) for p in panel.parts),
    )
    here = section(90, 90, 200)

    still = volume_of(panel, cylinder_tool(0.012, 0.04, 0.002), here)
    gone = volume_of(moved, cylinder_tool(0.012, 0.04, 0.002), replace(here, T_panel_section=T))

    assert mm3(gone.accessible_volume) == pytest.approx(mm3(still.accessible_volume), abs=1.0)
    assert mm3(gone.unreachable_volume) == pytest.approx(mm3(still.unreachable_volume), abs=1.0)


def test_box_turned_by_a_quarter_is_the_box_with_its_sides_swapped() -> None:
    panel = flat(*walls(height=80, hole=30.0))

    turned = volume_of(panel, box_tool((0.02, 0.04, 0.03), np.pi / 2.0, 0.001))
    swapped = volume_of(panel, box_tool((0.04, 0.02, 0.03), 0.0, 0.001))

    assert turned.pockets
    assert mm3(turned.accessible_volume) == pytest.approx(mm3(swapped.accessible_volume), abs=1.0)
    assert mm3(turned.unreachable_volume) == pytest.approx(mm3(swapped.unreachable_volume), abs=1.0)
    oblong = volume_of(
        flat(part("wall", "box", ((0, -500, -100), (2, 500, 0)))), box_tool((0.02, 0.08, 0.03), 0.0, 0.0)
    )
    assert mm3(oblong.blocked_volume) == pytest.approx(22 * 180 * 100 + (180 - 22) * 180 * 1.6, rel=1e-3)


def test_splitting_an_obstacle_changes_nothing() -> None:
    whole = part("bar", "box", ((-30, -50, -80), (40, 50, -60)))
    split = part("bar", "box", ((-30, -50, -80), (5, 50, -60)), ((5, -50, -80), (40, 50, -60)))

    one, two = (volume_of(flat(bar), cube(30.0, clearance=2.0)) for bar in (whole, split))

    assert mm3(one.accessible_volume) == pytest.approx(mm3(two.accessible_volume), abs=1.0)


def test_glb_has_a_closed_surface_for_every_part_of_the_section_in_the_panels_frame() -> None:
    found = free_volume(flat(*walls(height=80)), cube(20.0), section(49, 49, 300))
    moved = replace(found, section=replace(found.section, T_panel_section=shifted(np.array([1.0, 2.0, 3.0]))))

    scene = trimesh.load(io.BytesIO(to_glb(moved)), file_type="glb")

    assert isinstance(scene, trimesh.Scene)
    assert set(scene.geometry) == {"accessible", "blocked", "unreachable_1"}
    volumes = {name: mm3(mesh.volume) for name, mesh in scene.geometry.items()}
    assert volumes["accessible"] == pytest.approx(mm3(found.accessible_volume), rel=1e-5)
    assert volumes["unreachable_1"] == pytest.approx(mm3(found.unreachable_volume), rel=1e-5)
    assert volumes["blocked"] == pytest.approx(mm3(found.blocked_volume), rel=1e-4)
    assert all(mesh.is_watertight for mesh in scene.geometry.values())
    np.testing.assert_allclose(scene.bounds[0], [1 - 0.049, 2 - 0.049, 3 - 0.3], atol=1e-6)


def test_same_question_gives_the_same_bytes() -> None:
    panel = crossing()
    around = section_at(MACHINE, panel, panel.fasteners[4], [-0.1, -0.08, -0.2], [0.1, 0.08, 0.0])
    assert isinstance(around, Section)
    first, second = (
        to_glb(free_volume(panel, die_tool(MACHINE, MACHINE.dies["j20"], 0.7, 0.0), around)) for _ in range(2)
    )

    assert first == second


def test_windings_tell_inside_from_outside() -> None:
    mesh = mesh_of(box(np.array([-0.09, -0.09, -0.2]), np.array([0.09, 0.09, 0.0])))

    inside = mesh.windings(np.array([[0.0, 0.0, -0.1], [0.0, 0.0, 0.1], [0.089, 0.089, -0.001]]))

    np.testing.assert_allclose(inside, [1.0, 0.0, 1.0], atol=1e-9)
