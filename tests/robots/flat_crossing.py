"""A small panel built by hand: flat skin, one Z stringer under one floating C frame, fasteners along the
stringer.
"""

import numpy as np

from planners.arrays import Array
from robots.hexahedra import box
from robots.panel import Fastener, Panel, Part, PartKind, Stack
from robots.surface import Surface

MM = 1e-3


def part(name: str, kind: PartKind, *boxes: tuple[tuple[float, ...], tuple[float, ...]]) -> Part:
    """A part of axis-parallel boxes, corners in [mm]."""
    return Part(name, kind, np.stack([box(np.array(low) * MM, np.array(high) * MM) for low, high in boxes]))


def flat_crossing(extra: tuple[Part, ...] = (), sag: float = 0.0) -> Panel:
    """The panel; its web planes are y = 0 (stringer S1) and x = 0 (frame F1), its fasteners f0..f15 at y =
    -14 mm.
    """
    skin = part("skin", "skin", ((-600, -300, -1.6), (600, 300, 0)))
    stringer = part(
        "S1",
        "stringer",
        ((-600, -1.6, -31.6), (600, 0, -1.6)),
        ((-600, -22, -3.2), (600, -1.6, -1.6)),
        ((-600, 0, -31.6), (600, 20.4, -30)),
    )
    frame = part(
        "F1",
        "frame",
        ((0, -300, -137.6), (1.8, 300, -37.6)),
        ((1.8, -300, -39.4), (20, 300, -37.6)),
        ((1.8, -300, -137.6), (20, 300, -135.8)),
    )
    fasteners = tuple(fastener(f"f{i}", (i - 8) * 22.225 + 11.1, -14.0) for i in range(16))
    stack = Stack(("skin", "S1"), 3.2 * MM, 3.2 * MM)
    return Panel(
        id="flat_crossing",
        title="flat crossing",
        surface=Surface(),
        parts=(skin, stringer, frame, *extra),
        fasteners=fasteners,
        stacks=(stack,) * len(fasteners),
        mounting=np.eye(4),
        chord_deviation=0.0,
        sag=sag,
        sha256="0" * 64,
    )


def fastener(name: str, x_mm: float, y_mm: float) -> Fastener:
    """A solid rivet of 4 mm at (x, y) on the flat skin."""
    p: Array = np.array([x_mm, y_mm, 0.0]) * MM
    return Fastener(name, p, np.array([0.0, 0.0, 1.0]), 4 * MM, 3.2 * MM, "solid_rivet")
