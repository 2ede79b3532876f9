"""The cell's edge test as one compiled call on flat arrays; as `robots.cell` answers, never less careful.

flat       the numbers of a cell, packed: panel pieces, static tree, machine solids, pairs, clearances
tree       the tree over the panel's pieces: built once per panel
poses      closed form of the inverted chain: where every solid is in the panel's frame
shapes     support functions of the solids
simplex    closest point of a simplex to the origin
apart      the proof: a direction along which two convex bodies are at least `margin` apart
within     the gap questions of `robots.scene`
motion     the motion bound of `robots.motion_bound`
edge       the edge test of `robots.certified_edge`
space      `KernelSpace`, the Space of one link

Every negative answer ("not within") is a proof by a separating direction or by a box around a body; whatever
does not converge, overflows a stack or is not a number is "within".
"""
