"""The riveter with small hand-made panels in it: what tests of contact, stations and links start from."""

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import coal
import numpy as np

from planners.arrays import Array
from robots.cell import Cell
from robots.machine_file import load_machine
from robots.panel import Fastener, Panel, Stack
from robots.panel_file import load_panel
from robots.stack import find_stacks
from robots.stations import Refusal, Station, find_station
from tests.robots.flat_crossing import MM, fastener, flat_crossing, part
from tests.robots.panels import RIVET, Z30

MACHINE = load_machine("riveter")
FULLY_DOWN = MACHINE.axis("W").lower
HOME_ANGLE = MACHINE.axis("C").home
SKIN_ONLY = Stack(("skin",), 1.6 * MM, 1.6 * MM)
CROSSING = Path(__file__).parents[2] / "openapi" / "examples" / "crossing.json"


@cache
def crossing() -> Panel:
    """The curved crossing of the examples."""
    return load_panel(json.loads(CROSSING.read_bytes()))


def with_fasteners(panel: Panel, fasteners: Sequence[Fastener], *stacks: Stack) -> Panel:
    """The panel with these fasteners; one stack serves them all, or each has its own."""
    each = stacks * len(fasteners) if len(stacks) == 1 else stacks
    return replace(panel, fasteners=tuple(fasteners), stacks=each)


def riveted(panel: Panel, die: str) -> Cell:
    """The riveter with that die and the panel."""
    return Cell(MACHINE, MACHINE.dies[die], panel)


def station_or_refusal(
    where: Cell, index: int, came_from: Array | None = None, angle: float = HOME_ANGLE
) -> Station | Refusal:
    """What the stations' rule says about one fastener of the cell's panel."""
    return find_station(where, where.panel.fasteners[index], where.panel.stacks[index], came_from, angle)


def station(where: Cell, index: int, came_from: Array | None = None, angle: float = HOME_ANGLE) -> Station:
    """The station at a fastener that has one."""
    found = station_or_refusal(where, index, came_from, angle)
    assert isinstance(found, Station)
    return found


def refusal(where: Cell, index: int, came_from: Array | None = None, angle: float = HOME_ANGLE) -> Refusal:
    """The refusal of a fastener that has no station."""
    found = station_or_refusal(where, index, came_from, angle)
    assert isinstance(found, Refusal)
    return found


def bottle(*more: Fastener) -> Panel:
    """A fastener "inside" over a plate that leaves a hole just for the neck of the offset die at -90 degrees.

    The die fits there, and has no way in or out: a ship in a bottle. `more` fasteners on the skin come
    before it.
    """
    plate = part(
        "plate",
        "box",
        ((100, -290, -45), (186, -60, -32)),
        ((214, -290, -45), (300, -60, -32)),
        ((186, -290, -45), (214, -199, -32)),
        ((186, -171, -45), (214, -60, -32)),
    )
    return with_fasteners(flat_crossing((plate,)), (*more, fastener("inside", 200.0, -150.0)), SKIN_ONLY)


def on_surface(panel: Panel, *places: tuple[float, float]) -> Panel:
    """The panel with fasteners s0, s1, ... at arc lengths (u, v) [m] and the stacks that lie there."""
    fasteners = [
        Fastener(
            f"s{i}", panel.surface.point(u, v), panel.surface.normal(u, v), 4 * MM, 1.6 * MM, "solid_rivet"
        )
        for i, (u, v) in enumerate(places)
    ]
    points, normals = np.array([f.p for f in fasteners]), np.array([f.n for f in fasteners])
    return with_fasteners(panel, fasteners, *find_stacks(panel.parts, points, normals))


@cache
def wide_shell() -> Panel:
    """A skin 2.7 m wide around a radius of 1.975 m, with one stringer near its edge."""
    return load_panel(
        {
            "schema_version": "1.0",
            "id": "wide",
            "surface": {"section_radius_mm": 1975.0},
            "skin": {"length_mm": 300.0, "width_mm": 2700.0, "thickness_mm": 1.6},
            "sections": {"Z30": Z30},
            "stringers": [{"id": "S1", "section": "Z30", "arc_mm": 1320.0}],
            "rows": [{"id": "R", "members": ["S1"], "count": 2, **RIVET}],
        }
    )


def hull(piece: Array) -> coal.ConvexBase:
    """A convex piece (8, 3) as a collision shape."""
    points = coal.StdVec_Vec3s()
    for vertex in piece:
        points.append(vertex)
    return coal.Convex.convexHull(points, False, None)


def distance_to(where: Cell, solid: str, pieces: Array) -> float:
    """Distance [m] of a machine solid, as placed in the cell's scene, to convex pieces (H, 8, 3)."""
    shape, at = where.scene.shape_of(solid)
    fixed, request = coal.Transform3s(), coal.DistanceRequest()
    return min(
        float(coal.distance(shape, at, hull(p), fixed, request, coal.DistanceResult())) for p in pieces
    )


def shifted(q: Array, **by: float) -> Array:
    """`q` with some axes moved [m] or [rad]."""
    moved = np.array(q)
    for name, amount in by.items():
        moved[MACHINE.index(name)] += amount
    return moved
