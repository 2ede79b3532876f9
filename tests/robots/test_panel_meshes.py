"""Panels of meshes: the same as the parametric ones they are made from, and what is told of bad ones."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robots import hexahedra
from robots.cell import Cell
from robots.contact import panel_pieces
from robots.errors import InputProblem, InvalidInput
from robots.kernel.flat import piece_rows
from robots.kernel.under_face import pieces_under_face
from robots.machine_file import load_machine, machine_ids
from robots.meshes.model import Body, Model, Unit
from robots.nc import NcProgram
from robots.panel import Panel, Part
from robots.panel_file import load_panel
from robots.verify import examine
from service import openapi
from service.programming import program_panel
from tests.robots.meshed import Document, Files, Triangles, by_points, drilled, meshed, refined, union
from tests.robots.panels import SURFACES, small_panel

EXAMPLES = openapi.FILE.parent / "examples"
MACHINE = load_machine(machine_ids()[0])


def crossing() -> Document:
    document: Document = json.loads(Path(EXAMPLES / "crossing.json").read_bytes())
    return document


@pytest.fixture(scope="module")
def both() -> tuple[Panel, Panel]:
    """The example crossing, parametric and as meshes."""
    document, files = meshed(crossing(), lambda _, triangles: refined(triangles, 1))
    return load_panel(crossing()), load_panel(document, None, files)


def problems_of(document: Document, files: Files) -> list[InputProblem]:
    with pytest.raises(InvalidInput) as refused:
        load_panel(document, None, files)
    return list(refused.value.problems)


@pytest.mark.parametrize("surface", SURFACES)
def test_stacks_are_those_of_the_parametric_panel(surface: Document) -> None:
    plain = small_panel(surface=surface)
    plain["fasteners"][0]["p_mm"] = [0.0, 0.0, 0.0]  # on every surface
    plain["stringers"][0]["arc_mm"] = -13.2
    document, files = meshed(plain)

    panel, parametric = load_panel(document, None, files), load_panel(plain)

    assert [stack.parts for stack in panel.stacks] == [stack.parts for stack in parametric.stacks]
    grips = [[stack.grip, stack.depth] for stack in panel.stacks]
    assert grips == pytest.approx(np.array([[s.grip, s.depth] for s in parametric.stacks]), abs=1e-7)
    assert all(part.is_mesh for part in panel.parts)


def test_programs_of_a_meshed_crossing_are_those_of_the_parametric_one(both: tuple[Panel, Panel]) -> None:
    programs = [program_panel(panel, MACHINE, tuple(MACHINE.dies), seed=0).program for panel in both]

    parametric, meshes = (told(program) for program in programs)
    assert meshes == parametric
    for panel, program in zip(both, programs, strict=True):
        assert examine(program, panel, MACHINE).findings == ()


def told(program: NcProgram) -> list[tuple[str, str | None, str]]:
    return [(fastener.id, fastener.die_id, fastener.status) for fastener in program.fasteners]


def test_clearances_are_those_of_the_parametric_panel(both: tuple[Panel, Panel]) -> None:
    """At many poses, of every solid: a triangle is as near as the solid that it bounds."""
    rng = np.random.default_rng(5)
    cells = [Cell(MACHINE, MACHINE.dies["straight"], panel) for panel in both]
    anchor = cells[0].tip_at(MACHINE.home)
    for _ in range(60):
        q = np.array(MACHINE.home) + rng.normal(0.0, [0.05, 0.05, 0.05, 0.02, 0.02, 0.05, 1.0])
        q = np.clip(q, MACHINE.lower, MACHINE.upper)
        q[MACHINE.index("W")] = rng.uniform(MACHINE.axis("W").lower, MACHINE.axis("W").upper)
        free = [cell.link_space([anchor]).is_free(q) for cell in cells]
        if free[0] != free[1]:  # only within a solid part may the surface be missed
            assert cells[1].is_buried(q) or cells[0].closest(q, near_fastener=False).gap < 0.0


@pytest.fixture(scope="module")
def plate() -> tuple[Document, Files]:
    """A skin and a strap, both with holes of 4.1 mm at the fasteners, as drilled CAD parts have them."""

    places = [(-0.02, 0.0), (0.02, 0.0)]
    document: Document = {
        "schema_version": "1.0",
        "id": "plate",
        "skin": {"length_mm": 300.0, "width_mm": 200.0, "thickness_mm": 1.6},
        "straps": [{"id": "T1", "x_mm": [-100.0, 100.0], "arc_mm": [-20.0, 20.0], "thickness_mm": 2.0}],
        "fasteners": [rivet("a", -20.0), rivet("b", 20.0)],
    }
    return meshed(document, lambda _, triangles: drilled(triangles, places, 2.05e-3))


def rivet(name: str, x_mm: float) -> Document:
    size = {"diameter_mm": 4.0, "grip_mm": "from_stack", "process": "solid_rivet"}
    return {"id": name, "p_mm": [x_mm, 0.0, 0.0], "n": [0.0, 0.0, 1.0]} | size


def test_holes_that_are_there_already_hide_no_stack(plate: tuple[Document, Files]) -> None:
    panel = load_panel(plate[0], None, plate[1])

    assert [stack.parts for stack in panel.stacks] == [("skin", "T1")] * 2
    assert [stack.grip for stack in panel.stacks] == pytest.approx([3.6e-3] * 2, abs=1e-6)


@pytest.mark.parametrize(
    ("change", "code", "says"),
    [
        ({"p_mm": [-20.0, 0.0, 0.9]}, "off_skin", "0.9 mm above the outer face"),
        ({"p_mm": [-20.0, 0.0, -1.6]}, "off_skin", "1.6 mm below the outer face"),
        ({"p_mm": [-20.0, 0.0, 90.0]}, "off_skin", "more than 5 mm off"),
        ({"n": [0.0, 0.0, -1.0]}, "off_normal", "points inwards"),
        ({"n": [0.08, 0.0, 1.0]}, "off_normal", "4.57 degrees off"),
        ({"p_mm": [-20.0, 60.0, 0.0]}, "nothing_to_join", "goes through skin"),
        ({"p_mm": [-20.0, 19.0, 0.0]}, "uneven_stack", "stack changes"),
    ],
)
def test_fasteners_off_a_meshed_skin_are_told(
    plate: tuple[Document, Files], change: dict[str, Any], code: str, says: str
) -> None:
    document = plate[0] | {"fasteners": [plate[0]["fasteners"][1], plate[0]["fasteners"][0] | change]}

    (problem,) = problems_of(document, plate[1])

    assert (problem.code, problem.pointer.startswith("/fasteners/1")) == (code, True)
    assert says in problem.message


def holed(_: str, triangles: Triangles) -> Triangles:
    return triangles[0], triangles[1][1:]


def turned(_: str, triangles: Triangles) -> Triangles:
    return triangles[0], triangles[1][:, ::-1]


def beside(_: str, triangles: Triangles) -> Triangles:
    """With a copy beside it, smaller and inside out."""
    vertices, faces = triangles
    away = 0.1 * vertices + [9.0, 0.0, 0.0]
    return np.vstack([vertices, away]), np.vstack([faces, len(vertices) + faces[:, ::-1]])


@pytest.mark.parametrize(
    ("change", "code"),
    [(holed, "mesh_not_closed"), (turned, "mesh_inside_out"), (beside, "mesh_inside_out")],
)
def test_meshes_without_an_inside_are_refused(change: Any, code: str) -> None:
    document, files = meshed(small_panel(), change)

    assert {problem.code for problem in problems_of(document, files)} >= {code}


def test_unknown_files_and_bodies_are_named() -> None:
    document, files = meshed(small_panel())
    document["meshes"][1]["asset"] = "0" * 64
    document["meshes"][2]["body"] = "nobody"

    found = {(problem.pointer, problem.code) for problem in problems_of(document, files)}

    assert {("/meshes/1/asset", "unknown_asset"), ("/meshes/2/body", "unknown_body")} <= found


def test_members_do_not_lie_on_a_meshed_skin() -> None:
    document, files = meshed(small_panel())
    document["straps"] = [{"id": "T", "x_mm": [-50.0, 50.0], "arc_mm": [-9.0, 9.0], "thickness_mm": 1.0}]

    assert ("/straps/0", "needs_sized_skin") in {(p.pointer, p.code) for p in problems_of(document, files)}


def test_hash_of_a_panel_without_meshes_is_as_ever() -> None:
    assert load_panel(crossing()).sha256 == load_panel(crossing() | {"meshes": []}).sha256


def test_deviation_of_the_triangles_is_kept_free_as_well() -> None:
    document, files = meshed(small_panel())

    def rough(sha256: str, unit: Unit | None) -> Model:
        (body,) = files(sha256, unit).bodies
        return Model(sha256, "step", "m", True, (Body(body.name, body.vertices, body.triangles, (), 2e-5),))

    panel = load_panel(document | {"sag_mm": 0.1}, None, rough)

    assert (panel.sag, panel.mesh_deviation) == pytest.approx((0.12e-3, 0.02e-3))


def test_solids_within_a_closed_mesh_are_found(both: tuple[Panel, Panel]) -> None:
    """In a hall far from which all triangles are: planner and verifier see it, each in its own way."""
    panel = both[1]
    vertices, triangles = union(hexahedra.box(np.full(3, -30.0), np.full(3, 30.0))[None])
    hall = Part("hall", "other", hexahedra.flat(vertices[triangles]), is_mesh=True)
    within = replace(panel, parts=(*panel.parts, hall))
    inverted = replace(
        panel, parts=(*panel.parts, replace(hall, pieces=hall.pieces[:, [0, 2, 1, 1, 0, 2, 1, 1]]))
    )
    program = program_panel(panel, MACHINE, tuple(MACHINE.dies), seed=0).program

    for one, expected in ((panel, False), (within, True), (inverted, False)):
        assert Cell(MACHINE, MACHINE.dies["straight"], one).is_buried(np.array(MACHINE.home)) == expected
        codes = {finding.code for finding in examine(program, one, MACHINE).findings}
        assert ("hidden_in_part" in codes) == expected


def test_stack_without_an_end_is_too_thick() -> None:
    files = Files()
    block = union(hexahedra.box(np.array([-0.6, -0.6, -1.2]), np.array([0.6, 0.6, 0.0]))[None])
    skin = {"id": "skin", "kind": "skin", "asset": files.add("block", block), "unit": "m"}
    drill = rivet("a", 0.0) | {"process": "drill_only"}
    document = {"schema_version": "1.0", "id": "block", "meshes": [skin], "fasteners": [drill]}

    (problem,) = problems_of(document, files)

    assert problem.code == "stack_too_thick"


def test_triangles_under_a_face_are_those_that_sampling_finds() -> None:
    """Random triangles about a face, against the deepest of many points of each within the cylinder."""
    rng = np.random.default_rng(8)
    axis = np.array([[0.1, -0.2, 0.3], [0.6, 0.0, 0.8]])
    corners = axis[0] + rng.normal(0.0, 0.008, (300, 3, 3))
    corners[:60, 2] = corners[:60, 1] + rng.normal(0.0, 0.004, (60, 1)) * axis[1]  # upright ones
    rows, radius, deepest = piece_rows(hexahedra.flat(corners)), 0.006, 0.004
    found = np.empty(len(rows), dtype=np.int64)
    n = pieces_under_face(rows, np.arange(len(rows)), axis, radius, 0.0, deepest, found)

    weights = rng.dirichlet(np.ones(3) * 0.7, 4000)
    for k in range(len(rows)):
        points = weights @ corners[k] - axis[0]
        depth = -points @ axis[1]
        beside = np.linalg.norm(points + depth[:, None] * axis[1], axis=1)
        within = depth[beside <= radius]
        if k in found[:n]:
            assert len(within) == 0 or within.max() <= deepest + 1e-9
        elif len(within) > 200:
            assert within.max() > deepest - 4e-4


def test_contact_is_with_the_feet_and_not_the_webs(both: tuple[Panel, Panel]) -> None:
    """The meant pieces cover the same places: the face's lines meet them where they meet the solid ones."""
    parametric, meshes = both
    for fastener, stack in zip(meshes.fasteners, meshes.stacks, strict=True):
        pieces = panel_pieces(meshes)
        found = pieces.under_face(fastener, stack, 0.006, 0.001, 0.0002)
        depths = -(pieces.pieces[found, :3] - fastener.p) @ fastener.n
        reach = np.linalg.norm(np.cross(pieces.pieces[found, :3] - fastener.p, fastener.n), axis=-1)
        assert len(found) > 0
        assert depths[reach < 0.006].max(initial=0.0) <= stack.depth + 0.0002
    assert by_points(parametric)[0].keys() == by_points(meshes)[0].keys()
