import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots import hexahedra
from robots.hexahedra import HEX_EDGES, HEX_FACES, HEX_TRIANGLES
from tests.robots.panels import assert_sound

sizes = st.floats(1e-3, 10.0)


@given(sizes, sizes, sizes)
def test_box_has_its_volume_and_bounds(a: float, b: float, c: float) -> None:
    lower = np.array([-1.0, 2.0, 3.0])

    boxes = hexahedra.box(lower, lower + np.array([a, b, c]))[None]

    assert_sound(boxes)
    assert hexahedra.volumes(boxes)[0] == pytest.approx(a * b * c, rel=1e-9)
    low, high = hexahedra.bounds(boxes)
    assert np.allclose(low, lower)
    assert np.allclose(high, lower + np.array([a, b, c]))


def test_constants_describe_one_closed_surface() -> None:
    edges = [tuple(sorted((t[k], t[(k + 1) % 3]))) for t in HEX_TRIANGLES.tolist() for k in range(3)]
    directed = [(t[k], t[(k + 1) % 3]) for t in HEX_TRIANGLES.tolist() for k in range(3)]
    sides = {tuple(sorted((f[k], f[(k + 1) % 4]))) for f in HEX_FACES.tolist() for k in range(4)}

    assert len(set(directed)) == 36  # every edge once in each direction
    assert all(edges.count(edge) == 2 for edge in edges)
    assert sides == {tuple(sorted(edge)) for edge in HEX_EDGES.tolist()}
    assert not any(a.flags.writeable for a in (HEX_FACES, HEX_TRIANGLES, HEX_EDGES))


def test_frustum_volume_is_that_of_the_closed_form() -> None:
    frustum = hexahedra.box(np.array([-2.0, -2.0, 0.0]), np.array([2.0, 2.0, 3.0]))
    frustum[4:, :2] *= 0.5

    assert_sound(frustum[None])
    assert hexahedra.volumes(frustum[None])[0] == pytest.approx(3.0 / 3.0 * (16.0 + 4.0 + 8.0))


def test_mirrored_solid_is_turned_outwards_again() -> None:
    mirrored = hexahedra.box(np.zeros(3), np.ones(3)) * [-1.0, 1.0, 1.0]

    turned = hexahedra.outward(mirrored[None])

    assert hexahedra.volumes(mirrored[None])[0] < 0.0
    assert_sound(turned)
    assert {tuple(p) for p in turned[0]} == {tuple(p) for p in mirrored}


def test_planes_hold_exactly_the_points_of_the_solid() -> None:
    rng = np.random.default_rng(1)
    solid = hexahedra.box(np.array([-2.0, -2.0, 0.0]), np.array([2.0, 2.0, 3.0]))
    solid[4:, :2] *= 0.5
    points = rng.uniform(-3.0, 3.5, (5000, 3))
    z = points[:, 2]
    truly = (z >= 0) & (z <= 3) & (np.abs(points[:, :2]).max(axis=1) <= 2.0 - z / 3.0)

    normals, offsets = hexahedra.planes(solid[None])

    assert np.array_equal((points @ normals[0].T <= offsets[0]).all(axis=1), truly)
