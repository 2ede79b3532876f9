"""Flat panels with blocks under the skin between which an offset die has to find its way to the fasteners."""

from collections.abc import Mapping, Sequence

from tests.robots.panels import RIVET, Document

POCKET = (
    "......##",
    "....#..#",
    ".......#",
    ".....#..",
    "........",
    "..#.....",
)
"""Rows along x, columns along the arc: the offset die fits at both fasteners of `pocket`, at some angles in a
pocket that it gets into from home, if at all, and not from the other fastener.
"""


def maze(
    plan: Sequence[str],
    fasteners: Mapping[str, tuple[float, float]],
    side_mm: float = 25.0,
    height_mm: float = 13.0,
    below_mm: float = 32.0,
) -> Document:
    """A skin with a doubler and under it, where `plan` has a #, a block; fasteners by id at (x, arc) [mm]
    from the middle of the plan.

    side_mm: of the plan's squares. height_mm, below_mm: of the blocks, and from the datum surface to them.
    """
    middle = (len(plan) - 1) / 2.0, (len(plan[0]) - 1) / 2.0
    places = [(i, j) for i, row in enumerate(plan) for j, cell in enumerate(row) if cell == "#"]
    return {
        "schema_version": "1.0",
        "id": "maze",
        "skin": {"length_mm": 500.0, "width_mm": 500.0, "thickness_mm": 1.6},
        "doublers": [{"id": "D", "x_mm": [-200.0, 200.0], "arc_mm": [-200.0, 200.0], "thickness_mm": 1.2}],
        "fasteners": [
            {"id": name, "p_mm": [x, arc, 0.0], "n": [0.0, 0.0, 1.0], **RIVET}
            for name, (x, arc) in fasteners.items()
        ],
        "boxes": [
            {
                "id": f"B{i}.{j}",
                "size_mm": [side_mm, side_mm, height_mm],
                "position_mm": [
                    side_mm * (i - middle[0]),
                    side_mm * (j - middle[1]),
                    -below_mm - height_mm / 2.0,
                ],
            }
            for i, j in places
        ],
    }


def pocket() -> Document:
    """Two fasteners that `POCKET` shuts off from each other."""
    return maze(POCKET, {"first": (-50.0, 68.0), "second": (61.0, 48.0)})
