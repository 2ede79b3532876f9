"""The example bay: its CAD, its list and its die are those of the parametric panel."""

import csv
import importlib.util
import json
import re
import runpy
import subprocess
import sys
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import trimesh
from trimesh.triangles import closest_point

from planners.arrays import Array
from robots import bodies, hexahedra, sweeps
from robots.meshes.model import Model, Unit
from robots.meshes.quarantine import read_limited
from robots.panel import Panel
from robots.panel_file import load_panel
from robots.solids import Cylinder, Solid
from robots.tooling_file import load_dies

EXAMPLES = Path(__file__).parents[2] / "openapi" / "examples"
BAY = EXAMPLES / "bay"
READS_STEP = importlib.util.find_spec("cascadio") is not None
needs_step = pytest.mark.skipif(not READS_STEP, reason="needs the extra `step`")
FORMS = (pytest.param("step", marks=needs_step), "glb", "stl")
SHAPES = ("skin", "stringer", "frame", "clip")
PARTS = ("skin", "S1", "S2", "S3", "F1", "F2", "K1", "K2", "K3", "K4")
CAD = ("panel.step", "panel_holes.step", "panel.glb", *(f"stl/{shape}.stl" for shape in SHAPES))
TESSELLATION = 0.02e-3
"""[m] What make_cad.py tessellates within, and whoever reads STEP at least."""
ROUNDING = 1e-6
"""[m] More than single precision takes from a panel of this size."""


@cache
def model(file: str, unit: Unit | None = None) -> Model:
    return read_limited(BAY / file, file, unit)


@cache
def parametric() -> Panel:
    return load_panel(BAY / "panel.json")


@cache
def document(form: str) -> dict[str, list[dict[str, object]]]:
    text: dict[str, list[dict[str, object]]] = json.loads((BAY / f"panel_{form}.json").read_text())
    return text


@cache
def shapes(form: str) -> dict[str, Array]:
    """The triangles (T, 3, 3) of each part in the panel frame, as the panel of that form says."""
    found = {}
    for entry in document(form)["meshes"]:
        found_in = model(str(entry["file"]), entry.get("unit"))
        (body,) = (b for b in found_in.bodies if entry.get("body") in (None, b.name))
        position, angles = (np.array(entry.get(key, np.zeros(3))) for key in ("position_mm", "rotation_deg"))
        T = bodies.pose(position / 1000.0, np.radians(angles))
        found[str(entry["id"])] = body.corners() @ T[:3, :3].T + T[:3, 3]
    return found


def samples(triangles: Array) -> Array:
    """Points (n, 3) on triangles: their corners, and ten inside each."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(4), np.arange(4), indexing="ij"))
    weights = (np.stack([i, j, 3 - i - j], axis=1)[i + j < 4] + 1.0 / 3.0) / 4.0
    points = np.concatenate([triangles.reshape(-1, 3), (weights @ triangles).reshape(-1, 3)])
    return np.unique(points.round(9), axis=0)


def farthest(points: Array, triangles: Array, within: float) -> float:
    """The largest distance from a point to its nearest triangle; infinite where none is `within` that."""
    low, high = triangles.min(axis=1) - within, triangles.max(axis=1) + within
    near = np.ones((len(points), len(triangles)), dtype=bool)
    for k in range(3):
        near &= (points[:, k, None] >= low[:, k]) & (points[:, k, None] <= high[:, k])
    p, t = np.nonzero(near)
    nearest: Array = closest_point(triangles[t], points[p])  # type: ignore[no-untyped-call]
    least = np.full(len(points), np.inf)
    np.minimum.at(least, p, np.linalg.norm(nearest - points[p], axis=1))
    return float(least.max())


@cache
def flat_surface(part: str) -> Array:
    """Points on a parametric part: on its pieces, but for where two touch, from which no way leads out."""
    pieces = parametric().part(part).pieces
    points = samples(flat_shape(part))
    ways = 1e-5 * np.array(list(product((-1.0, 1.0), repeat=3)))
    around = (points[:, None] + ways).reshape(-1, 3).T
    inside = np.zeros(around.shape[1], dtype=bool)
    for normals, offsets in zip(*hexahedra.planes(pieces), strict=True):
        inside |= (normals @ around <= offsets[:, None] + 1e-7).all(axis=0)
    return points[~inside.reshape(len(points), -1).all(axis=1)]


def flat_shape(part: str) -> Array:
    """The triangles (T, 3, 3) of a parametric part's pieces."""
    return parametric().part(part).pieces[:, hexahedra.HEX_TRIANGLES].reshape(-1, 3, 3)


def volume(triangles: Array) -> float:
    return float(np.einsum("ti,ti->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2]))) / 6.0


def test_generator_reproduces_the_committed_files(tmp_path: Path) -> None:
    runpy.run_path(str(EXAMPLES / "make_bay.py"))["main"](tmp_path)

    made = sorted(path.name for path in tmp_path.iterdir())
    assert made == [
        "die.stl",
        "fasteners.csv",
        *(f"panel{form}.json" for form in ("", "_glb", "_step", "_stl")),
    ]
    for name in made:
        assert (tmp_path / name).read_bytes() == (BAY / name).read_bytes(), name


@pytest.mark.long
@pytest.mark.skipif(importlib.util.find_spec("build123d") is None, reason="needs the extra `cad`")
def test_generator_reproduces_the_committed_cad(tmp_path: Path) -> None:
    subprocess.run([sys.executable, EXAMPLES / "make_cad.py", tmp_path], check=True, capture_output=True)

    made = sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.*"))
    assert made == sorted(CAD)
    for name in made:
        assert (tmp_path / name).read_bytes() == (BAY / name).read_bytes(), name


@pytest.mark.parametrize("form", FORMS)
def test_every_part_is_where_the_parametric_one_is(form: str) -> None:
    """Within the chords of the one and those of the other, whichever is measured from."""
    bound = parametric().chord_deviation + TESSELLATION + ROUNDING

    assert tuple(shapes(form)) == parametric().part_ids
    for part, triangles in shapes(form).items():
        assert farthest(samples(triangles), flat_shape(part), bound) <= bound, part
        assert farthest(flat_surface(part), triangles, bound) <= bound, part


@pytest.mark.parametrize("form", FORMS)
def test_every_part_has_the_volume_of_the_parametric_one(form: str) -> None:
    """A chord is shorter than its arc by a sixth of the square of half its angle; a curved foot makes a
    stringer's web shorter by what it recedes.
    """
    arc = sweeps.MAX_TURN**2 / 24.0 + 1e-5
    for part, triangles in shapes(form).items():
        flat = float(hexahedra.volumes(parametric().part(part).pieces).sum())
        recedes = 1e-3 if part.startswith("S") else 0.0
        assert flat * (1.0 - arc - recedes) <= volume(triangles) <= flat * (1.0 + 4.0 * arc), part


@pytest.mark.parametrize("form", FORMS)
def test_triangles_of_the_skin_keep_to_its_true_faces(form: str) -> None:
    triangles = shapes(form)["skin"]
    centres, surface = triangles.mean(axis=1), parametric().surface
    u, v, _ = surface.locate(centres)
    n = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    facing = np.einsum("tk,tk->t", n, surface.normal(u, v)) / np.linalg.norm(n, axis=1)

    for side, depth in ((1.0, 0.0), (-1.0, 1.6e-3)):
        of_face = triangles[facing * side > 0.99]
        _, _, found = surface.locate(samples(of_face))
        assert len(of_face) >= 10
        assert depth - ROUNDING <= found.min()
        assert found.max() <= depth + TESSELLATION + ROUNDING


@needs_step
def test_the_forms_hold_the_same_surfaces() -> None:
    for part in PARTS:
        first, *others = (shapes(form)[part] for form in ("step", "glb", "stl"))
        for triangles in others:
            assert farthest(samples(triangles), first, 1e-3) <= TESSELLATION + ROUNDING
            assert farthest(samples(first), triangles, 1e-3) <= TESSELLATION + ROUNDING


@pytest.mark.parametrize("name", ["panel.step", "panel_holes.step"])
def test_step_is_an_assembly_of_named_parts_in_millimetres(name: str) -> None:
    text = (BAY / name).read_text()

    products = re.findall(r"= PRODUCT\('([^']*)'", text)
    occurrences = re.findall(r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\('\d+','([^']*)'", text)
    units = re.findall(r"LENGTH_UNIT\(\) NAMED_UNIT\(\*\) SI_UNIT\(([^)]*)\)", text)
    assert products == ["bay", *SHAPES]
    assert tuple(occurrences) == PARTS == parametric().part_ids
    assert set(units) == {".MILLI.,.METRE."}


@needs_step
def test_bodies_of_the_step_file_are_named_for_their_occurrences() -> None:
    for name in ("panel.step", "panel_holes.step"):
        assert sorted(body.name for body in model(name).bodies) == sorted(PARTS)


def test_glb_has_each_shape_once_and_a_pose_for_each_part() -> None:
    content = (BAY / "panel.glb").read_bytes()
    gltf = json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])

    assert [mesh["name"] for mesh in gltf["meshes"]] == list(SHAPES)
    placed = {node["name"]: node for node in gltf["nodes"] if "mesh" in node}
    assert tuple(placed) == PARTS
    assert all("matrix" in placed[part] for part in PARTS if part != "skin")


def test_fastener_list_is_that_of_the_parametric_panel() -> None:
    with (BAY / "fasteners.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))

    fasteners = parametric().fasteners
    assert 40 <= len(rows) <= 80
    assert [row["id"] for row in rows] == [fastener.id for fastener in fasteners]
    for row, fastener in zip(rows, fasteners, strict=True):
        assert [float(row[f"{c}_mm"]) for c in "xyz"] == pytest.approx(1000.0 * fastener.p, abs=1e-6)
        assert float(row["diameter_mm"]) == pytest.approx(1000.0 * fastener.diameter)
        assert float(row["grip_mm"]) == pytest.approx(1000.0 * fastener.grip, abs=1e-3)
        assert row["process"] == fastener.process


@pytest.mark.parametrize("form", FORMS)
def test_panels_of_meshes_have_the_fasteners_of_the_parametric_one(form: str) -> None:
    for entry, fastener in zip(document(form)["fasteners"], parametric().fasteners, strict=True):
        assert entry["id"] == fastener.id
        assert entry["p_mm"] == pytest.approx(1000.0 * fastener.p, abs=1e-9)
        assert entry["n"] == pytest.approx(fastener.n, abs=1e-12)


@needs_step
def test_pilot_holes_are_through_all_that_the_fasteners_join() -> None:
    whole, drilled = (
        {b.name: volume(b.corners()) for b in model(f"panel{of}.step").bodies} for of in ("", "_holes")
    )
    hole = np.pi * 2.05e-3**2 * 1.6e-3  # skin, stringers and clips are equally thick

    for part in PARTS:
        count = sum(part in stack.parts for stack in parametric().stacks)
        assert whole[part] - drilled[part] == pytest.approx(count * hole, rel=0.02, abs=1e-12)


def test_die_is_that_of_the_library() -> None:
    solids, mesh = load_dies()["j20"].solids, trimesh.load_mesh(BAY / "die.stl")

    reach = np.concatenate([solid.vertices for solid in solids] + [_box(s) for s in solids])
    assert mesh.is_volume
    assert mesh.bounds == pytest.approx(1000.0 * np.array([reach.min(axis=0), reach.max(axis=0)]), abs=1e-4)
    assert np.ptp(mesh.vertices[mesh.vertices[:, 2] > -1e-4, :2], axis=0) == pytest.approx([14.0, 14.0])


def _box(solid: Solid) -> Array:
    """Two opposite corners of the box around a cylinder along z; none of another shape."""
    if not isinstance(solid.shape, Cylinder):
        return np.zeros((0, 3))
    half = np.array([solid.shape.radius, solid.shape.radius, 0.5 * solid.shape.length])
    corners: Array = solid.T_link_solid[:3, 3] + np.array([-half, half])
    return corners
