"""Small panel definitions and oracles for the tests of panels."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from planners.arrays import Array
from robots.errors import InputProblem, InvalidInput
from robots.hexahedra import HEX_FACES, planes
from robots.panel import Panel
from robots.panel_file import load_panel

Document = dict[str, Any]

Z30 = {
    "profile": "Z",
    "height_mm": 30.0,
    "foot_mm": 22.0,
    "top_mm": 22.0,
    "thickness_mm": 1.6,
    "line_mm": 12.4,
}
C100 = {"profile": "C", "height_mm": 100.0, "foot_mm": 20.0, "top_mm": 20.0, "thickness_mm": 1.8}
L80 = {"profile": "L", "height_mm": 80.0, "foot_mm": 20.0, "thickness_mm": 1.6, "line_mm": 10.4}
RIVET = {"diameter_mm": 4.0, "grip_mm": "from_stack", "process": "solid_rivet"}

SURFACES: list[Document] = [
    {},
    {"section_radius_mm": 1975.0},
    {"section_radius_mm": 1657.0, "length_radius_mm": 8100.0},
    {"length_radius_mm": 3000.0},
]


def small_panel(**changes: Any) -> Document:
    """A flat 400 x 400 skin with a stringer, a floating frame, a clip and two rows; sound as it stands."""
    document: Document = {
        "schema_version": "1.0",
        "id": "small",
        "skin": {"length_mm": 400.0, "width_mm": 400.0, "thickness_mm": 1.6},
        "sections": {"Z30": dict(Z30), "C100": dict(C100), "L80": dict(L80)},
        "stringers": [{"id": "S1", "section": "Z30", "arc_mm": 0.0}],
        "frames": [{"id": "F1", "section": "C100", "x_mm": 0.0, "standoff_mm": 36.0}],
        "clips": [
            {"id": "K1", "section": "L80", "frame": "F1", "side": "-x", "arc_mm": 95.0, "length_mm": 140.0}
        ],
        "fasteners": [
            {
                "id": "tack",
                "p_mm": [100.0, 13.2, 0.0],
                "n": [0.0, 0.0, 1.0],
                "diameter_mm": 4.0,
                "grip_mm": 3.2,
                "process": "solid_rivet",
            }
        ],
        "rows": [
            {"id": "R1", "members": ["S1"], "pitch_mm": 22.0, "end_mm": 240.0, **RIVET},
            {"id": "R2", "members": ["K1"], "count": 5, **RIVET},
        ],
    }
    document.update(changes)
    return copy.deepcopy(document)


def changed(path: str, value: Any) -> Document:
    """The small panel with the member at `path` (keys and indices) set."""
    document = small_panel()
    *way, last = [int(key) if key.isdecimal() else key for key in path.split("/")]
    here: Any = document
    for key in way:
        here = here[key]
    here[last] = value
    return document


def without(path: str) -> Document:
    """The small panel without the member at `path`."""
    document = changed(path, None)
    *way, last = [int(key) if key.isdecimal() else key for key in path.split("/")]
    here: Any = document
    for key in way:
        here = here[key]
    del here[last]
    return document


def problems_of(document: Any) -> list[InputProblem]:
    """The problems `load_panel` finds; none when it gives a panel."""
    try:
        load_panel(document)
    except InvalidInput as error:
        return list(error.problems)
    return []


def found(document: Any) -> list[tuple[str, str]]:
    """Pointer and code of each problem."""
    return [(problem.pointer, problem.code) for problem in problems_of(document)]


def pieces_of(panel: Panel, part_id: str) -> Array:
    """The pieces of one part."""
    return panel.part(part_id).pieces


def inside(pieces: Array, point: Array, slack: float = 0.0) -> bool:
    """Brute-force membership: is the point in any of the convex pieces (grown by `slack`)?"""
    normals, offsets = planes(pieces)
    return bool((normals @ point <= offsets + slack).all(axis=1).any())


def assert_sound(pieces: Array) -> None:
    """Every piece is a convex hexahedron with planar faces whose vertex order points outwards."""
    faces = pieces[:, HEX_FACES]  # (H, 6, 4, 3)
    normals = np.cross(faces[:, :, 2] - faces[:, :, 0], faces[:, :, 3] - faces[:, :, 1])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    offsets = np.einsum("hfvk,hfk->hfv", faces, normals)
    assert np.ptp(offsets, axis=-1).max() < 1e-9, "a face is not planar"
    heights = np.einsum("hvk,hfk->hfv", pieces, normals)
    assert (heights <= offsets.max(axis=-1, keepdims=True) + 1e-9).all(), (
        "not convex, or a face turned inwards"
    )
    centres = np.einsum("hk,hfk->hf", pieces.mean(axis=1), normals)
    assert (centres < offsets.min(axis=-1) - 1e-6).all(), "a face points inwards"
