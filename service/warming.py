"""A first motion, computed before anybody asks for one: what is compiled is loaded by it."""

from service.inputs import Places, gather
from service.motion import plan_motion

_PANEL = {
    "schema_version": "1.0",
    "id": "warming",
    "title": "a sheet with one stringer",
    "surface": {"section_radius_mm": 1975.0},
    "skin": {"id": "skin", "length_mm": 300.0, "width_mm": 200.0, "thickness_mm": 1.6},
    "sections": {
        "stringer": {
            "profile": "Z",
            "height_mm": 30,
            "foot_mm": 22,
            "top_mm": 22,
            "thickness_mm": 1.6,
            "line_mm": 12.4,
        }
    },
    "stringers": [{"id": "S1", "section": "stringer", "arc_mm": 0.0}],
    "rows": [
        {
            "id": "R",
            "members": ["S1"],
            "pitch_mm": 25.0,
            "count": 2,
            "start_mm": 100.0,
            "diameter_mm": 4.0,
            "grip_mm": "from_stack",
            "process": "solid_rivet",
        }
    ],
}


def warm() -> None:
    """Compute it."""
    inputs = gather(_PANEL, "riveter", ["straight"], Places())
    first, second = (each.id for each in inputs.panel.fasteners)
    plan_motion(inputs.panel, inputs.machine, inputs.dies[0], first, second)
