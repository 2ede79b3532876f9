"""The cell: certified edges against brute force, the meant contact, and what a positive answer must never
hide.
"""

from dataclasses import replace
from functools import cache

import coal
import numpy as np
import pytest

from planners.arrays import Array
from robots.cell import Cell, LinkSpace
from robots.coal_shapes import to_coal
from robots.coal_stations import CoalStations
from robots.machine import PANEL
from robots.machine_file import load_machine
from robots.panel import Panel
from robots.stations import Refusal, Station, explained, find_station
from tests.robots.flat_crossing import flat_crossing, part

MACHINE = load_machine("riveter")
FINE = 0.00005
"""[m] Step of the brute force."""
FAR = [np.full(3, 9.0)]
"""An anchor so far away that transit clearance holds everywhere."""


@cache
def panel_with(extra: bool = False) -> Panel:
    block = part("block", "box", ((-330, 60, -200), (-130, 260, -20)))
    return flat_crossing((block,) if extra else ())


@cache
def cell(die: str, extra: bool = False) -> Cell:
    return Cell(MACHINE, MACHINE.dies[die], panel_with(extra))


def station(die: str, index: int) -> Station | Refusal:
    panel = panel_with()
    return find_station(cell(die), panel.fasteners[index], panel.stacks[index], None, np.pi / 2)


def near_crossing(rng: np.random.Generator) -> Array:
    """A configuration with the die tip in one of the bays around the crossing, level panel."""
    q = np.array(MACHINE.home)
    q[0] = MACHINE.T_world_gantry[0, 3] + rng.uniform(-0.15, 0.15)
    q[1] = rng.uniform(-0.10, 0.10)
    q[5] = -MACHINE.tip_z0 - rng.uniform(0.003, 0.16)
    q[6] = rng.uniform(-np.pi, np.pi)
    return q


def tilted(q: Array, rng: np.random.Generator) -> Array:
    """The configuration with a little panel rotation as well."""
    turned: Array = q + np.array([0.0, 0.0, 0.0, *rng.uniform(-0.02, 0.02, 2), 0.0, 0.0])
    return turned


def free_pairs(space: LinkSpace, count: int, reach: float, seed: int) -> list[tuple[Array, Array]]:
    """Edges up to `reach` [m] long with both ends free, so that what matters is what lies between.

    Every second one grazes: it starts where another motion was halted, as close to an obstacle as is allowed.
    """
    rng = np.random.default_rng(seed)
    pairs: list[tuple[Array, Array]] = []
    while len(pairs) < count:
        a = tilted(near_crossing(rng), rng) if len(pairs) % 3 == 0 else near_crossing(rng)
        if not space.is_free(a):
            continue
        if len(pairs) % 2:
            a = space.advance(a, near_crossing(rng))
        b = a + rng.uniform(-1.0, 1.0, 7) * np.array([1, 1, 0.2, 0.02, 0.02, 1, 20]) * reach
        if space.is_free(b):
            pairs.append((a, b))
    return pairs


def smallest_gap(where: Cell, a: Array, b: Array) -> float:
    """Smallest gap minus default clearance of any panel pair over the edge, sampled every 0.05 mm of tool
    travel.
    """
    of_die = [k for k, pair in enumerate(where.scene.pairs) if pair.of_die and pair.with_panel]
    steps = int(np.ceil(where.bound(a, b)[of_die].max() / FINE)) + 1
    worst = np.inf
    for s in np.linspace(0.0, 1.0, steps):
        where.scene.place(a + s * (b - a))
        if any(where.scene.within(k, max(0.0, min(worst, 0.003))) for k in of_die):
            worst = min(worst, *(where.scene.gap(k).distance for k in of_die))
    return worst - MACHINE.policy.default


def count_false_free(die: str, count: int, reach: float, seed: int) -> tuple[int, int, int]:
    """Edges accepted, accepted although brute force finds a lack of clearance, and refused although free."""
    space = LinkSpace(cell(die), FAR)
    accepted = false_free = false_blocked = 0
    for a, b in free_pairs(space, count, reach, seed):
        verdict = space.edge_is_free(a, b)
        lack = smallest_gap(cell(die), a, b) < 0.0
        accepted += verdict
        false_free += verdict and lack
        false_blocked += (not verdict) and smallest_gap(cell(die), a, b) > 0.0002
    return accepted, false_free, false_blocked


@pytest.mark.parametrize("die", ["straight", "offset35"])
def test_brute_force_finds_no_lack_of_clearance_on_accepted_edges(die: str) -> None:
    accepted, false_free, false_blocked = count_false_free(die, 300, 0.03, seed=1)

    assert accepted > 60
    assert false_free == 0
    assert false_blocked == 0


@pytest.mark.long
@pytest.mark.parametrize("die", ["straight", "j20", "offset35", "long_reach"])
@pytest.mark.parametrize("reach", [0.01, 0.06, 0.15])
def test_brute_force_finds_no_lack_of_clearance_on_a_thousand_edges(die: str, reach: float) -> None:
    accepted, false_free, _ = count_false_free(die, 1000, reach, seed=2)

    assert accepted > 30
    assert false_free == 0


@pytest.mark.parametrize("gap_mm", [1.9, 1.99, 2.01, 2.2])
def test_edges_that_graze_a_web_along_its_whole_length_are_judged_by_the_clearance(gap_mm: float) -> None:
    """The straight die slides along the stringer's web at a stated gap; 2 mm and the certificate's margin are
    needed.
    """
    space = LinkSpace(cell("straight"), FAR)
    a = np.array(MACHINE.home)
    a[0], a[1] = MACHINE.T_world_gantry[0, 3] + 0.08, (1.6 + 7.0 + gap_mm) / 1000
    a[5] = -MACHINE.tip_z0 - 0.012
    b = a + np.array([0.1, 0, 0, 0, 0, 0, 0])

    assert space.edge_is_free(a, b) is (gap_mm > 2.1)


def test_a_web_of_any_thinness_is_never_stepped_over() -> None:
    sheet = part("sheet", "box", ((100.0, -250, -180), (100.001, 250, -1.7)))
    thin = Cell(MACHINE, MACHINE.dies["straight"], flat_crossing((sheet,)))
    space = LinkSpace(thin, FAR)
    a = np.array(MACHINE.home)
    a[0], a[1], a[5] = MACHINE.T_world_gantry[0, 3] + 0.055, 0.08, -MACHINE.tip_z0 - 0.012
    rng = np.random.default_rng(0)

    assert space.is_free(a)
    for length in rng.uniform(0.07, 0.25, 50):
        b = a + np.array([length, 0, 0, 0, 0, 0, 0])
        assert not space.edge_is_free(a, b)
        halt = space.advance(a, b)
        assert halt[0] < MACHINE.T_world_gantry[0, 3] + 0.1 - 0.03 - 0.002
        assert space.edge_is_free(a, halt)


def test_the_scene_agrees_with_convex_pieces_in_the_world_frame() -> None:
    """An oracle that shares nothing with the scene: forward chain, convex-convex distances, world frame."""
    where, rng = cell("offset35"), np.random.default_rng(3)
    pieces, _ = where.panel.pieces()
    hulls = [hull_of(piece) for piece in pieces]
    request, mismatches = coal.DistanceRequest(), []
    for _ in range(40):
        q = tilted(near_crossing(rng), rng)
        where.scene.place(q)
        T = where.scene.chain.T_world_panel(q)
        panel_at = coal.Transform3s(T[:3, :3], T[:3, 3])
        for k, pair in enumerate(where.scene.pairs):
            if not pair.of_die or pair.other != PANEL:
                continue
            solid = next(s for s in where.scene.solids if s.name == pair.solid)
            T_solid = where.scene.chain.T_world_link(q, solid.link) @ solid.T_link_solid
            at = coal.Transform3s(T_solid[:3, :3], T_solid[:3, 3])
            shape = to_coal(solid.shape)
            distances = (
                coal.distance(shape, at, hull, panel_at, request, coal.DistanceResult()) for hull in hulls
            )
            apart, found = min(distances), where.scene.gap(k).distance
            if apart > 0.0 and abs(apart - found) > 1e-5:
                mismatches.append((pair.solid, apart, found))
            if apart <= -1e-5 and found > 0.0 and not _wholly_inside(apart):
                mismatches.append((pair.solid, apart, found))

    assert mismatches == []


def hull_of(piece: Array) -> coal.ConvexBase:
    points = coal.StdVec_Vec3s()
    for vertex in piece:
        points.append(vertex)
    return coal.Convex.convexHull(points, False, None)


def _wholly_inside(apart: float) -> bool:
    """A surface of triangles does not see a solid far inside; the plates here are too thin to hide one."""
    return apart < -0.02


def test_a_solid_buried_in_a_thick_part_is_not_free_although_it_touches_no_triangle() -> None:
    where = cell("straight", extra=True)
    q = np.array(MACHINE.home)
    q[0], q[1], q[5] = MACHINE.T_world_gantry[0, 3] - 0.23, -0.16, -MACHINE.tip_z0 - 0.045
    tip = where.scene.pairs[where.tip_pair]
    where.scene.place(q)

    assert tip.solid == "tip"
    assert not where.scene.within(where.tip_pair, 0.0)
    assert where.is_buried(q)
    assert not LinkSpace(where, FAR).is_free(q)


def test_the_tip_may_touch_its_stack_and_nothing_else_may_touch_anything() -> None:
    reached = station("straight", 3)
    assert isinstance(reached, Station)
    where = cell("straight")
    where.scene.place(reached.clamped)

    assert where.scene.within(where.tip_pair, 1e-6)
    assert where.process_is_free(reached.fastener, reached.opened, reached.clamped)
    assert not where.pose_is_free(reached.clamped)
    deeper = reached.clamped + np.array([0, 0, 0, 0, 0, 0.004, 0])
    assert not LinkSpace(where, [where.tip_at(reached.opened)]).is_free(deeper)


def test_contact_is_allowed_under_the_face_only_not_with_the_web_of_the_same_stringer() -> None:
    """A rivet moved towards the web: the tip would stand on the flange and touch the web, one part, two
    pieces.
    """
    near_web = flat_crossing()
    moved = np.array([near_web.fasteners[3].p[0], -0.009, 0.0])
    fastener = replace(near_web.fasteners[3], id="near_web", p=moved)
    panel = replace(near_web, fasteners=(fastener,), stacks=near_web.stacks[:1])
    where = Cell(MACHINE, MACHINE.dies["straight"], panel)

    refused = find_station(where, fastener, panel.stacks[0], None, np.pi / 2)

    assert isinstance(refused, Refusal)
    refused = explained(refused, where, fastener)
    assert refused.blockage is not None
    assert (refused.blockage.solid, refused.blockage.other) == ("tip", "S1")
    assert refused.blockage.gap == pytest.approx(0.0004, abs=1e-6)


def test_stations_under_the_frame_need_the_offset_die_and_are_refused_by_name_to_the_straight_one() -> None:
    refused = station("straight", 8)
    assert isinstance(refused, Refusal)
    refused = explained(refused, cell("straight"), panel_with().fasteners[8])
    assert refused.blockage is not None
    assert refused.blockage.other == "F1"

    reached = station("offset35", 8)
    assert isinstance(reached, Station)


def test_sag_of_the_panel_adds_to_every_panel_clearance() -> None:
    stiff, soft = flat_crossing(), flat_crossing(sag=0.001)
    needs = [Cell(MACHINE, MACHINE.dies["straight"], p).transit for p in (stiff, soft)]

    added = {p.other: b - a for p, a, b in zip(cell("straight").scene.pairs, *needs, strict=True)}

    assert added[PANEL] == pytest.approx(0.001)
    assert added["foot"] == 0.0


def test_another_move_at_the_same_fastener_is_proved_among_its_own_surroundings() -> None:
    """The tip's surroundings are kept from one die angle to the next, not from one place to another."""
    reached = station("straight", 3)
    assert isinstance(reached, Station)
    where = cell("straight")
    checks, meant = CoalStations(where), where.meant_at(reached.fastener)
    known = checks.tip_scene(reached.opened, reached.clamped, meant)

    turned = np.array([0, 0, 0, 0, 0, 0, 0.3])
    assert checks.tip_scene(reached.opened + turned, reached.clamped + turned, meant) is known
    across = np.array([0, 0.1, 0, 0, 0, 0, 0])  # away from the stringer
    assert checks.tip_scene(reached.opened + across, reached.clamped + across, meant) is not known
    assert checks.tip_scene(reached.opened, reached.clamped, meant[:1]) is not known
