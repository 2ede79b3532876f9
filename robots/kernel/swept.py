"""What a solid can meet on its way between two poses, `low` and `high`: the ends of a part of an edge.

No point p of a solid is accelerated by more than E (`motion`), and two functions with the same ends whose
second derivatives differ by no more than E differ by no more than E (s - low) (high - s) / 2: so on a part of
the edge of length 2 h a point is never farther than

    e = E h^2 / 2        [m]

from the chord between its two ends, and the solid never farther than e from the hull of itself at both poses.
The pair of solid and piece keeps its clearance all the way if the piece is that much and e away from this
hull. A solid that does not turn moves straight: E is 0, and the proof takes no more room than the motion.
For two moving solids the same is true of the points of their difference.

A part of a pair's motion that one direction separates is therefore proved at once, however long it is and
however close the two pass by each other. Where it bends, halving the part quarters e.
"""

from __future__ import annotations

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.layout import (
    BOX_CENTER,
    BOX_HALF,
    OWN_CENTER,
    OWN_HALF,
    POSE_T,
    SWEPT_CENTER,
    SWEPT_HALF,
)


@compiled_on_views
def room_to_bend(bend: float, half: float) -> float:
    """e [m], see above: for a pair's bound E and half the length of the part."""
    return 0.5 * bend * half * half


@compiled_on_views
def sweep(solids: Array, s: int, poses: Array, low: int, high: int, swept: Array) -> None:
    """Write pose and box of solid `s` between both ends into `swept`: a row of `poses` and six numbers.

    The pose is the one at `low`; the box is around both. The six: centre and half size of a box in the axes
    and about the origin of that pose. What is not a number at either end makes all of the boxes so.
    """
    a, b, doubt = low + s, high + s, 0.0
    for i in range(POSE_T + 3):
        swept[i] = poses[a, i]
        doubt += 0.0 * (poses[a, i] + poses[b, i])
    for i in range(3):
        near, far = poses[a, BOX_CENTER + i], poses[b, BOX_CENTER + i]
        one, other = poses[a, BOX_HALF + i], poses[b, BOX_HALF + i]
        lower, upper = min(near - one, far - other), max(near + one, far + other)
        swept[BOX_CENTER + i] = 0.5 * (lower + upper) + doubt
        swept[BOX_HALF + i] = 0.5 * (upper - lower) + doubt
    for j in range(3):
        lower = solids[s, OWN_CENTER + j] - solids[s, OWN_HALF + j]
        upper = solids[s, OWN_CENTER + j] + solids[s, OWN_HALF + j]
        if a != b:
            x, y, z = poses[a, j], poses[a, 3 + j], poses[a, 6 + j]
            center = half = 0.0
            for i in range(3):  # the box at `high` along axis j of the pose at `low`
                along = x * poses[b, i] + y * poses[b, 3 + i] + z * poses[b, 6 + i]
                center += along * solids[s, OWN_CENTER + i]
                half += abs(along) * solids[s, OWN_HALF + i]
            center += (
                x * (poses[b, POSE_T] - poses[a, POSE_T])
                + y * (poses[b, POSE_T + 1] - poses[a, POSE_T + 1])
                + z * (poses[b, POSE_T + 2] - poses[a, POSE_T + 2])
            )
            lower, upper = min(lower, center - half), max(upper, center + half)
        swept[SWEPT_CENTER + j] = 0.5 * (lower + upper) + doubt
        swept[SWEPT_HALF + j] = 0.5 * (upper - lower) + doubt
