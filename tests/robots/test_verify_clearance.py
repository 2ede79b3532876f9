"""What a program's blocks state, against brute force; and what happens to what could not be examined."""

from dataclasses import replace

import numpy as np
import pytest

from planners.arrays import Array
from robots.nc import NcAxes, NcBlock
from robots.panel import Panel
from robots.verify import certified, verify
from robots.verify_clearance import cover
from robots.verify_motions import configurations
from tests.robots.fault_cases import CLEAN, PANEL
from tests.robots.nc_samples import with_block
from tests.robots.proofs import (
    MACHINE,
    random_motions,
    random_panel,
    sampled_clearance,
    turns_beside,
    web_aside,
)


def below_samples(panel: Panel, ends: Array, dies: list[str]) -> int:
    """Check what is stated for a program that moves to `ends` (n, 7); in how many blocks it is below."""
    blocks = [
        NcBlock(k, "move", NcAxes.of(end), 0.0, 0.0, die)
        for k, (end, die) in enumerate(zip(ends, dies, strict=True))
    ]
    q = configurations(blocks)

    covered = cover(blocks, q, np.arange(len(q)), panel, MACHINE)

    below = 0
    for k in range(1, len(q)):
        stated = covered.clearances[k]
        if stated is None:
            continue
        way = q[k - 1] + np.linspace(0.0, 1.0, 121)[:, None] * (q[k] - q[k - 1])
        solids = MACHINE.assembly(MACHINE.dies[dies[k]], "open")
        sampled = min(sampled_clearance(panel, solid, way)[0] for solid in solids)
        assert stated.proven <= sampled + 1e-6
        below += stated.proven < sampled - 1e-5
    refused = {k for k in range(len(q)) if covered.clearances[k] is None}
    assert {one.row for one in covered.violations} == refused
    return below


def test_what_a_block_states_is_below_the_samples_of_every_solid() -> None:
    """Random moves of the whole machine, with its dies, about a few pieces."""
    start, delta = random_motions(42, 30)
    ends = np.clip(np.cumsum(0.2 * delta, axis=0) + start[0], MACHINE.lower, MACHINE.upper)

    below_samples(random_panel(41, pieces=6), ends, [MACHINE.dies.ids[k % 3] for k in range(30)])


def test_what_a_block_states_is_proven_where_the_nearest_place_is_not_measured() -> None:
    rng = np.random.default_rng(43)
    turn = np.where(np.arange(40) % 2, 1.0, -1.0) * rng.uniform(0.02, 0.08, 40)

    assert (
        below_samples(web_aside(), turns_beside(rng.uniform(0.003, 0.012, 40), turn), ["straight"] * 40) >= 3
    )


def test_a_block_that_could_not_be_examined_to_the_end_is_not_certified(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("robots.proof.examine._WAITING", 2)

    certificate = verify(CLEAN, PANEL, MACHINE)

    assert {f.code for f in certificate.findings} >= {"not_examined"}
    assert certificate.certified_blocks < len(CLEAN.blocks)


def test_a_panel_with_a_number_that_is_none_certifies_nothing() -> None:
    vertices = np.array(PANEL.parts[1].pieces)
    vertices[0, 0, 0] = np.nan
    broken = replace(PANEL, parts=(PANEL.parts[0], replace(PANEL.parts[1], pieces=vertices)))

    certificate = verify(CLEAN, broken, MACHINE)

    assert "not_examined" in {f.code for f in certificate.findings}
    assert certificate.certified_blocks == 0


def test_the_block_after_one_beyond_travel_is_not_certified_either() -> None:
    program = certified(
        with_block(CLEAN, 70, axes=replace(CLEAN.blocks[6].axes, X_mm=99_000.0)), PANEL, MACHINE
    )

    assert {b.n for b in program.blocks if b.clearance is None} == {70, 80}


def test_configurations_of_all_blocks_are_those_of_each_to_the_last_bit() -> None:
    rng = np.random.default_rng(1)
    blocks = [
        replace(CLEAN.blocks[0], axes=NcAxes.of(q))
        for q in rng.uniform(MACHINE.lower, MACHINE.upper, (200, 7))
    ]

    assert np.array_equal(configurations(blocks), [block.axes.q for block in blocks])
