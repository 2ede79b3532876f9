"""Compiled kinematics and motion bounds against those of the definition."""

import numpy as np
import pytest

from planners.arrays import Array
from robots.kernel.flat import FlatCell
from robots.kernel.layout import MACHINE as MACHINE_ROW
from robots.kernel.layout import N_PAIRS, N_SOLIDS, OWN, POSE_T, SOLIDS, Ints
from robots.kernel.motion import motion_of_pairs
from robots.kernel.poses import place_links
from robots.kernel.space import KernelSpaces
from tests.robots.test_cell import MACHINE, cell
from tests.robots.test_kernel import DIES, flat


@pytest.mark.parametrize("die", DIES)
def test_the_compiled_motion_bound_is_the_motion_bound(die: str) -> None:
    rng, where = np.random.default_rng(41), cell(die)
    views = unpacked(flat(die))
    motion = np.empty(len(views[2]))
    for _ in range(200):
        a, b = rng.uniform(MACHINE.lower, MACHINE.upper, (2, 7))
        keep = rng.random(7) < 0.4
        b[keep] = a[keep]
        motion_of_pairs(*views, a, b, motion, np.empty_like(motion))
        assert motion[: len(where.open.pairs)] == pytest.approx(where.bound(a, b), rel=1e-13, abs=1e-15)


@pytest.mark.parametrize("die", DIES)
def test_the_anchors_of_a_link_are_the_tips_at_its_poses(die: str) -> None:
    where = cell(die)
    poses = list(np.random.default_rng(43).uniform(MACHINE.lower, MACHINE.upper, (20, 7)))

    spaces = KernelSpaces(flat(die), MACHINE.lower, MACHINE.upper)
    anchors = spaces.of_link(poses).anchors

    assert anchors == pytest.approx(np.array([where.tip_at(q) for q in poses]), abs=1e-12)
    assert spaces.of_link([]).anchors.shape == (0, 3)


def test_links_are_where_the_chain_of_the_definition_puts_them() -> None:
    rng, machine = np.random.default_rng(42), unpacked(flat("j20"))[0]
    chain, frames = cell("j20").scene.chain, np.empty((12, 12))
    for _ in range(100):
        q = rng.uniform(MACHINE.lower, MACHINE.upper)
        place_links(machine, q, frames, 6)
        for row, link in enumerate("XWC", 6):
            T = chain.placement(q, link)
            assert frames[row, :9] == pytest.approx(T[:3, :3].ravel(), abs=1e-12)
            assert frames[row, POSE_T : POSE_T + 3] == pytest.approx(T[:3, 3], abs=1e-12)


def unpacked(packed: FlatCell) -> tuple[Array, Array, Ints]:
    """Rows `machine`, `solids` and `pairs` of a packed cell, taken apart once more by hand."""
    numbers, indices = np.array(packed.numbers), np.array(packed.indices)
    S, K, own = indices[[N_SOLIDS, N_PAIRS, OWN]].tolist()
    first = own + MACHINE_ROW
    return (
        numbers[own:first],
        numbers[first : first + SOLIDS * S].reshape(S, SOLIDS),
        indices[-2 * K :].reshape(K, 2),
    )
