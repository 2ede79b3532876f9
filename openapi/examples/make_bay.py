"""Writes the example bay, but for its CAD: `python openapi/examples/make_bay.py`. Same bytes every time.

A curved shell of two frames with mouse holes on three stringers, held by clips: as a parametric panel
(`bay/panel.json`), and what a user with CAD brings beside a STEP file: a list of fasteners, a die, and panels
whose parts are in the files that `make_cad.py` writes from the same sizes.
"""

import json
import math
import runpy
import sys
from pathlib import Path
from typing import Any, NamedTuple

HERE = Path(__file__).parent

Entry = dict[str, Any]

# Sizes [mm], of the shell in make_panels.py where it has them.
RADIUS, SKIN = 1975.0, 1.6
LENGTH, WIDTH = 700.0, 560.0
STRINGERS = (-190.0, 0.0, 190.0)  # arc lengths of the webs
RIVET_PITCH, RIVETS = 44.45, 16
FRAMES = (-177.8, 177.8)  # midway between two rivets
STANDOFF, HOLE_WIDTH, HOLE_HEIGHT = 12.0, 66.0, 42.0
CLIPS = ((0, -95.0), (0, 95.0), (1, -95.0), (1, 95.0))  # frame and arc length of the middle
CLIP_LENGTH, CLIP_RIVETS, CLIP_EDGE = 100.0, 4, 14.0
STRINGER: Entry = {
    "profile": "Z",
    "height_mm": 30,
    "foot_mm": 22,
    "top_mm": 22,
    "thickness_mm": 1.6,
    "line_mm": 12.4,
}
FRAME: Entry = {"profile": "C", "height_mm": 90, "foot_mm": 20, "top_mm": 20, "thickness_mm": 1.8}
CLIP: Entry = {"profile": "L", "height_mm": 60, "foot_mm": 20, "thickness_mm": 1.6, "line_mm": 10.4}
RIVET: Entry = {"diameter_mm": 4.0, "grip_mm": "from_stack", "process": "solid_rivet"}
#: Of the library, and how many chords stand for its circles.
DIE, DIE_CHORDS = "j20", 128


def panel() -> Entry:
    """The bay as a parametric panel."""
    start = 0.5 * (LENGTH - (RIVETS - 1) * RIVET_PITCH)
    return {
        "schema_version": "1.0",
        "id": "bay",
        "title": "Two frames with mouse holes on three stringers, clipped to a curved skin",
        "surface": {"section_radius_mm": RADIUS},
        "skin": {"id": "skin", "length_mm": LENGTH, "width_mm": WIDTH, "thickness_mm": SKIN},
        "sections": {"stringer": STRINGER, "frame": FRAME, "clip": CLIP},
        "stringers": [
            {"id": f"S{i + 1}", "section": "stringer", "arc_mm": arc} for i, arc in enumerate(STRINGERS)
        ],
        "frames": [
            {
                "id": f"F{k + 1}",
                "section": "frame",
                "x_mm": x,
                "standoff_mm": STANDOFF,
                "mouse_holes": [
                    {"arc_mm": arc, "width_mm": HOLE_WIDTH, "height_mm": HOLE_HEIGHT} for arc in STRINGERS
                ],
            }
            for k, x in enumerate(FRAMES)
        ],
        "clips": [
            {
                "id": f"K{i + 1}",
                "section": "clip",
                "frame": f"F{k + 1}",
                "side": "-x",
                "arc_mm": arc,
                "length_mm": CLIP_LENGTH,
            }
            for i, (k, arc) in enumerate(CLIPS)
        ],
        "rows": [
            {
                "id": "SR",
                "members": [f"S{i + 1}" for i in range(len(STRINGERS))],
                "pitch_mm": RIVET_PITCH,
                "count": RIVETS,
                "start_mm": round(start, 4),
                "serpentine": True,
                **RIVET,
            },
            {
                "id": "KR",
                "members": [f"K{i + 1}" for i in range(len(CLIPS))],
                "count": CLIP_RIVETS,
                "start_mm": CLIP_EDGE,
                "end_mm": CLIP_EDGE,
                "serpentine": True,
                **RIVET,
            },
        ],
    }


class Place(NamedTuple):
    """One part of the CAD: which shape, its origin [mm], and how far it is turned about x [degrees]."""

    part: str
    shape: str
    position: tuple[float, float, float]
    turn: float


def places() -> list[Place]:
    """The parts, in the order of the parametric panel's."""
    across = stringer_line()
    return [
        Place("skin", "skin", (0.0, 0.0, 0.0), 0.0),
        *(place(f"S{i + 1}", "stringer", 0.0, arc + across, SKIN) for i, arc in enumerate(STRINGERS)),
        *(Place(f"F{k + 1}", "frame", (x, 0.0, 0.0), 0.0) for k, x in enumerate(FRAMES)),
        *(place(f"K{i + 1}", "clip", FRAMES[k], arc, SKIN) for i, (k, arc) in enumerate(CLIPS)),
    ]


def fasteners() -> list[tuple[str, float, float]]:
    """The fasteners in the order of the program: id, x and arc length on the outer surface [mm]."""
    along = [(i - 0.5 * (RIVETS - 1)) * RIVET_PITCH for i in range(RIVETS)]
    step = (CLIP_LENGTH - 2.0 * CLIP_EDGE) / (CLIP_RIVETS - 1)
    across = [CLIP_EDGE - 0.5 * CLIP_LENGTH + i * step for i in range(CLIP_RIVETS)]
    rows = [
        *((f"SR.S{i + 1}", [(x, arc + stringer_line()) for x in along]) for i, arc in enumerate(STRINGERS)),
        *(
            (f"KR.K{i + 1}", [(FRAMES[k] + clip_line(), arc + v) for v in across])
            for i, (k, arc) in enumerate(CLIPS)
        ),
    ]
    made = []
    for n, (name, points) in enumerate(rows):
        numbered = [(f"{name}.{i + 1:03d}", *point) for i, point in enumerate(points)]
        backwards = (n if n < len(STRINGERS) else n - len(STRINGERS)) % 2 == 1
        made += numbered[::-1] if backwards else numbered
    return made


def stringer_line() -> float:
    """From a stringer's web to its rivets, across."""
    return float(STRINGER["line_mm"] + 0.5 * STRINGER["thickness_mm"])


def clip_line() -> float:
    """From a frame's web to the rivets of a clip, along x."""
    return -float(0.5 * FRAME["thickness_mm"] + CLIP["thickness_mm"] + CLIP["line_mm"])


def place(part: str, shape: str, x: float, arc: float, depth: float) -> Place:
    """A part whose z is the skin's normal at x and arc, its origin `depth` below the outer surface."""
    angle, radius = arc / RADIUS, RADIUS - depth
    at = (x, radius * math.sin(angle), radius * math.cos(angle) - RADIUS)
    return Place(part, shape, at, -math.degrees(angle))


def fastener_list() -> str:
    """CSV with a line to a fastener; the points are exact to a nanometre."""
    lines = ["id,x_mm,y_mm,z_mm,diameter_mm,grip_mm,process"]
    for name, x, arc in fasteners():
        _, y, z = place("", "", x, arc, 0.0).position
        grip = SKIN + (STRINGER if name.startswith("SR") else CLIP)["thickness_mm"]
        size = f"{RIVET['diameter_mm']:g},{grip:g},{RIVET['process']}"
        lines.append(f"{name},{x:.6f},{y:.6f},{z:.6f},{size}")
    return "\n".join(lines) + "\n"


def of_meshes(file: str, one_file: bool) -> Entry:
    """The bay with parts from one file, or from an STL for each shape, and its fasteners one by one."""
    meshes = []
    for part, shape, position, turn in places():
        entry: Entry = {"id": part, "kind": shape, "file": file.format(shape)}
        if one_file:
            entry["body"] = part
        else:
            entry |= {"unit": "mm", "position_mm": position, "rotation_deg": (turn, 0.0, 0.0)}
        meshes.append(entry)
    points = []
    for name, x, arc in fasteners():
        angle, at = arc / RADIUS, place(name, "", x, arc, 0.0).position
        normal = (0.0, math.sin(angle), math.cos(angle))
        points.append({"id": name, "p_mm": at, "n": normal, **RIVET})
    parametric = panel()
    kept = {key: parametric[key] for key in ("schema_version", "id", "title", "surface")}
    return {**kept, "skin": None, "meshes": meshes, "fasteners": points}


def die() -> Any:
    """The J die of our library as one closed mesh [mm], its circles of chords."""
    import manifold3d
    import numpy as np
    import trimesh

    library = json.loads((HERE.parents[1] / "robots" / "data" / "dies.json").read_text(encoding="utf-8"))
    (entry,) = (entry for entry in library["dies"] if entry["id"] == DIE)
    whole = manifold3d.Manifold()
    for shape in (solid["shape"] for solid in entry["solids"]):
        if shape["type"] == "cylinder":
            low, high = shape["z_mm"]
            circle = manifold3d.CrossSection.circle(shape["radius_mm"], DIE_CHORDS)
            x, y = shape["center_xy_mm"]
            whole += manifold3d.Manifold.extrude(circle, high - low).translate((x, y, low))
        else:
            low, high = shape["y_mm"]
            profile = manifold3d.CrossSection(
                [[(x, -z) for x, z in shape["profile_xz_mm"]]], manifold3d.FillRule.EvenOdd
            )
            upright = manifold3d.Manifold.extrude(profile, high - low).rotate((-90.0, 0.0, 0.0))
            whole += upright.translate((0.0, low, 0.0))
    made = whole.to_mesh()
    return trimesh.Trimesh(np.asarray(made.vert_properties)[:, :3], made.tri_verts, process=False)


def main(folder: Path = HERE / "bay") -> None:
    """Write every file that needs no CAD."""
    text = runpy.run_path(str(HERE / "make_panels.py"))["text"]
    folder.mkdir(parents=True, exist_ok=True)
    panels = {
        "panel.json": panel(),
        "panel_step.json": of_meshes("panel.step", one_file=True),
        "panel_glb.json": of_meshes("panel.glb", one_file=True),
        "panel_stl.json": of_meshes("stl/{}.stl", one_file=False),
    }
    for name, document in panels.items():
        (folder / name).write_text(text(document), encoding="utf-8")
    (folder / "fasteners.csv").write_text(fastener_list(), encoding="utf-8")
    (folder / "die.stl").write_bytes(die().export(file_type="stl"))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
