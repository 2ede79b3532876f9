"""A die made from a mesh encloses it, and is refused where its tip is not where it says."""

import numpy as np
import pytest
import shapely
import trimesh

from planners.arrays import Array
from robots.die_import.mesh_die import DieRoles, ImportedDie, die_from_mesh, machine_dies
from robots.die_import.pieces import written
from robots.errors import InvalidInput
from robots.machine_file import load_machine
from robots.meshes.model import Body


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


@pytest.mark.parametrize("body", [STRAIGHT, HOOK], ids=["straight", "hook"])
@pytest.mark.parametrize("most", [2, 4, 16])
def test_the_solids_enclose_every_triangle(body: Body, most: int) -> None:
    die = die_from_mesh(body, DieRoles("mine", most=most))
    assert _farthest_outside(die, body) <= 1e-9
    assert die.uncovered <= 1e-9
    assert len(die.entry["solids"]) <= most


def test_a_turned_die_is_axisymmetric_and_close() -> None:
    die = die_from_mesh(STRAIGHT, DieRoles("mine"))
    assert die.entry["axisymmetric"]
    assert len(die.entry["solids"]) == 2
    assert die.excess <= 0.2e-3


def test_a_hook_is_close_where_it_is_swept() -> None:
    die = die_from_mesh(HOOK, DieRoles("mine"))
    assert not die.entry["axisymmetric"]
    assert die.excess <= 0.2e-3


def test_a_machine_plans_with_the_die() -> None:
    machine = load_machine("riveter", dies=machine_dies([die_from_mesh(HOOK, DieRoles("mine"))]))
    assert machine.dies["mine"].mounting_z == machine.dies["j20"].mounting_z


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
