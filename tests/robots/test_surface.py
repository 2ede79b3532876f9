import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.surface import Surface

radii = st.one_of(st.none(), st.floats(0.5, 50.0))
surfaces = st.builds(Surface, radii, radii)
arcs = st.floats(-0.25, 0.25)
depths = st.floats(-0.05, 0.1)


@given(surfaces, arcs, arcs, depths)
def test_locate_is_the_inverse_of_at(surface: Surface, u: float, v: float, depth: float) -> None:
    assert np.allclose(surface.locate(surface.at(u, v, depth)), (u, v, depth), atol=1e-12)


@given(surfaces, arcs, arcs, depths)
def test_depth_is_measured_along_the_inward_normal(
    surface: Surface, u: float, v: float, depth: float
) -> None:
    assert np.allclose(
        surface.at(u, v, depth), surface.point(u, v) - depth * surface.normal(u, v), atol=1e-12
    )


@given(surfaces, arcs, arcs)
def test_tangents_are_the_derivatives_and_the_normal_is_outward(surface: Surface, u: float, v: float) -> None:
    step = 1e-6
    along, across = surface.tangents(u, v)
    du = surface.point(u + step, v) - surface.point(u - step, v)
    dv = surface.point(u, v + step) - surface.point(u, v - step)

    assert np.allclose(du / np.linalg.norm(du), along, atol=1e-8)
    assert np.allclose(dv / (2.0 * step), across, atol=1e-8)  # v is true arc length
    assert np.allclose(np.linalg.norm(du) / (2.0 * step), surface.arc_scale(v), atol=1e-8)
    assert np.allclose(np.cross(along, across), surface.normal(u, v), atol=1e-12)


@given(surfaces)
def test_crown_is_the_origin_and_the_highest_point(surface: Surface) -> None:
    u, v = np.meshgrid(np.linspace(-0.25, 0.25, 11), np.linspace(-0.25, 0.25, 11))

    points = surface.point(u, v)

    assert np.allclose(surface.point(0.0, 0.0), 0.0)
    assert np.allclose(surface.normal(0.0, 0.0), [0.0, 0.0, 1.0])
    assert points[..., 2].max() <= 1e-15


@given(surfaces, arcs, arcs, st.floats(0.001, 0.05), st.floats(0.001, 0.05), depths)
def test_patch_between_parameter_lines_is_planar(
    surface: Surface, u: float, v: float, du: float, dv: float, depth: float
) -> None:
    a, b, c, d = surface.at(np.array([u, u + du, u + du, u]), np.array([v, v, v + dv, v + dv]), depth)
    normal = np.cross(c - a, d - b)

    assert abs(normal @ (b - a)) / np.linalg.norm(normal) < 1e-12


def test_radii_are_those_asked_for() -> None:
    surface = Surface(section_radius=1.657, length_radius=8.1)
    section = surface.point(0.0, np.linspace(-0.5, 0.5, 7))
    length = surface.point(np.linspace(-0.5, 0.5, 7), 0.0)

    assert np.allclose(np.linalg.norm(section - [0.0, 0.0, -1.657], axis=1), 1.657)
    assert np.allclose(np.linalg.norm(length - [0.0, 0.0, -8.1], axis=1), 8.1)


def test_flat_surface_is_the_plane_itself() -> None:
    assert np.array_equal(Surface().at(0.3, -0.2, 0.01), [0.3, -0.2, -0.01])
    assert Surface().arc_scale(0.7) == 1.0


def test_arc_scale_is_the_ratio_of_the_parallels() -> None:
    surface = Surface(1.657, 8.1)

    assert surface.arc_scale(0.6) == pytest.approx((8.1 - 1.657 * (1.0 - np.cos(0.6 / 1.657))) / 8.1)
