"""GAV: the free volume a tool can occupy at one orientation (Dakdouk 2016, 3.3.3; exact, by Minkowski sums).

The tool only translates. Its reference point, the middle of its tip, runs over a `Section`: a box in a frame
at a fastener, z along the tool axis and outwards. With P a convex piece of the panel, Q a convex part of the
tool and B a ball of the clearance that part must keep, the tool is too near P exactly where the reference
point lies in P + (-Q) + B. Q + B is replaced by a polytope around it, whose largest distance from Q + B is
stated as the excess: nothing is called free that is not, and what is farther from P than clearance and excess
is never called blocked. The union of all these sums is what is blocked; of the rest, what is connected to the
open side within the section's column is accessible, and what is not is an unreachable pocket.

The open side is below: the die comes from the inner side. It is the plane under everything that blocks the
column of the section, not the section's own lower face, so that a section which ends inside a hollow part
has no false way in. A way that leaves the column and comes back is not seen: such a place counts as
unreachable, on the safe side.

What is outside the tool (column, head, limits of the axes) is not asked here.
"""

from robots.free_volume.glb import to_glb
from robots.free_volume.section import Section, section_at
from robots.free_volume.tool import Tool, box_tool, cylinder_tool, die_tool
from robots.free_volume.volume import FreeVolume, Pocket, free_volume

__all__ = [
    "FreeVolume",
    "Pocket",
    "Section",
    "Tool",
    "box_tool",
    "cylinder_tool",
    "die_tool",
    "free_volume",
    "section_at",
    "to_glb",
]
