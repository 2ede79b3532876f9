"""The cell's edge test as one compiled call on flat arrays; never less careful than the clearance asks.

flat       the numbers of a cell, packed: panel pieces, static tree, machine solids, pairs, clearances
poses      closed form of the inverted chain: where every solid is in the panel's frame
shapes     support functions of the solids
simplex    closest point of a simplex to the origin
apart      the proof: a direction along which two convex bodies are at least `margin` apart
swept      what a solid can meet between two poses, and why that proves a part of an edge
within     the gap questions of `robots.scene`, between two poses
motion     the motion bound of `robots.motion_bound`, and how much a motion bends
pairs      the questions that wait, and which of them are not proved
limits     axis limits of configurations and segments
edge       the edge test of `robots.certified_edge`
space      `KernelSpace`, the Space of one link
stations   `KernelStations`, the checks of a station
turned     a solid of the die turned about the tool axis, and the arc that one direction proves
turn       the free die angles of a whole turn
turns      `KernelTurns`, the free die angles at a fastener
under_face the pieces of a stack that lie under the tip's face
plain      values without the type of a literal

Every negative answer ("not within") is a proof by a separating direction or by a box around a body; whatever
does not converge, overflows a stack or is not a number is "within".
"""
