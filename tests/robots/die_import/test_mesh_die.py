"""A die made from a mesh encloses it, and is refused where its tip is not where it says."""

import numpy as np
import pytest
import shapely
import trimesh

from planners.arrays import Array
from robots.die_import.libraries import library_with, with_dies
from robots.die_import.mesh_die import DieRoles, ImportedDie, die_from_mesh
from robots.die_import.pieces import written
from robots.dies import Die
from robots.errors import InvalidInput
from robots.meshes.model import Body
from robots.solids import Cylinder, Solid
from robots.tooling_file import load_dies


def _cylinder(radius: float, low: float, high: float, x: float = 0.0) -> trimesh.Trimesh:
    solid: trimesh.Trimesh = trimesh.creation.cylinder(radius, high - low, sections=96)
    solid.apply_translation([x, 0.0, (low + high) / 2.0])
    return solid


def _swept(profile: list[tuple[float, float]], width: float) -> trimesh.Trimesh:
    solid: trimesh.Trimesh = trimesh.creation.extrude_polygon(
        shapely.Polygon(np.array(profile) / 1000.0), width
    )
    x, y, z = solid.vertices.T
    solid.vertices = np.column_stack([x, z - width / 2.0, y])
    solid.fix_normals()
    return solid


def _body(*solids: trimesh.Trimesh) -> Body:
    united = trimesh.boolean.union(solids, engine="manifold")
    return Body("die", np.array(united.vertices), np.array(united.faces, dtype=np.int64))


def _mesh(solid: Solid) -> trimesh.Trimesh:
    if not isinstance(solid.shape, Cylinder):
        hull: trimesh.Trimesh = trimesh.convex.convex_hull(solid.vertices)
        return hull
    round_one: trimesh.Trimesh = trimesh.creation.cylinder(
        solid.shape.radius, solid.shape.length, sections=96
    )
    round_one.apply_transform(solid.T_link_solid)
    return round_one


STRAIGHT = _body(_cylinder(0.007, -0.05, 0.0), _cylinder(0.03, -0.25, -0.045))
HOOK = _body(
    _cylinder(0.007, -0.0045, 0.0),
    _swept([(-7, -4), (31, -4), (31, -22), (9, -22), (-7, -12)], 0.014),
    _swept([(9, -61), (31, -61), (31, -4), (9, -4)], 0.022),
    _cylinder(0.03, -0.25, -0.06, 0.02),
)


def _farthest_outside(die: ImportedDie, body: Body) -> float:
    """Of points all over the triangles, [m]."""
    rng = np.random.default_rng(5)
    shares: Array = rng.dirichlet([0.5, 0.5, 0.5], (len(body.triangles), 40))
    points = np.einsum("tkc,tcd->tkd", shares, body.corners()).reshape(-1, 3)
    solids = [written(each["shape"]) for each in die.entry["solids"]]
    return float(np.max(np.min([solid.beyond(points) for solid in solids], axis=0)))


@pytest.mark.parametrize("die", list(load_dies()), ids=lambda die: die.id)
@pytest.mark.parametrize("most", [4, pytest.param(24, marks=pytest.mark.long)])
def test_each_die_of_the_library_comes_back_from_its_mesh(die: Die, most: int) -> None:
    body = _body(*(_mesh(solid) for solid in die.solids))
    found = die_from_mesh(body, DieRoles("mine", most=most))
    assert _farthest_outside(found, body) <= 1e-8
    assert found.excess <= 0.2e-3
    assert found.entry["axisymmetric"] == die.axisymmetric
    assert len(found.entry["solids"]) == len(die.solids)
    assert found.mounting_face_mm == 1000.0 * die.mounting_z


@pytest.mark.long
@pytest.mark.parametrize("angle", [0.3, 1.1])
def test_a_hook_at_an_angle_is_enclosed_or_refused_with_what_was_reached(angle: float) -> None:
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    body = Body("die", HOOK.vertices @ turn.T, HOOK.triangles)
    with pytest.raises(InvalidInput, match="stand out of the body by") as refused:
        die_from_mesh(body, DieRoles("mine", most=8))
    reached = float(str(refused.value.problems[0].value))
    found = die_from_mesh(body, DieRoles("mine", excess=reached * 1e-3 + 1e-6, most=8))
    assert _farthest_outside(found, body) <= 1e-8


def test_a_mesh_that_stands_for_a_surface_beside_it_gets_larger_solids() -> None:
    body = Body("die", HOOK.vertices, HOOK.triangles, deviation=0.1e-3)
    found = die_from_mesh(body, DieRoles("mine", excess=0.4e-3))
    rng = np.random.default_rng(2)
    corners = body.corners()
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-30)[:, None]
    shares = rng.dirichlet([1.0, 1.0, 1.0], (len(corners), 20))
    points = np.einsum("tkc,tcd->tkd", shares, corners) + 0.1e-3 * normals[:, None]
    points = points.reshape(-1, 3)
    points = points[(points[:, 2] <= 0.0) & (points[:, 2] >= -0.25)]
    solids = [written(each["shape"]) for each in found.entry["solids"]]
    assert float(np.max(np.min([solid.beyond(points) for solid in solids], axis=0))) <= 1e-8


def test_a_turned_die_is_axisymmetric_and_close() -> None:
    die = die_from_mesh(STRAIGHT, DieRoles("mine"))
    assert die.entry["axisymmetric"]
    assert len(die.entry["solids"]) == 2
    assert die.excess <= 0.2e-3


def test_a_hook_is_close_where_it_is_swept() -> None:
    die = die_from_mesh(HOOK, DieRoles("mine"))
    assert not die.entry["axisymmetric"]
    assert die.excess <= 0.2e-3


def test_a_machine_has_the_die_beside_its_own_or_alone() -> None:
    entry = die_from_mesh(HOOK, DieRoles("mine")).entry
    beside, alone = with_dies("riveter", [entry]), with_dies("riveter", [entry], alone=True)
    assert beside.dies["mine"].mounting_z == beside.dies["j20"].mounting_z
    assert alone.dies.ids == ("mine",)
    assert len({load_dies().sha256, beside.dies.sha256, alone.dies.sha256}) == 3


def test_a_die_ends_at_the_mounting_face_or_is_refused() -> None:
    rounded = Body("die", HOOK.vertices * [1.0, 1.0, 0.2499999 / 0.25], HOOK.triangles)
    entry = die_from_mesh(rounded, DieRoles("mine")).entry
    assert library_with([entry])["mine"].mounting_z == -0.25
    short = Body("die", HOOK.vertices * [1.0, 1.0, 0.99], HOOK.triangles)
    with pytest.raises(InvalidInput, match="mounting face"):
        library_with([die_from_mesh(short, DieRoles("mine")).entry])


@pytest.mark.parametrize("factor", [0.001, 0.0254, 25.4, 1000.0])
def test_a_die_in_another_unit_is_refused(factor: float) -> None:
    with pytest.raises(InvalidInput, match="unit"):
        die_from_mesh(Body("die", STRAIGHT.vertices * factor, STRAIGHT.triangles), DieRoles("mine"))


def test_a_shape_that_needs_more_solids_than_there_may_be_is_refused() -> None:
    with pytest.raises(InvalidInput, match="2 solids stand out of the body by"):
        die_from_mesh(HOOK, DieRoles("mine", most=2))


def test_tip_and_up_put_the_die_in_its_frame() -> None:
    turned = STRAIGHT.vertices[:, [2, 0, 1]] + [0.1, 0.2, 0.3]
    moved = Body("die", turned, STRAIGHT.triangles)
    with pytest.raises(InvalidInput, match="--tip"):
        die_from_mesh(moved, DieRoles("mine"))
    die = die_from_mesh(moved, DieRoles("mine", tip=(0.1, 0.2, 0.3), up="x"))
    assert die.entry["solids"] == die_from_mesh(STRAIGHT, DieRoles("mine")).entry["solids"]


def test_a_tip_beside_the_axis_and_an_open_body_are_refused() -> None:
    beside = Body("die", STRAIGHT.vertices + np.array([0.0002, 0.0, 0.0]), STRAIGHT.triangles)
    with pytest.raises(InvalidInput, match="not about the tool axis"):
        die_from_mesh(beside, DieRoles("mine"))
    opened = Body("die", STRAIGHT.vertices, STRAIGHT.triangles[1:].copy())
    with pytest.raises(InvalidInput, match="closed"):
        die_from_mesh(opened, DieRoles("mine"))


def test_shells_that_were_not_united_are_enclosed() -> None:
    tip, shank = _cylinder(0.007, -0.05, 0.0), _cylinder(0.03, -0.25, -0.045)
    triangles = np.vstack([tip.faces, shank.faces + len(tip.vertices)]).astype(np.int64)
    body = Body("die", np.vstack([tip.vertices, shank.vertices]), triangles)
    assert _farthest_outside(die_from_mesh(body, DieRoles("mine")), body) <= 1e-6
