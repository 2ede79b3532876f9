"""The proof that solids enclose triangles agrees with points all over them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.die_import.enclosed import WITHIN, uncovered
from robots.die_import.pieces import Disc, Piece, Swept

DISC = Disc(0.0, 0.0, 0.01, -0.02, 0.0)
SQUARE = np.array([[-0.01, -0.04], [0.01, -0.04], [0.01, -0.02], [-0.01, -0.02]])
_TRIANGLE = np.array([[[0.0, 0.0, -0.001], [0.0, 0.009, -0.039], [0.008, 0.0, -0.039]]])


@pytest.mark.parametrize(
    ("solids", "free"),
    [
        ([DISC, Swept(SQUARE, -0.01, 0.01)], False),
        ([DISC], True),
        ([DISC, Swept(SQUARE - [0.0, 2e-6], -0.01, 0.01)], True),
        ([DISC, Swept(SQUARE, -0.01, 0.0089)], True),
    ],
)
def test_a_triangle_across_two_solids_needs_both_and_no_gap(solids: list[Piece], free: bool) -> None:
    assert (uncovered(_TRIANGLE, solids) > 0.0) == free


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_what_is_proven_has_no_sampled_point_outside(seed: int) -> None:
    rng = np.random.default_rng(seed)
    solids: list[Piece] = []
    for _ in range(4):
        x, y, z = rng.uniform(-0.005, 0.005, 3)
        half, size = rng.uniform(0.004, 0.012, 2)
        square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
        square += np.array([x, z])
        solids += [Swept(square, y - size, y + size), Disc(x, y, half, z - size, z + size)]
    corners = rng.uniform(-0.01, 0.01, (6, 3, 3))
    shares = rng.dirichlet([0.7, 0.7, 0.7], 400)
    for triangle in corners:
        points = shares @ triangle
        beyond = float(np.max(np.min([solid.beyond(points) for solid in solids], axis=0)))
        if uncovered(triangle[None], solids) == 0.0:
            assert beyond <= WITHIN
