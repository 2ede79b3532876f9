"""Writes the CAD of the example bay: `python openapi/examples/make_cad.py`. Same bytes every time.

True curved surfaces, from the sizes in make_bay.py: where the parametric panel has chords, and flat feet
tangent to the skin, the CAD has arcs. An assembly as STEP, the same with pilot holes, the same as GLB, and an
STL of each shape. The solids are made with build123d: `pip install -e .[cad]`.
"""

import itertools
import math
import re
import sys
from pathlib import Path
from typing import Any

import trimesh
from build123d import Axis, Edge, Face, Location, Plane, Solid, Wire
from make_bay import (
    CLIP,
    CLIP_LENGTH,
    CLIPS,
    FRAME,
    HERE,
    HOLE_HEIGHT,
    HOLE_WIDTH,
    LENGTH,
    RADIUS,
    SKIN,
    STANDOFF,
    STRINGER,
    STRINGERS,
    WIDTH,
    clip_line,
    fasteners,
    place,
    places,
)
from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_ColorSurf, XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

COLORS = {
    "skin": (0.72, 0.77, 0.82),
    "stringer": (0.30, 0.52, 0.74),
    "frame": (0.87, 0.62, 0.25),
    "clip": (0.45, 0.66, 0.36),
}
#: Farthest a triangle may be from the true surface.
TOLERANCE = 0.02
PILOT_DIAMETER = 4.1
#: In the STEP header, so that the bytes do not change from day to day.
DATE = "2026-11-23T00:00:00"


def solids(pilot_holes: bool) -> dict[str, Any]:
    """The shapes [mm]; holes are square to the skin, one at every fastener."""
    made = {"skin": skin(), "stringer": stringer(), "frame": frame(), "clip": clip()}
    if not pilot_holes:
        return made
    holes = {
        "skin": [(x, arc) for _, x, arc in fasteners()],
        "stringer": [(x, 0.0) for name, x, _ in fasteners() if name.startswith("SR.S1")],
        "clip": [
            (clip_line(), arc - CLIPS[0][1]) for name, _, arc in fasteners() if name.startswith("KR.K1")
        ],
    }
    for shape, points in holes.items():
        depth = 0.0 if shape == "skin" else SKIN
        for x, arc in points:
            made[shape] = made[shape] - pilot_hole(x, arc, depth)
    return made


def skin() -> Any:
    """The skin; its origin is the crown of the outer surface, at mid-length."""
    return swept(rectangle(-0.5 * LENGTH, 0.5 * LENGTH, 0.0, SKIN), -0.5 * WIDTH, 0.5 * WIDTH)


def frame() -> Any:
    """A frame; its origin is on the crown of the outer surface, in the mid-plane of the web."""
    t, height = FRAME["thickness_mm"], FRAME["height_mm"]
    back, foot, top = -0.5 * t, FRAME["foot_mm"] - 0.5 * t, FRAME["top_mm"] - 0.5 * t
    section = [
        (back, 0.0),
        (foot, 0.0),
        (foot, t),
        (-back, t),
        (-back, height - t),
        (top, height - t),
        (top, height),
        (back, height),
    ]
    solid = swept([(x, SKIN + STANDOFF + h) for x, h in section], -0.5 * WIDTH, 0.5 * WIDTH)
    for arc in STRINGERS:
        hole = rectangle(-50.0, 50.0, 0.0, SKIN + HOLE_HEIGHT)
        solid = solid - swept(hole, arc - 0.5 * HOLE_WIDTH, arc + 0.5 * HOLE_WIDTH)
    return solid


def clip() -> Any:
    """A clip; its origin is on the middle of its foot, in the mid-plane of the frame's web."""
    t, height = CLIP["thickness_mm"], CLIP["height_mm"]
    face = -0.5 * FRAME["thickness_mm"]
    end = face - CLIP["foot_mm"]
    section = [(face, 0.0), (face, height), (face - t, height), (face - t, t), (end, t), (end, 0.0)]
    return swept(section, -0.5 * CLIP_LENGTH, 0.5 * CLIP_LENGTH, SKIN)


def stringer() -> Any:
    """A stringer; its origin is on its rivet line, at mid-length.

    Its section stands square to the skin's tangent there; the foot follows the skin.
    """
    t, height = STRINGER["thickness_mm"], STRINGER["height_mm"]
    web = -STRINGER["line_mm"] - t  # the face of the web away from the foot
    end, top, x = web + STRINGER["foot_mm"], web + t - STRINGER["top_mm"], -0.5 * LENGTH

    def arc(first: float, last: float, radius: float) -> Any:
        along = (first, 0.5 * (first + last), last)
        return Edge.make_three_point_arc(
            *((x, s, math.sqrt(radius**2 - s**2) - RADIUS + SKIN) for s in along)
        )

    outer, inner = arc(web, end, RADIUS - SKIN), arc(end, web + t, RADIUS - SKIN - t)
    corners = [(web + t, -height), (top, -height), (top, t - height), (web, t - height)]
    points = [inner @ 1, *((x, s, z) for s, z in corners), outer @ 0]
    straight = [Edge.make_line(a, b) for a, b in itertools.pairwise(points)]
    face = Face(Wire([outer, Edge.make_line(outer @ 1, inner @ 0), inner, *straight]))
    return Solid.extrude(face, (LENGTH, 0.0, 0.0))


def pilot_hole(x: float, arc: float, depth: float) -> Any:
    """What is cut for a hole, from an origin `depth` below the crown of the outer surface."""
    _, first, last = (place("", "", x, arc, at).position for at in (0.0, -5.0, 10.0))
    length = math.dist(first, last)
    normal = tuple((a - b) / length for a, b in zip(first, last, strict=True))
    origin = (last[0], last[1], last[2] + depth)
    return Solid.make_cylinder(0.5 * PILOT_DIAMETER, length, Plane(origin, z_dir=normal))


def rectangle(x0: float, x1: float, depth0: float, depth1: float) -> list[tuple[float, float]]:
    """Corners (x, depth)."""
    return [(x0, depth0), (x1, depth0), (x1, depth1), (x0, depth1)]


def swept(section: list[tuple[float, float]], first: float, last: float, depth: float = 0.0) -> Any:
    """A section of corners (x, depth), swept across between two arc lengths on the outer surface.

    Depths are from an origin that is `depth` below the crown of the outer surface.
    """
    face = Face(Wire.make_polygon([(x, 0.0, -h) for x, h in section]))
    axis = Axis((0.0, 0.0, depth - RADIUS), (1.0, 0.0, 0.0))
    turn = math.degrees(1.0 / RADIUS)
    return Solid.revolve(face.rotate(axis, -turn * first), -turn * (last - first), axis)


def write_step(path: Path, shapes: dict[str, Any]) -> None:
    """Write the assembly, in millimetres."""
    writer = STEPCAFControl_Writer()
    writer.SetNameMode(True)
    writer.SetColorMode(True)
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    Interface_Static.SetIVal_s("write.surfacecurve.mode", 0)  # surfaces say enough
    writer.Transfer(assembled(shapes), STEPControl_StepModelType.STEPControl_AsIs)
    header = APIHeaderSection_MakeHeader(writer.ChangeWriter().Model())
    header.SetName(TCollection_HAsciiString(path.name))
    header.SetTimeStamp(TCollection_HAsciiString(DATE))
    header.SetOriginatingSystem(TCollection_HAsciiString("make_cad.py"))
    if not writer.Write(str(path)):
        raise SystemExit(f"{path} cannot be written")
    path.write_text(in_order(path.read_text(encoding="utf-8")), encoding="utf-8")


def assembled(shapes: dict[str, Any]) -> TDocStd_Document:
    """A document of one assembly: a coloured product for each shape, a named occurrence for each part."""
    document = TDocStd_Document(TCollection_ExtendedString("XmlOcaf"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    XCAFDoc_DocumentTool.SetLengthUnit_s(document, 0.001)
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colors = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    XCAFDoc_ShapeTool.SetAutoNaming_s(False)

    def named(label: Any, name: str) -> Any:
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))
        return label

    assembly = named(tool.NewShape(), "bay")
    products = {}
    for name, shape in shapes.items():
        (solid,) = shape.solids()
        products[name] = named(tool.AddShape(solid.wrapped, False), name)
        colors.SetColor(products[name], Quantity_Color(*COLORS[name], Quantity_TOC_sRGB), XCAFDoc_ColorSurf)
    for part in places():
        location = Location(part.position, (part.turn, 0.0, 0.0))
        named(tool.AddComponent(assembly, products[part.shape], location.wrapped), part.part)
    tool.UpdateAssemblies()
    return document


def in_order(step: str) -> str:
    """A STEP text with its colours in the order of the solids; OCCT writes them last, in any order."""
    body, end = step.split("ENDSEC;\nEND-ISO")
    head, *blocks = re.split(r"(?m)^(?=#\d+ = MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION)", body)
    number = first = int(blocks[0][1 : blocks[0].index(" ")])
    for block in sorted(blocks, key=colored):
        shift = number - int(block[1 : block.index(" ")])
        head += renumbered(block, first, shift)
        number += len(re.findall(r"(?m)^#\d+ = ", block))
    return f"{head}ENDSEC;\nEND-ISO{end}"


def colored(block: str) -> int:
    """The number of the solid that a block of STEP text colours."""
    return int(re.findall(r"STYLED_ITEM\('color',\(#\d+\),#(\d+)\)", block)[0])


def renumbered(block: str, first: int, shift: int) -> str:
    """STEP text with every number from `first` on shifted."""
    return re.sub(r"#(\d+)", lambda m: f"#{int(m[1]) + (shift if int(m[1]) >= first else 0)}", block)


def mesh(shape: Any) -> Any:
    """Closed triangles [mm] within TOLERANCE of the solid's surface."""
    BRepMesh_IncrementalMesh(shape.wrapped, TOLERANCE, False, 1.0, False)  # absolute, in one thread
    vertices, triangles = shape.tessellate(TOLERANCE, 1.0)
    made = trimesh.Trimesh([tuple(v) for v in vertices], triangles, process=False)
    made.merge_vertices(digits_vertex=6)
    if not made.is_volume:
        raise SystemExit("the triangles of a shape are not closed")
    return made


def glb(meshes: dict[str, Any]) -> bytes:
    """The assembly as glTF says: in metres, each shape once, a named node with its pose for each part."""
    scene = trimesh.Scene(base_frame="bay")
    for name, made in meshes.items():
        color = [*(linear(c) for c in COLORS[name]), 255]
        material = trimesh.visual.material.PBRMaterial(
            name=name, baseColorFactor=color, metallicFactor=0.3, roughnessFactor=0.6
        )
        made = made.copy()
        made.apply_scale(0.001)
        made.visual = trimesh.visual.TextureVisuals(material=material)
        scene.geometry[name] = made
    for part in places():
        T = trimesh.transformations.rotation_matrix(math.radians(part.turn), (1.0, 0.0, 0.0))
        T[:3, 3] = [c / 1000.0 for c in part.position]
        scene.graph.update(part.part, "bay", matrix=T, geometry=part.shape)
    written: bytes = scene.export(file_type="glb")
    return written


def linear(c: float) -> int:
    """A share of a colour in sRGB, which COLORS are, as the linear byte that glTF asks for."""
    return round(255 * (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4))


def main(folder: Path = HERE / "bay") -> None:
    """Write every file of CAD."""
    (folder / "stl").mkdir(parents=True, exist_ok=True)
    plain = solids(pilot_holes=False)
    write_step(folder / "panel.step", plain)
    write_step(folder / "panel_holes.step", solids(pilot_holes=True))
    meshes = {name: mesh(shape) for name, shape in plain.items()}
    (folder / "panel.glb").write_bytes(glb(meshes))
    for name, made in meshes.items():
        (folder / "stl" / f"{name}.stl").write_bytes(made.export(file_type="stl"))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
