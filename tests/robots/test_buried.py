"""Solids inside thick parts, which a surface of triangles does not feel."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.arrays import Array
from robots.buried import BuriedTest, narrowest
from robots.contact import PanelPieces
from robots.panel import Panel
from robots.scene import Scene
from robots.solids import Box, Cylinder, Prism, Shape
from tests.robots.flat_crossing import flat_crossing, part
from tests.robots.panels import inside
from tests.robots.rigs import MACHINE, crossing, shifted

lengths = st.floats(0.01, 1.0)


def width_along(shape: Shape, direction: Array) -> float:
    """Distance of the two planes across a unit `direction` (3,) that hold the shape [m]."""
    if isinstance(shape, Box):
        return float(np.abs(direction) @ shape.size)
    if isinstance(shape, Cylinder):
        across = float(np.hypot(direction[0], direction[1]))
        return 2.0 * shape.radius * across + shape.length * abs(float(direction[2]))
    heights = shape.profile @ direction[[0, 2]]
    return float(np.ptp(heights) + shape.width * abs(direction[1]))


def directions() -> Array:
    """Many directions and the three axes, (N, 3)."""
    d = np.random.default_rng(0).normal(size=(3000, 3))
    turned = np.linspace(0.0, np.pi, 2001)
    plane = np.column_stack([np.cos(turned), np.zeros(2001), np.sin(turned)])
    return np.vstack([d / np.linalg.norm(d, axis=1, keepdims=True), plane, np.eye(3)])


SHAPES: list[Shape] = [
    Box(np.array([0.3, 0.1, 0.2])),
    Cylinder(0.02, 0.3),
    Cylinder(0.3, 0.02),
    Prism(np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 0.1], [0.0, 0.3]]), 0.5),
    Prism(np.array([[0.0, 0.0], [0.3, 0.0], [0.1, 0.2]]), 0.05),
    *(solid.shape for die in MACHINE.dies for solid in die.solids),
]


@pytest.mark.parametrize("shape", SHAPES)
def test_narrowest_width_is_the_least_over_all_directions(shape: Shape) -> None:
    least = min(width_along(shape, d) for d in directions())

    assert narrowest(shape) <= least + 1e-12
    assert narrowest(shape) == pytest.approx(least, rel=2e-3)


@given(st.lists(st.tuples(lengths, lengths), min_size=3, max_size=3, unique=True))
def test_narrowest_width_of_a_triangle_is_its_least_height(corners: list[tuple[float, float]]) -> None:
    points = np.array(corners)
    (ax, ay), (bx, by) = points[1] - points[0], points[2] - points[0]
    twice_area = abs(ax * by - ay * bx)
    longest = max(float(np.linalg.norm(points[i] - points[i - 1])) for i in range(3))
    if twice_area < 1e-3 * longest**2:
        return  # nearly a line: no strictly convex profile

    assert narrowest(Prism(points, 10.0)) == pytest.approx(twice_area / longest, rel=1e-9)


def block(thickness_mm: float) -> Panel:
    """The flat crossing with a plate 100 mm wide across x = 400 mm, of some thickness along y."""
    low = -100.0 - thickness_mm / 2.0
    return flat_crossing((part("block", "box", ((300, low, -200), (500, low + thickness_mm, -20))),))


def test_parts_too_thin_to_hide_the_narrowest_solid_are_not_looked_at() -> None:
    """The straight die's tip is 14 mm across."""
    for thickness_mm, found in ((13.9, False), (14.1, True), (80.0, True)):
        pieces = PanelPieces(block(thickness_mm))

        thick = pieces.thicker_than(0.014).tolist()

        assert thick == ([len(pieces.pieces) - 1] if found else [])


def test_thickness_is_measured_across_faces_not_along_the_axes() -> None:
    turned = flat_crossing()
    pieces = turned.pieces()[0][:1]
    half = np.pi / 4
    rotation = np.array([[np.cos(half), -np.sin(half), 0], [np.sin(half), np.cos(half), 0], [0, 0, 1]])
    plate = part("plate", "box", ((0, 0, 0), (300, 10, 300)))
    oblique = PanelPieces(
        flat_crossing((type(plate)("oblique", "box", plate.pieces @ rotation.T + [0.3, 0.1, -0.5]),))
    )
    last = len(oblique.pieces) - 1

    assert pieces.shape == (1, 8, 3)
    assert np.ptp(oblique.pieces[last], axis=0).min() > 0.2
    assert last in oblique.thicker_than(0.0099)
    assert last not in oblique.thicker_than(0.0101)


@pytest.mark.parametrize("die", ["straight", "j20"])
def test_buried_means_that_the_middle_of_a_solid_is_inside_a_thick_part(die: str) -> None:
    panel = block(80.0)
    scene = Scene(MACHINE, MACHINE.dies[die], panel)
    buried = BuriedTest(scene.chain, scene.solids, PanelPieces(panel))
    rng, seen = np.random.default_rng(3), set()

    for _ in range(300):
        q = shifted(
            MACHINE.home, X=6.25 + rng.uniform(0.25, 0.5), Y=rng.uniform(0.03, 0.17), W=rng.uniform(0.1, 0.35)
        )
        scene.place(q)
        expected = any(inside(panel.part("block").pieces, centre) for centre in scene.centers())
        assert buried(q) is expected
        seen.add(expected)

    assert seen == {True, False}


def test_nothing_is_buried_in_a_panel_of_thin_parts() -> None:
    """Even the tip's middle within a web: the triangles feel that."""
    panel = crossing()
    scene = Scene(MACHINE, MACHINE.dies["straight"], panel)
    buried = BuriedTest(scene.chain, scene.solids, PanelPieces(panel))

    for W in np.linspace(0.0, 0.35, 200):
        assert not buried(shifted(MACHINE.home, X=6.25, W=W))
