"""Where each number of the flat arrays is; all lengths in [m], angles in [rad].

Few and wide arrays, whole numbers among the others: every array that is handed on costs compile time.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array

Ints = NDArray[np.int64]
Point = tuple[float, float, float]
Pair = tuple[int, int, int, int, int]
"""A solid and the joint that carries it; the other solid, -1 for a piece, and its joint; the piece."""

# joints: fixed rotation and translation, direction and sign of the axis, whether it turns, its index in q
FIXED_T, DIRECTION, SIGN, TURNS, INDEX, JOINT = 9, 12, 15, 16, 17, 18
# placed joints: rotation and translation of what the joint carries, origin and direction of its axis
POSE_T, ORIGIN, AXIS, POSE = 9, 12, 15, 18
# solids: axis and radius of the disc, the ball around it, the joints of its link in the two chains, how many
# points and normals there are; then the normals, then the points
RADIUS, BALL, BALL_RADIUS, PANEL_ROW, OWN_ROW, N_POINTS, N_NORMALS, NORMALS = 3, 4, 7, 8, 9, 10, 11, 12
MOST_NORMALS = 34  # a prism of 32 sides; of more, the others are not asked
POINTS = NORMALS + 3 * MOST_NORMALS
# pieces: 8 vertices, 6 times an outward unit normal and the largest normal.x over the whole piece, the part
FACES, PART, PIECE = 24, 48, 49
# tasks: solid, other solid or -1 for the panel, whether its gaps count for the stated clearance, whether it
# is the die tip, clearance away from and near a fastener, for two solids a direction to begin with
SOLID, OTHER, STATED, IS_TIP, FAR, NEAR, HINT, TASK = 0, 1, 2, 3, 4, 5, 6, 9
# blocks
ASSEMBLY, AT_PROCESS, FIRST_CONTACT = range(3)
# what is known of a block: clearance proven, and measured at s for a task and piece; whether the die tip
# stands on the stack; whether all of it was examined
LOWER, UPPER, WHERE, OF_TASK, OF_PIECE, TOUCHING, EXAMINED, KNOWN = range(8)
# violations
BLOCK, BY_TASK, BY_PIECE, AT_S, GAP, NEED, VIOLATION = range(7)
# counts
VIOLATIONS, POSES = range(2)
# items: task, piece, bound proven so far, a direction to try
BOUND, ITEM = 2, 6


class Scene(NamedTuple):
    """The geometry of a panel on a machine with all its dies.

    joints (J, JOINT): two chains, one after the other: from the panel and, from joint `own` on, from the
    first tool link. die_row: the joint of the die's link in the first chain. home (n,): the machine's.
    solids (S, POINTS + 3 k): in their links' frames, each the hull of up to k points swept by a disc.
    pieces (H, PIECE): the panel's convex pieces in the panel frame, in the order of the tree's leaves.
    nodes (N, 6): lower and upper corner of the boxes of a complete binary tree: the children of node i are
    2 i + 1 and 2 i + 2. levels: below the root.
    tasks (T, TASK): what is examined; assemblies (A + 1,): runs of tasks, one for each set of solids that can
    be in the machine. near_radius, contact_depth: of the policy.
    """

    own: int
    die_row: int
    levels: int
    near_radius: float
    contact_depth: float
    joints: Array
    home: Array
    solids: Array
    pieces: Array
    nodes: Array
    tasks: Array
    assemblies: Ints


class Blocks(NamedTuple):
    """Motions along a straight line: start and delta (B, n); no axis is ever farther from it than slack (B,
    n) at the same share of the way.

    anchors (B, 2, 3): places in the panel frame where the tip works, NaN for nowhere. what (B + 1, 3): the
    assembly in the machine, whether it is at a process, and where the run of its contacts begins.
    contact_part: the parts the tip may stand on.
    """

    start: Array
    delta: Array
    slack: Array
    anchors: Array
    what: Ints
    contact_part: Ints


class Found(NamedTuple):
    """What is known of B blocks, (B, KNOWN); violations (V, VIOLATION), gap < 0 for an overlap.

    counts (2,): violations, listed or not, and poses looked at.
    """

    known: Array
    violations: Array
    counts: Ints


class Stretch(NamedTuple):
    """Work space for one stretch [s0, s1] of a block.

    P (3, J, POSE): joints placed at s0, at s1, and wherever a pair is measured. S (4, 3): for `walk`.
    near (3,): whether the die works near a fastener all over the stretch, at s0, at s1.
    """

    P: Array
    S: Array
    near: Ints


class Near(NamedTuple):
    """Work space of the tree, and what it found.

    items (H, ITEM): pieces within reach. own (6 + MOST_NORMALS, 4): directions, and how far the solid goes
    along them. stack (64,): nodes.
    """

    items: Array
    own: Array
    stack: Ints


_PLACING: Any = np.arange(3)  # not plain numbers: numba would compile what is called with them once for each
AT_S0: int = _PLACING[0]
AT_S1: int = _PLACING[1]
MEASURED: int = _PLACING[2]
"""Which placing of `Stretch.P`."""
