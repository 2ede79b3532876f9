"""Writes the example panels beside this file: `python openapi/examples/make_panels.py`. Same bytes every
time.

The A320-class shell follows the design's default panel; wing, fuselage and cockpit have the sizes of the
three panels of the Ryerson thesis (tables 6-3 to 6-5), with members that are plausible where the thesis
gives none.
"""

import json
import math
from pathlib import Path

Entry = dict[str, object]

RADIUS = 1975.0
FRAME_PITCH = 533.4
STRINGER_PITCH = 190.0
RIVET_PITCH = 22.225  # 533.4 / 24, and 7/8 in

SHELL_SECTIONS: Entry = {
    "stringer": {
        "profile": "Z",
        "height_mm": 30,
        "foot_mm": 22,
        "top_mm": 22,
        "thickness_mm": 1.6,
        "line_mm": 12.4,
    },
    "frame": {"profile": "C", "height_mm": 100, "foot_mm": 20, "top_mm": 20, "thickness_mm": 1.8},
    "clip": {"profile": "L", "height_mm": 80, "foot_mm": 20, "thickness_mm": 1.6, "line_mm": 10.4},
}
#: Solid rivets of 4 mm, the stack's own thickness as grip.
RIVET: Entry = {"diameter_mm": 4.0, "grip_mm": "from_stack", "process": "solid_rivet"}


def main() -> None:
    """Write every example."""
    here = Path(__file__).parent
    for panel in (a320_shell(), crossing(), crossing_holes(), wing(), fuselage(), cockpit()):
        (here / f"{panel['id']}.json").write_text(text(panel), encoding="utf-8")


def text(panel: Entry) -> str:
    """JSON with one entry of a list or table to a line."""
    lines = []
    for name, value in panel.items():
        if name == "sections" and isinstance(value, dict):
            inner = ",\n".join(
                f"    {json.dumps(key)}: {json.dumps(section)}" for key, section in value.items()
            )
            lines.append(f"  {json.dumps(name)}: {{\n{inner}\n  }}")
        elif isinstance(value, list):
            inner = ",\n".join(f"    {json.dumps(entry)}" for entry in value)
            lines.append(f"  {json.dumps(name)}: [\n{inner}\n  ]")
        else:
            lines.append(f"  {json.dumps(name)}: {json.dumps(value)}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def a320_shell() -> Entry:
    """The default panel: 13 stringers, 9 floating frames, 117 crossings, 108 clips, about 3,200 fasteners.

    A frame's web plane lies midway between two rivets of every stringer. The program runs along the
    stringers forward and back, then along the clips of one frame after the other, then over the doubler and
    the straps.
    """
    length = 8 * FRAME_PITCH + 2 * 150.0
    stringers = [f"S{i + 1:02d}" for i in range(13)]
    frames = [round((k - 4) * FRAME_PITCH, 4) for k in range(9)]
    end = round(150.0 - 5.5 * RIVET_PITCH, 4)  # the last of six rivets beyond the outer frames
    clip_rows = []
    for k in range(9):
        members = [f"K{k + 1}-{i + 1:02d}" for i in range(12)]
        back = k % 2 == 1
        row = {"id": f"KR{k + 1}", "members": members[::-1] if back else members, "count": 5}
        clip_rows.append({**row, "start_mm": 14.0, "end_mm": 14.0, "reverse": back, **RIVET})
    return {
        "schema_version": "1.0",
        "id": "a320_shell",
        "title": "A320-class fuselage shell, 8 frame bays, 72 degrees",
        "surface": {"section_radius_mm": RADIUS},
        "skin": {"id": "skin", "length_mm": round(length, 4), "width_mm": 2480.0, "thickness_mm": 1.6},
        "sag_mm": 0.2,
        "sections": SHELL_SECTIONS,
        "doublers": [
            {"id": "D1", "x_mm": [-400.0, -130.0], "arc_mm": [420.0, 530.0], "thickness_mm": 1.2},
        ],
        "straps": [
            {"id": "T1", "x_mm": [776.0, 824.0], "arc_mm": [-535.0, -415.0], "thickness_mm": 1.2},
            {"id": "T2", "x_mm": [1309.0, 1357.0], "arc_mm": [-535.0, -415.0], "thickness_mm": 1.2},
        ],
        "stringers": [
            {"id": name, "section": "stringer", "arc_mm": (i - 6) * STRINGER_PITCH}
            for i, name in enumerate(stringers)
        ],
        "frames": [
            {"id": f"F{k + 1}", "section": "frame", "x_mm": x, "standoff_mm": 36.0}
            for k, x in enumerate(frames)
        ],
        "clips": [
            {
                "id": f"K{k + 1}-{i + 1:02d}",
                "section": "clip",
                "frame": f"F{k + 1}",
                "side": "-x",
                "arc_mm": (i - 5.5) * STRINGER_PITCH,
                "length_mm": 140.0,
            }
            for k in range(9)
            for i in range(12)
        ],
        "boxes": [bracket("B1", [40.0, 60.0, 40.0], x=20.9, arc=95.0, depth=81.6, radius=RADIUS)],
        "rows": [
            {
                "id": "SR",
                "members": stringers,
                "pitch_mm": RIVET_PITCH,
                "start_mm": end,
                "end_mm": end,
                "serpentine": True,
                **RIVET,
            },
            *clip_rows,
            plate_row("DR1", "D1", "x", -43.0, 10),
            {**plate_row("DR2", "D1", "x", 43.0, 10), "reverse": True},
            plate_row("TR1", "T1", "arc", 0.0, 5),
            plate_row("TR2", "T2", "arc", 0.0, 5),
        ],
    }


def crossing() -> Entry:
    """Two bays on either side of one stringer under one floating frame, cut from the shell."""
    return {
        "schema_version": "1.0",
        "id": "crossing",
        "title": "One stringer under one frame, cut from the shell",
        "surface": {"section_radius_mm": RADIUS},
        "skin": {"id": "skin", "length_mm": 500.0, "width_mm": 480.0, "thickness_mm": 1.6},
        "sections": SHELL_SECTIONS,
        "stringers": [
            {"id": f"S{i + 1}", "section": "stringer", "arc_mm": (i - 1) * STRINGER_PITCH} for i in range(3)
        ],
        "frames": [{"id": "F1", "section": "frame", "x_mm": 0.0, "standoff_mm": 36.0}],
        "clips": [
            {
                "id": f"K{i + 1}",
                "section": "clip",
                "frame": "F1",
                "side": "-x",
                "arc_mm": arc,
                "length_mm": 140.0,
            }
            for i, arc in enumerate((-95.0, 95.0))
        ],
        "rows": [
            crossing_row(),
            {"id": "KR", "members": ["K1", "K2"], "count": 2, "start_mm": 28.0, "end_mm": 28.0, **RIVET},
        ],
    }


def crossing_holes() -> Entry:
    """The same crossing with a frame that stands on the skin and lets the stringers through mouse holes."""
    return {
        "schema_version": "1.0",
        "id": "crossing_holes",
        "title": "One stringer through the mouse hole of one frame",
        "surface": {"section_radius_mm": RADIUS},
        "skin": {"id": "skin", "length_mm": 500.0, "width_mm": 480.0, "thickness_mm": 1.6},
        "sections": {
            "stringer": SHELL_SECTIONS["stringer"],
            "frame": {**section("frame"), "foot_mm": 22, "line_mm": 12.2},
        },
        "stringers": [
            {"id": f"S{i + 1}", "section": "stringer", "arc_mm": (i - 1) * STRINGER_PITCH} for i in range(3)
        ],
        "frames": [
            {
                "id": "F1",
                "section": "frame",
                "x_mm": 0.0,
                "mouse_holes_at_stringers": {"side_clearance_mm": 15.0, "top_clearance_mm": 15.0},
            }
        ],
        "rows": [
            crossing_row(),
            {"id": "FR", "members": ["F1"], "pitch_mm": 32.0, "start_mm": 113.0, "end_mm": 110.0, **RIVET},
        ],
    }


def crossing_row() -> Entry:
    """Eight rivets of the middle stringer, four on each side of the frame."""
    start = 250.0 - 3.5 * RIVET_PITCH
    return {"id": "SR", "members": ["S2"], "pitch_mm": RIVET_PITCH, "count": 8, "start_mm": start, **RIVET}


def wing() -> Entry:
    """Thesis table 6-3: 567 x 650 x 1.7 mm, R 4075, four stringers of 29 rivets, C beams across the ends."""
    arcs = [round((i - 1.5) * 567.0 / 4, 3) for i in range(4)]
    return {
        "schema_version": "1.0",
        "id": "wing",
        "title": "Wing panel of the thesis, table 6-3",
        "surface": {"section_radius_mm": 4075.0},
        "skin": {"id": "skin", "length_mm": 650.0, "width_mm": 567.0, "thickness_mm": 1.7},
        "sections": {
            "stringer": {
                "profile": "Z",
                "height_mm": 32,
                "foot_mm": 26,
                "top_mm": 20,
                "thickness_mm": 1.7,
                "line_mm": 13.3,
            },
            "beam": {"profile": "C", "height_mm": 60, "foot_mm": 25, "top_mm": 25, "thickness_mm": 2.0},
        },
        "stringers": [
            {"id": f"S{i + 1}", "section": "stringer", "arc_mm": arc} for i, arc in enumerate(arcs)
        ],
        "frames": [
            {"id": "C1", "section": "beam", "x_mm": -310.0, "standoff_mm": 40.0},
            {"id": "C2", "section": "beam", "x_mm": 310.0, "standoff_mm": 40.0, "mirrored": True},
        ],
        "rows": [
            {
                "id": "SR",
                "members": [f"S{i + 1}" for i in range(4)],
                "pitch_mm": 22.0,
                "count": 29,
                "start_mm": 17.0,
                "serpentine": True,
                **RIVET,
                "diameter_mm": 5.5,
            }
        ],
    }


def fuselage() -> Entry:
    """Thesis table 6-4: 1130 x 2180 mm, 2 mm, R 1550, three stringers of 88 rivets, ten obstacles.

    88 rivets at the printed 25.3 mm do not fit 2180 mm; the pitch follows from the length and the printed
    side distance.
    """
    names = [f"S{i + 1}" for i in range(3)]
    return {
        "schema_version": "1.0",
        "id": "fuselage",
        "title": "Fuselage panel of the thesis, table 6-4",
        "surface": {"section_radius_mm": 1550.0},
        "skin": {"id": "skin", "length_mm": 2180.0, "width_mm": 1130.0, "thickness_mm": 2.0},
        "sections": {
            "stringer": {
                "profile": "Z",
                "height_mm": 34,
                "foot_mm": 30,
                "top_mm": 22,
                "thickness_mm": 1.8,
                "line_mm": 15.4,
            },
            "frame": {"profile": "C", "height_mm": 100, "foot_mm": 30, "top_mm": 22, "thickness_mm": 1.8},
        },
        "stringers": [
            {"id": name, "section": "stringer", "arc_mm": (i - 1) * 370.0} for i, name in enumerate(names)
        ],
        "frames": [
            {
                "id": f"F{k + 1}",
                "section": "frame",
                "x_mm": (k - 1.5) * 545.0,
                "mouse_holes_at_stringers": {"side_clearance_mm": 12.0, "top_clearance_mm": 10.0},
            }
            for k in range(4)
        ],
        "boxes": [
            bracket(
                f"B{k + 1}",
                [40.0, 60.0, 40.0],
                x=(k - 1.5) * 545.0 - 20.9,
                arc=185.0,
                depth=60.0,
                radius=1550.0,
            )
            for k in range(3)
        ],
        "rows": [
            {
                "id": "SR",
                "members": names,
                "count": 88,
                "start_mm": 12.64,
                "end_mm": 12.64,
                "serpentine": True,
                **RIVET,
                "diameter_mm": 6.35,
            }
        ],
    }


def cockpit() -> Entry:
    """Thesis table 6-5: 1242.6 x 1370 x 2 mm, Rv 1657, Rh 8100, three stringers of 54 rivets, 9 obstacles."""
    names = [f"S{i + 1}" for i in range(3)]
    return {
        "schema_version": "1.0",
        "id": "cockpit",
        "title": "Cockpit panel of the thesis, table 6-5",
        "surface": {"section_radius_mm": 1657.0, "length_radius_mm": 8100.0},
        "skin": {"id": "skin", "length_mm": 1370.0, "width_mm": 1242.6, "thickness_mm": 2.0},
        "sections": {
            "stringer": {
                "profile": "J",
                "height_mm": 32,
                "foot_mm": 58,
                "top_mm": 16,
                "thickness_mm": 1.8,
                "line_mm": 15.4,
            },
            "frame": {"profile": "Z", "height_mm": 90, "foot_mm": 22, "top_mm": 22, "thickness_mm": 2.0},
            "bar": {"profile": "U", "height_mm": 30, "foot_mm": 40, "thickness_mm": 2.0},
        },
        "straps": [{"id": "T1", "x_mm": [-30.0, 30.0], "arc_mm": [120.0, 280.0], "thickness_mm": 1.2}],
        "stringers": [
            {"id": name, "section": "stringer", "arc_mm": (i - 1) * 400.0} for i, name in enumerate(names)
        ],
        "frames": [
            {"id": f"F{k + 1}", "section": "frame", "x_mm": (k - 1) * 450.0, "standoff_mm": 38.0}
            for k in range(3)
        ],
        "boxes": [bracket("B1", [40.0, 60.0, 40.0], x=225.0, arc=200.0, depth=90.0, radius=1657.0)],
        "extrusions": [
            {"id": "E1", "section": "bar", "length_mm": 300.0, "position_mm": [-225.0, -200.0, -90.0]},
        ],
        "rows": [
            {
                "id": "SR",
                "members": names,
                "count": 54,
                "start_mm": 12.7,
                "end_mm": 12.7,
                "serpentine": True,
                **RIVET,
                "diameter_mm": 6.35,
            }
        ],
    }


def bracket(name: str, size: list[float], x: float, arc: float, depth: float, radius: float) -> Entry:
    """A box parallel to a skin curved across, at x and arc, its centre `depth` below the outer surface."""
    angle = arc / radius
    y = (radius - depth) * math.sin(angle)
    z = (radius - depth) * math.cos(angle) - radius
    return {
        "id": name,
        "size_mm": size,
        "position_mm": [round(x, 3), round(y, 3), round(z, 3)],
        "rotation_deg": [round(-math.degrees(angle), 4), 0.0, 0.0],
    }


def plate_row(name: str, plate: str, direction: str, offset: float, count: int) -> Entry:
    """Rivets along a doubler or strap."""
    places: Entry = {
        "direction": direction,
        "offset_mm": offset,
        "count": count,
        "start_mm": 12.0,
        "end_mm": 12.0,
    }
    return {"id": name, "members": [plate], **places, **RIVET}


def section(name: str) -> Entry:
    """One of the shell's sections."""
    found = SHELL_SECTIONS[name]
    assert isinstance(found, dict)
    return found


if __name__ == "__main__":
    main()
