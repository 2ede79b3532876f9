"""The outer face of skins of triangles: flat, curved, drilled, countersunk, turned."""

import manifold3d  # type: ignore[import-not-found]
import numpy as np
import pytest

from planners.arrays import Array
from robots.errors import InvalidInput
from robots.fastener_lists.mesh_skin import MeshSkin
from robots.fastener_lists.skin import SurfaceSkin
from robots.meshes.model import Body
from robots.surface import Surface
from tests.robots.fastener_lists.samples import (
    THICKNESS,
    arched,
    body,
    countersunk,
    curved_points,
    drilled,
    found,
    lines,
    plate,
    read,
)

R = 1.975


def on_arc(half_deg: float, count: int = 400) -> tuple[Array, Array]:
    """Points on the arc about the crown and their normals; from a fixed seed."""
    rng = np.random.default_rng(3)
    turns, x = np.radians(rng.uniform(-half_deg, half_deg, count)), rng.uniform(-0.24, 0.24, count)
    normals = np.stack([np.zeros(count), np.sin(turns), np.cos(turns)], axis=1)
    return np.stack([x, R * np.sin(turns), R * np.cos(turns) - R], axis=1), normals


def angles(a: Array, b: Array) -> Array:
    return np.asarray(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))))


@pytest.mark.parametrize("half_deg", [36.0, 80.0])
@pytest.mark.parametrize("facets", [40, 400])
def test_curved_skin_is_known_within_its_facets(half_deg: float, facets: int) -> None:
    skin = MeshSkin([body(arched(half_deg, facets))])
    points, normals = on_arc(half_deg - 0.1)

    on = skin.outer_point(points)

    step = np.radians(2.0 * half_deg / facets)
    sagitta = R * (1.0 - np.cos(0.5 * step))
    assert on.distances.max() <= 1.01 * sagitta + 1e-7
    assert np.degrees(skin.normal_error) == pytest.approx(np.degrees(0.5 * step), rel=1e-3)
    assert angles(on.normals, normals).max() <= np.degrees(skin.normal_error) * 1.001 + 1e-6
    assert skin.inner_distances(on.points) == pytest.approx(THICKNESS, abs=2.0 * sagitta + 1e-7)


def test_normals_between_corners_are_better_than_those_of_facets() -> None:
    skin = MeshSkin([body(arched(36.0, 36))])
    points, normals = on_arc(30.0)

    assert angles(skin.outer_point(points).normals, normals).max() < 0.05 * np.degrees(skin.normal_error)


def test_holes_and_countersinks_are_no_part_of_the_face() -> None:
    turns = np.array([-0.6, -0.2, 0.0, 0.3, 0.6])
    normals = np.stack([np.zeros(5), np.sin(turns), np.cos(turns)], axis=1)
    points = np.stack([np.linspace(-0.1, 0.1, 5), R * np.sin(turns), R * np.cos(turns) - R], axis=1)
    shape = drilled(arched(40.0, 200), points, normals, 0.00205)
    for p, n in zip(points[::2], normals[::2], strict=True):
        shape = countersunk(shape, p, n, 0.00205, 0.001)
    skin = MeshSkin([body(shape)])

    on = skin.outer_point(points)

    assert on.distances.max() < 5e-5
    assert angles(on.normals, normals).max() < 0.3
    assert skin.inner_distances(points) == pytest.approx(THICKNESS, abs=1e-4)
    assert np.degrees(skin.normal_error) < 0.21


def test_windows_are_not_filled() -> None:
    window = plate(0.1, 0.06, (-0.01, 0.01))
    skin = MeshSkin([body(plate(0.5, 0.4, (-THICKNESS, 0.0)) - window)])

    assert skin.outer_point(np.zeros((1, 3))).distances[0] == pytest.approx(0.03)


def test_fasteners_over_their_holes_are_on_the_skin() -> None:
    skin = MeshSkin(
        [
            body(
                drilled(
                    plate(0.5, 0.4, (-THICKNESS, 0.0)), [np.zeros(3)], [np.array([0.0, 0.0, 1.0])], 0.00205
                )
            )
        ]
    )
    header = "id,x_mm,y_mm,z_mm,diameter_mm,process"

    assert read(lines("A,0,0,0,4,slug", header=header), skin).entries[0]["n"] == [0.0, 0.0, 1.0]
    assert found(lines("A,0,0,-1.6,4,slug", header=header), skin) == [("/rows/2", "wrong_side")]


def test_steps_on_the_inner_side_are_told_by_distance() -> None:
    stepped = plate(0.5, 0.4, (-0.002, 0.0)) - plate(0.2, 0.4, (-0.003, -0.001)).translate([0.2, 0.0, 0.0])
    skin = MeshSkin([body(stepped)])

    assert skin.inner_distances(np.array([[-0.1, 0.0, 0.0], [0.2, 0.0, 0.0]])) == pytest.approx(
        [0.002, 0.001]
    )


def test_outward_side_may_be_another() -> None:
    skin = MeshSkin([body(plate(0.5, 0.4, (-THICKNESS, 0.0)))], outward=(0.0, 0.0, -1.0))

    on = skin.outer_point(np.array([[0.0, 0.0, 0.0]]))

    assert on.normals.tolist() == [[0.0, 0.0, -1.0]]
    assert on.distances[0] == pytest.approx(THICKNESS)


def test_rounded_edges_do_not_join_the_sides() -> None:
    ball = manifold3d.Manifold.sphere(0.0008, 48)
    corners = [ball.translate([x, y, -0.0008]) for x in (-0.2, 0.2) for y in (-0.1, 0.1)]
    skin = MeshSkin([body(manifold3d.Manifold.batch_hull(corners))])
    middle = np.array([[0.0, 0.0, 0.0]])

    assert skin.outer_point(middle).distances[0] == pytest.approx(0.0, abs=1e-9)
    assert skin.inner_distances(middle)[0] == pytest.approx(THICKNESS, abs=1e-9)


def test_skin_of_several_bodies_is_one() -> None:
    bar = plate(0.2, 0.2, (-THICKNESS, 0.0))
    skin = MeshSkin([body(bar.translate([-0.1, 0.0, 0.0])), body(bar.translate([0.11, 0.0, 0.0]), "other")])

    assert skin.outer_point(np.array([[-0.1, 0.0, 0.0], [0.1, 0.0, 0.0]])).distances.max() < 1e-12


def test_corners_that_are_written_for_each_triangle_are_joined() -> None:
    whole = body(arched(36.0, 50))
    soup = Body("soup", whole.corners().reshape(-1, 3), np.arange(3 * len(whole.triangles)).reshape(-1, 3))
    points, _ = on_arc(30.0, 20)

    np.testing.assert_allclose(
        MeshSkin([soup]).outer_point(points).normals, MeshSkin([whole]).outer_point(points).normals, atol=1e-9
    )


def refused(*bodies: Body, outward: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> list[str]:
    with pytest.raises(InvalidInput) as caught:
        MeshSkin(bodies, outward)
    return [each.code for each in caught.value.problems]


def test_bodies_that_close_nothing_are_refused() -> None:
    sound = body(plate(0.5, 0.4, (-THICKNESS, 0.0)))
    open_ = Body("open", sound.vertices, sound.triangles[1:].copy())
    turned = Body("turned", sound.vertices, sound.triangles[:, ::-1].copy())

    mixed = sound.triangles.copy()
    mixed[0] = mixed[0, ::-1]
    assert refused(Body("mixed", sound.vertices, mixed)) == ["mesh_not_closed"]
    assert refused(open_, turned, sound) == ["mesh_not_closed", "mesh_inside_out"]


def test_skin_without_an_outer_side_is_refused() -> None:
    assert refused(body(plate(0.5, 0.4, (-THICKNESS, 0.0))), outward=(0.0, 1.0, 0.0)) == ["no_outer_face"]


def test_normals_are_not_taken_from_a_coarse_skin() -> None:
    skin = MeshSkin([body(arched(36.0, 12))])
    header = "id,x_mm,y_mm,z_mm,diameter_mm,process"

    assert found(lines("A,0,0,0,4,slug", header=header), skin) == [("", "coarse_skin")]
    assert len(read(lines("A,0,0,0,0,0,1,4,slug"), skin).entries) == 1


def test_same_list_is_the_same_on_triangles_and_on_the_surface() -> None:
    points, _ = curved_points(20, 0.25)
    points[:, 0] *= 0.5
    rows = [f"F{i},{p[0]!r},{p[1]!r},{p[2]!r},4,slug" for i, p in enumerate(points.tolist())]
    text = lines(*rows, header="id,x_mm,y_mm,z_mm,diameter_mm,process")
    exact = SurfaceSkin(Surface(R), 0.5, 2.0 * np.radians(20.0) * R, THICKNESS)

    mesh, true = (read(text, skin).entries for skin in (MeshSkin([body(arched(20.0, 150))]), exact))

    assert [e["p_mm"] for e in mesh] == [e["p_mm"] for e in true]
    np.testing.assert_allclose([e["n"] for e in mesh], [e["n"] for e in true], atol=1e-4)
