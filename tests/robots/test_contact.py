"""The meant contact: which pieces a die tip may touch, and that it must keep clear of all others."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots import hexahedra
from robots.contact import PanelPieces, TipScene
from robots.dies import TIP
from robots.kernel.flat import piece_rows
from robots.kernel.under_face import line_exit
from robots.panel import Fastener, Panel, Part, Stack
from tests.robots.flat_crossing import MM, fastener, flat_crossing, part
from tests.robots.rigs import crossing, distance_to, on_surface, riveted, shifted, station, with_fasteners

RADIUS = 7 * MM
DEPTH = 0.1 * MM
SKIN, WEB, FLANGE = 0, 1, 2
"""Pieces of the flat crossing: the skin, then the stringer's web and its flange on the skin."""


def under(panel: Panel, index: int = 0, beyond: float = 1 * MM, radius: float = RADIUS) -> set[int]:
    pieces = PanelPieces(panel)
    found = pieces.under_face(panel.fasteners[index], panel.stacks[index], radius, beyond, DEPTH)
    return set(found.tolist())


def at_y(y_mm: float, extra: tuple[Part, ...] = (), stack: Stack | None = None) -> Panel:
    panel = flat_crossing(extra)
    return with_fasteners(panel, [fastener("f", 60.0, y_mm)], stack or panel.stacks[0])


@pytest.mark.parametrize("y_mm", [-14.0, -9.0, -5.0])
def test_skin_and_flange_are_under_the_face_and_the_web_is_not(y_mm: float) -> None:
    assert under(at_y(y_mm)) == {SKIN, FLANGE}


def split(z_mm: float = -3.2, own_part: bool = False) -> Panel:
    """A flange whose other half begins 7.5 mm from the fastener, ends at z and may be a part of its own."""
    west = part("west", "stringer", ((0, -22, -3.2), (67.5, -1.6, -1.6)))
    east = part("east", "stringer", ((67.5, -22, z_mm), (120, -1.6, -1.6)))
    both = Part("west", "stringer", np.concatenate([west.pieces, east.pieces]))
    skin = part("skin", "skin", ((-600, -300, -1.6), (600, 300, 0)))
    panel = replace(flat_crossing(), parts=(skin, west, east) if own_part else (skin, both))
    return with_fasteners(panel, [fastener("f", 60.0, -12.0)], Stack(("skin", "west"), 3.2 * MM, 3.2 * MM))


def test_a_flush_piece_of_a_part_outside_the_stack_is_not_allowed() -> None:
    assert under(split()) == {0, 1, 2}
    assert under(split(own_part=True)) == {0, 1}


@pytest.mark.parametrize(("deeper_mm", "allowed"), [(-0.5, True), (0.09, True), (0.11, False), (2.0, False)])
def test_a_piece_may_be_deeper_than_the_tip_stands_by_the_contact_depth_only(
    deeper_mm: float, allowed: bool
) -> None:
    assert under(split(-3.2 - deeper_mm)) == ({0, 1, 2} if allowed else {0, 1})


def test_a_lip_deeper_than_the_tip_stands_is_not_allowed_though_it_lies_under_the_face() -> None:
    """Under y = +10 mm the same stringer has its top flange, 30 mm below the skin."""
    assert under(at_y(10.0)) == {SKIN}


@pytest.mark.parametrize(("beyond_mm", "allowed"), [(0.0, False), (0.4, False), (0.7, True), (2.0, True)])
def test_a_flush_piece_beside_the_face_is_allowed_within_the_ring(beyond_mm: float, allowed: bool) -> None:
    """It lies as deep as the tip stands and 7.5 mm from the axis: nearer than the clearance, by design."""
    assert under(split(), beyond=beyond_mm * MM) == ({0, 1, 2} if allowed else {0, 1})


def disc(fastener: Fastener, radius: float, rng: np.random.Generator) -> Array:
    """Points of the plane through p across n, within `radius`, (N, 3)."""
    across = np.linalg.svd(fastener.n[None])[2][1:]
    r, angle = radius * np.sqrt(rng.uniform(0, 1, 1500)), rng.uniform(0, 2 * np.pi, 1500)
    points: Array = fastener.p + (r[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])) @ across
    return points


def pierced(panel: Panel, index: int, radius: float, rng: np.random.Generator) -> set[int]:
    """Pieces of the stack met by sampled lines through the disc, none of them deeper than the tip stands."""
    fastener, stack = panel.fasteners[index], panel.stacks[index]
    pieces, part_index = panel.pieces()
    normals, offsets = hexahedra.planes(pieces)
    start = disc(fastener, radius, rng)
    found = set()
    for piece in np.flatnonzero(np.isin(part_index, [panel.part_ids.index(i) for i in stack.parts])):
        inside = {
            deep: (normals[piece] @ (start - deep * fastener.n).T <= offsets[piece][:, None])
            .all(axis=0)
            .any()
            for deep in np.arange(0.05, 45.0, 0.2) * MM
        }
        deepest = max((deep for deep, hit in inside.items() if hit), default=np.inf)
        if deepest <= stack.depth + DEPTH:
            found.add(int(piece))
    return found


def test_pieces_under_the_face_of_a_curved_panel_are_those_that_sampling_finds() -> None:
    panel, rng = crossing(), np.random.default_rng(0)
    assert sum(len(p.pieces) for p in panel.parts if p.kind == "skin") > 1

    for index in (0, 3, 4, 8, 11):
        allowed = under(panel, index)

        assert pierced(panel, index, RADIUS, rng) <= allowed
        assert allowed <= pierced(panel, index, RADIUS + 1 * MM, rng)


def test_both_chords_of_a_bent_skin_are_under_a_face_over_their_seam() -> None:
    panel = crossing()
    pieces, part_index = panel.pieces()
    skin = pieces[part_index == panel.part_ids.index("skin")]
    low = np.sort(skin[:, :, 1].max(axis=1))
    seam = float(low[np.searchsorted(low, 0.09)])
    over = on_surface(panel, (0.15, float(panel.surface.locate(np.array([0.15, seam, 0.0]))[1])))

    assert len(under(over)) == 2


def exits_of(pieces: Array, origins: Array, direction: Array) -> Array:
    """Where lines from `origins` (R, 3) leave each piece (H, 8, 3): parameters (R, H) [m]."""
    rows = piece_rows(pieces)
    return np.array([[line_exit(rows, h, *o, *direction) for h in range(len(rows))] for o in origins])


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_lines_leave_convex_pieces_where_sampling_says(seed: int) -> None:
    """A line is sampled every 1/500 of its length; a chord shorter than a step may be missed by sampling."""
    rng = np.random.default_rng(seed)
    shear = rng.normal(size=(3, 3)) + 2.0 * np.eye(3)
    pieces = hexahedra.outward(hexahedra.box(-np.ones((1, 3)), np.ones((1, 3))) @ shear.T)
    normals, offsets = hexahedra.planes(pieces)
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    origins = rng.normal(size=(20, 3)) * 2.0
    t, step = np.linspace(-20.0, 20.0, 10001, retstep=True)

    exits = exits_of(pieces, origins, direction)
    entries = -exits_of(pieces, origins, -direction)

    assert exits.shape == (20, 1)
    for origin, leave, enter in zip(origins, exits[:, 0], entries[:, 0], strict=True):
        points = origin + t[:, None] * direction
        inside = (points @ normals[0].T <= offsets[0]).all(axis=1)
        if inside.any():
            assert t[inside].max() <= leave + 1e-9 <= t[inside].max() + step + 2e-9
        else:
            assert leave == -np.inf or leave - enter < step


def test_lines_along_a_face_miss_the_piece_beside_them_and_cross_the_one_they_are_in() -> None:
    pieces = hexahedra.box(np.array([[0.0, 0, 0], [2, 0, 0]]), np.array([[1.0, 1, 1], [3, 1, 1]]))

    exits = exits_of(pieces, np.array([[0.5, 0.5, 3.0], [1.5, 0.5, 3.0]]), np.array([0, 0, -1.0]))

    assert exits.tolist() == [[3.0, -np.inf], [-np.inf, -np.inf]]


def tip_scene(allowed: set[int]) -> tuple[TipScene, Array]:
    """The W move at fastener 3 of the flat crossing with the straight die; the clamped pose."""
    where = riveted(flat_crossing(), "straight")
    reached = station(where, 3)
    pieces = PanelPieces(where.panel)
    local = np.setdiff1d(np.arange(len(pieces.pieces)), sorted(allowed))
    return TipScene(where.scene, where.tip_pair, pieces, local), reached.clamped


def test_the_tip_alone_is_answered_differently_from_the_whole_scene() -> None:
    where = riveted(flat_crossing(), "straight")
    at_tip, clamped = tip_scene({SKIN, FLANGE})
    rng = np.random.default_rng(1)

    for _ in range(30):
        q = shifted(clamped, Y=rng.uniform(-0.03, 0.03), W=rng.uniform(-0.03, 0.0), C=rng.uniform(-1, 1))
        where.scene.place(q)
        at_tip.place(q)
        for k in range(len(where.scene.pairs)):
            if k != where.tip_pair:
                for margin in (0.0, 0.001, 0.01, 0.05):
                    assert at_tip.within(k, margin) == where.scene.within(k, margin)


def test_the_tip_keeps_clear_of_every_piece_but_the_allowed_ones() -> None:
    where = riveted(flat_crossing(), "straight")
    at_tip, clamped = tip_scene({SKIN, FLANGE})
    pieces, _ = where.panel.pieces()
    others = np.setdiff1d(np.arange(len(pieces)), [SKIN, FLANGE])
    rng, near = np.random.default_rng(2), 0

    for _ in range(40):
        q = shifted(clamped, Y=rng.uniform(-0.008, 0.008), W=rng.uniform(-0.01, 0.0))
        at_tip.place(q)
        where.scene.place(q)
        apart = distance_to(where, TIP, pieces[others])
        if apart < 1e-4:
            continue
        assert not at_tip.within(where.tip_pair, apart - 1e-5)
        assert at_tip.within(where.tip_pair, apart + 1e-5)
        distance, name = at_tip.nearest()
        assert distance == pytest.approx(apart, abs=1e-6)
        assert distance_to(where, TIP, where.panel.part(name).pieces) <= apart + 1e-6
        near += apart < 0.005

    assert near > 5


def test_the_contact_of_a_clamped_pose_counts_for_the_scene_and_not_for_the_tip() -> None:
    where = riveted(flat_crossing(), "straight")
    at_tip, clamped = tip_scene({SKIN, FLANGE})

    at_tip.place(clamped)
    where.scene.place(clamped)

    assert where.scene.within(where.tip_pair, 1e-6)
    assert not at_tip.within(where.tip_pair, 1 * MM)
    at_tip.place(shifted(clamped, Y=-0.010))
    assert at_tip.within(where.tip_pair, 0.0)
    assert at_tip.nearest()[1] == "S1"


def test_a_tip_with_nothing_around_it_is_free_and_has_no_nearest_part() -> None:
    everything = set(range(len(flat_crossing().pieces()[0])))
    at_tip, clamped = tip_scene(everything)

    at_tip.place(clamped)

    assert not at_tip.within(riveted(flat_crossing(), "straight").tip_pair, 1.0)
    assert at_tip.nearest() == (np.inf, "")


def test_the_nearest_part_is_named_among_many() -> None:
    """Posts 30 mm apart along x; the tip is moved beside each of them."""
    posts = [part(f"post{i}", "box", ((60 + i * 30, 40, -40), (62 + i * 30, 44, -5))) for i in range(12)]
    where = riveted(flat_crossing(tuple(posts)), "straight")
    pieces = PanelPieces(where.panel)
    at_tip = TipScene(where.scene, where.tip_pair, pieces, np.arange(1, len(pieces.pieces)))
    first = shifted(station(where, 3).opened, X=-where.panel.fasteners[3].p[0], Y=-0.014 - 0.056)

    for i in range(12):
        at_tip.place(shifted(first, X=0.061 + i * 0.03))

        assert at_tip.nearest()[1] == f"post{i}"
