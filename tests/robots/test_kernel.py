"""The compiled Space against the one it stands in for: never less careful, hardly more so anywhere.

A pose is free to the kernel only where it is free to the cell. An edge that the cell certifies, the kernel
certifies. What the kernel certifies beyond that, edges that graze a part, brute force finds to keep its
clearance.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from planners.arrays import Array
from robots.cell import CERTIFICATE_MARGIN, Cell, LinkSpace
from robots.kernel.flat import FlatCell, flat_panel, own_numbers, pack
from robots.kernel.layout import N_PAIRS
from robots.kernel.space import KernelSpace, flat_cell
from robots.kernel.work import block_sizes
from robots.panel import Panel
from tests.robots.flat_crossing import flat_crossing, part
from tests.robots.test_cell import FAR, FINE, MACHINE, cell, near_crossing, tilted

ROUNDED = 1e-7
"""[m] Lack of clearance that is rounding; far less than `CERTIFICATE_MARGIN`."""

DIES = ("straight", "j20", "offset35", "long_reach")


@cache
def flat(die: str, extra: bool = False) -> FlatCell:
    return flat_cell(cell(die, extra), CERTIFICATE_MARGIN)


def kernel(die: str, anchors: Sequence[Array] = FAR, extra: bool = False) -> KernelSpace:
    return among(flat(die, extra), anchors)


def of(where: Cell, anchors: Sequence[Array] = FAR) -> KernelSpace:
    packed = flat_cell(where, CERTIFICATE_MARGIN)
    return among(packed, anchors)


def among(packed: FlatCell, anchors: Sequence[Array]) -> KernelSpace:
    points = np.array(anchors).reshape(-1, 3)
    return KernelSpace(packed, MACHINE.lower, MACHINE.upper, points, block_sizes(packed.indices))


def pose(rng: np.random.Generator) -> Array:
    """Around the crossing, turned every other time, in all heights of the die."""
    q = near_crossing(rng)
    return tilted(q, rng) if rng.random() < 0.5 else q


def keeps_clearance(where: Cell, a: Array, b: Array) -> bool:
    """Whether every pair keeps the clearance of transit, by coal, at steps of 0.05 mm along the edge."""
    steps = int(np.ceil(where.bound(a, b).max() / FINE)) + 1
    needs = [needed - ROUNDED for needed in where.transit]
    for s in np.linspace(0.0, 1.0, steps):
        where.scene.place(a + s * (b - a))
        if any(where.scene.within(k, needed) for k, needed in enumerate(needs)):
            return False
    return True


@dataclass
class Tally:
    """Answers of both: free to both, to one only, and how many in all."""

    both: int = 0
    kernel_only: int = 0
    cell_only: int = 0
    asked: int = 0

    def count(self, by_kernel: bool, by_cell: bool) -> None:
        self.asked += 1
        self.both += by_kernel and by_cell
        self.kernel_only += by_kernel and not by_cell
        self.cell_only += by_cell and not by_kernel


def tally_poses(die: str, count: int, seed: int) -> Tally:
    """Random poses, and poses at which a certified motion was halted, shifted by micrometres."""
    rng, space, where = np.random.default_rng(seed), kernel(die), cell(die)
    needs = [needed - 1e-9 for needed in where.transit]
    tally, halted = Tally(), None
    for i in range(count):
        if i % 3 == 0 or halted is None:
            q = pose(rng)
            halted = space.advance(q, pose(rng)) if space.is_free(q) else None
        else:
            q = halted + rng.uniform(-1.0, 1.0, 7) * rng.choice([1e-7, 1e-6, 1e-5, 1e-4])
        where.scene.place(q)
        free = not any(where.scene.within(k, needed) for k, needed in enumerate(needs))
        tally.count(space.is_free(q), free and MACHINE.within_limits(q))
    return tally


@pytest.mark.parametrize("die", DIES)
def test_no_pose_is_free_to_the_kernel_that_the_scene_refuses(die: str) -> None:
    tally = tally_poses(die, 1500, seed=11)

    assert tally.both > 300
    assert tally.kernel_only == 0
    assert tally.cell_only <= 0.005 * tally.asked


@pytest.mark.long
@pytest.mark.parametrize("die", DIES)
def test_no_pose_of_ten_thousand_is_free_to_the_kernel_that_the_scene_refuses(die: str) -> None:
    tally = tally_poses(die, 10_000, seed=12)

    assert tally.both > 2000
    assert tally.kernel_only == 0
    assert tally.cell_only <= 0.005 * tally.asked


def edges(space: LinkSpace | KernelSpace, count: int, reach: float, seed: int) -> list[tuple[Array, Array]]:
    """Edges from free poses; every second one starts where another motion was halted."""
    rng = np.random.default_rng(seed)
    found: list[tuple[Array, Array]] = []
    while len(found) < count:
        a = pose(rng)
        if not space.is_free(a):
            continue
        if len(found) % 2:
            a = space.advance(a, pose(rng))
        b = a + rng.uniform(-1.0, 1.0, 7) * np.array([1, 1, 0.2, 0.02, 0.02, 1, 20]) * reach
        found.append((a, b))
    return found


def compare_edges(die: str, count: int, reach: float, seed: int) -> Tally:
    exact, compiled, tally = LinkSpace(cell(die), FAR), kernel(die), Tally()
    for a, b in edges(exact, count, reach, seed):
        accepted = compiled.edge_is_free(a, b)
        tally.count(accepted, exact.edge_is_free(a, b))
        assert not accepted or keeps_clearance(cell(die), a, b), (a, b)
    return tally


@pytest.mark.parametrize("die", ["straight", "offset35"])
def test_brute_force_finds_no_lack_of_clearance_on_edges_the_kernel_accepts(die: str) -> None:
    tally = compare_edges(die, 100, 0.03, seed=21)

    assert tally.both > 15
    assert tally.both >= 0.98 * (tally.both + tally.cell_only)


@pytest.mark.long
@pytest.mark.parametrize("die", DIES)
@pytest.mark.parametrize("reach", [0.02, 0.06, 0.15])
def test_brute_force_finds_no_lack_of_clearance_on_thousands_of_edges(die: str, reach: float) -> None:
    tally = compare_edges(die, 400, reach, seed=22)

    assert tally.both > 15
    assert tally.both >= 0.98 * (tally.both + tally.cell_only)


@pytest.mark.parametrize("die", DIES)
def test_what_the_cell_certifies_the_kernel_certifies_and_reaches(die: str) -> None:
    exact, compiled, tally = LinkSpace(cell(die), FAR), kernel(die), Tally()
    for a, b in edges(compiled, 300, 0.08, seed=23):
        by_kernel, by_cell = compiled.edge_is_free(a, b), exact.edge_is_free(a, b)
        tally.count(by_kernel, by_cell)
        if by_kernel and not by_cell:
            assert keeps_clearance(cell(die), a, b), (a, b)
            continue
        reached, reached_by_cell = compiled.advance(a, b), exact.advance(a, b)
        if cell(die).bound(reached, reached_by_cell).max() >= 4.0 * FINE:
            assert np.linalg.norm(reached - a) > np.linalg.norm(reached_by_cell - a), (a, b)
            assert keeps_clearance(cell(die), a, reached), (a, b)

    assert tally.both > 30
    assert tally.cell_only <= 0.01 * tally.both


def test_what_is_reached_is_certified_itself_and_beyond_it_there_is_an_obstacle() -> None:
    space = kernel("offset35")
    shortened = 0
    for a, b in edges(space, 150, 0.1, seed=24):
        reached = space.advance(a, b)
        whole = space.edge_is_free(a, b)
        assert whole == bool(np.array_equal(reached, b))
        if not whole and not np.array_equal(a, reached):
            shortened += 1
            assert not space.edge_is_free(reached, b)

    assert shortened > 20


@pytest.mark.parametrize("gap_mm", [1.9, 1.99, 2.01, 2.2])
def test_edges_that_graze_a_web_are_judged_by_the_clearance(gap_mm: float) -> None:
    a = np.array(MACHINE.home)
    a[0], a[1] = MACHINE.T_world_gantry[0, 3] + 0.08, (1.6 + 7.0 + gap_mm) / 1000
    a[5] = -MACHINE.tip_z0 - 0.012
    b = a + np.array([0.1, 0, 0, 0, 0, 0, 0])

    assert kernel("straight").edge_is_free(a, b) is (gap_mm > 2.1)


def test_a_web_of_any_thinness_is_never_stepped_over() -> None:
    sheet = part("sheet", "box", ((100.0, -250, -180), (100.001, 250, -1.7)))
    space = of(Cell(MACHINE, MACHINE.dies["straight"], flat_crossing((sheet,))))
    a = np.array(MACHINE.home)
    a[0], a[1], a[5] = MACHINE.T_world_gantry[0, 3] + 0.055, 0.08, -MACHINE.tip_z0 - 0.012

    assert space.is_free(a)
    for length in np.random.default_rng(0).uniform(0.07, 0.25, 200):
        b = a + np.array([length, 0, 0, 0, 0, 0, 0])
        assert not space.edge_is_free(a, b)
        halt = space.advance(a, b)
        assert halt[0] < MACHINE.T_world_gantry[0, 3] + 0.1 - 0.03 - 0.002
        assert halt[0] > MACHINE.T_world_gantry[0, 3] + 0.1 - 0.03 - 0.0025
        assert space.edge_is_free(a, halt)


def test_a_solid_buried_in_a_thick_part_is_not_free() -> None:
    q = np.array(MACHINE.home)
    q[0], q[1], q[5] = MACHINE.T_world_gantry[0, 3] - 0.23, -0.16, -MACHINE.tip_z0 - 0.045

    assert kernel("straight").is_free(q)
    assert not kernel("straight", extra=True).is_free(q)


def test_the_smaller_clearance_holds_near_the_anchors_only_and_as_in_the_cell() -> None:
    a = np.array(MACHINE.home)
    a[0], a[1] = MACHINE.T_world_gantry[0, 3] + 0.20, (1.6 + 7.0 + 1.5) / 1000
    a[5] = -MACHINE.tip_z0 - 0.012
    anchors = [np.full(3, 9.0), cell("straight").tip_at(a)]
    near, exact = kernel("straight", anchors), LinkSpace(cell("straight"), anchors)
    answers = []
    for x in (0.0, 0.01, 0.02, 0.038, 0.0399, 0.0401, 0.05):
        b = a + np.array([x, 0, 0, 0, 0, 0, 0])
        answers.append((near.is_free(b), near.edge_is_free(a, b)))
        assert answers[-1][0] == exact.is_free(b)
        assert answers[-1][1] == exact.edge_is_free(a, b)

    assert answers[0] == (True, True)
    assert answers[-1] == (False, False)
    assert not kernel("straight").is_free(a)
    reached = near.advance(a, a + np.array([0.08, 0, 0, 0, 0, 0, 0]))
    assert 0.0395 < reached[0] - a[0] <= 0.040


def test_what_is_beyond_the_limits_or_not_a_number_is_not_free() -> None:
    space, home = kernel("straight"), np.array(MACHINE.home)
    beyond = home + np.array([0, 0, 0, 0, 0, 0.5, 0])

    assert space.is_free(home)
    assert space.edge_is_free(home, home)
    assert not space.is_free(beyond)
    assert not space.edge_is_free(home, beyond)
    assert not space.is_free(np.full(7, np.nan))
    assert not space.edge_is_free(home, np.full(7, np.nan))
    assert np.array_equal(space.advance(beyond, home), beyond)
    assert MACHINE.within_limits(space.advance(home, beyond))


def test_asking_twice_in_any_order_gives_the_same_bits() -> None:
    asked = edges(kernel("j20"), 60, 0.08, seed=31)
    one, other = kernel("j20"), kernel("j20")

    forwards = [one.advance(a, b).tobytes() for a, b in asked]
    backwards = [other.advance(a, b).tobytes() for a, b in asked[::-1]]

    assert forwards == backwards[::-1]
    assert one.edges == len(asked)


def test_spaces_asked_from_several_threads_at_once_do_not_meet() -> None:
    asked = edges(kernel("offset35"), 200, 0.15, seed=32)

    def answers(space: KernelSpace) -> list[bytes]:
        return [space.advance(a, b).tobytes() for a, b in asked]

    alone = answers(kernel("offset35"))
    with ThreadPoolExecutor(2) as threads:
        together = list(threads.map(answers, [kernel("offset35") for _ in range(4)]))

    assert together == [alone] * 4


@cache
def reaching(die: str) -> Cell:
    """The machine with a die that rises 150 mm higher, into foot and head."""
    axes = tuple(replace(axis, upper=0.5) if axis.name == "W" else axis for axis in MACHINE.axes)
    high = replace(MACHINE, axes=axes)
    return Cell(high, high.dies[die], with_no_parts())


def with_no_parts() -> Panel:
    """The panel a long way off: what is left are the machine's own solids."""
    away = np.eye(4)
    away[:3, 3] = 0.0, 0.0, -30.0
    return replace(flat_crossing(), mounting=away)


@pytest.mark.parametrize("die", DIES)
def test_the_machine_does_not_run_into_itself(die: str) -> None:
    where, rng, tally = reaching(die), np.random.default_rng(61), Tally()
    machine = where.machine
    packed = flat_cell(where, CERTIFICATE_MARGIN)
    compiled, exact = among(packed, FAR), LinkSpace(where, FAR)
    for _ in range(400):
        a, b = np.array([machine.home, machine.home])
        for q in (a, b):
            q[5], q[6] = rng.uniform(0.30, 0.42), rng.uniform(-3.0, 3.0)
        assert compiled.is_free(a) == exact.is_free(a)
        tally.count(compiled.edge_is_free(a, b), exact.edge_is_free(a, b))

    assert 50 < tally.both < 350
    assert tally.kernel_only == tally.cell_only == 0


@pytest.mark.parametrize("die", DIES)
def test_solids_said_to_be_always_apart_never_come_nearer(die: str) -> None:
    rng = np.random.default_rng(62)
    for where in (cell(die), reaching(die)):
        always = apart_always(where)
        assert np.any(always > 0.0)
        for _ in range(40):
            q = rng.uniform(where.machine.lower, where.machine.upper)
            q[5] = rng.choice([where.machine.lower[5], where.machine.upper[5], q[5]])
            where.scene.place(q)
            for k, pair in enumerate(where.scene.pairs):
                assert always[k] < 0.0 or not (pair.with_panel or where.scene.within(k, always[k]))


def apart_always(where: Cell) -> Array:
    """Row `always` of the packed cell."""
    packed = flat_cell(where, CERTIFICATE_MARGIN)
    always: Array = own_numbers(packed)[-int(packed.indices[N_PAIRS]) :]
    return always


def test_guaranteed_clearance_is_that_of_the_cell() -> None:
    exact, compiled = LinkSpace(cell("offset35"), FAR), kernel("offset35")
    found = []
    for a, b in edges(compiled, 40, 0.04, seed=51):
        if compiled.edge_is_free(a, b):
            path = np.array([a, (a + b) / 2.0, b])
            found.append(compiled.guaranteed_clearance(path))
            assert found[-1] == pytest.approx(exact.guaranteed_clearance(path), abs=0.00011)

    assert len(found) > 5
    assert min(found) >= 0.0


def test_a_panel_is_made_flat_once_for_all_its_dies() -> None:
    panel = cell("straight").panel

    assert flat_panel(panel) is flat_panel(panel)


def test_a_machine_of_another_layout_is_refused() -> None:
    where, other = cell("straight"), replace(MACHINE, kinematics="chain")

    with pytest.raises(ValueError, match="riveter's layout"):
        pack(
            other,
            where.panel,
            where.open.solids,
            where.open.pairs,
            np.column_stack([where.transit, where.near]),
            open_pairs=len(where.open.pairs),
            tip_pair=where.tip_pair,
            near_radius=0.04,
        )
