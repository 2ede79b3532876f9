"""The verifier's geometry, compiled: proofs that every block of a program keeps its clearances.

layout     where each number of the flat arrays is; `Scene`, `Blocks`, `Found`
frames     the machine's chain multiplied out; how far a straight motion bulges from its chord, and how far
           points move when every axis is a little off
bodies     support functions of machine solids and panel pieces, and the gap along a direction
walk       the direction in which two bodies are farthest apart (Gilbert, Johnson, Keerthi 1988)
tree       which pieces come near a solid on a stretch of motion
stretch    everything known of one stretch of one block: poses at its ends, bulge, travel, what is needed
items      one solid against one piece on one stretch: proven, refuted, or to be halved
uncounted  how all of it is compiled
examine    all blocks of a program in one call
tips       where the die tip is at both ends of motions, and how far from the chord between

What counts as proof is in `frames` (the bulge) and `bodies` (the gap along a direction): a direction found by
whatever means is evaluated with those two. Whatever does not converge, overflows or is not a number is never
proven. Nothing here is shared with the planner's cell or kernel.
"""
