"""The arrays of one call: the cell's numbers unpacked, and the work space.

A cell is handed over as two arrays, because every array costs a call some tenths of a microsecond; the work
space is two more, made once for many calls and never remembered from one to the next. Nothing here counts
references (`compiled_on_views`): for dozens of arrays and hundreds of tree nodes that costs more than the
geometry. The caller of `ask` holds the owners while it runs, and no counted function may take the views.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeVar

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.layout import (
    DEPTH,
    HEADER,
    MACHINE,
    N_CORNERS,
    N_NODES,
    N_OPEN_PAIRS,
    N_PAIRS,
    N_PIECES,
    N_SOLIDS,
    OWN,
    PIECES,
    POSE,
    SOLIDS,
    SWEPT,
    TIP_PAIR,
    Ints,
)

Numbers = TypeVar("Numbers", Array, Ints)

LEVELS = 24
"""Parts of an edge that may wait: 20 m are halved 20 times before a part is too short to matter."""

SLOTS = LEVELS + 2
"""Configurations placed at a time: the ends of all parts that wait, and one more."""

MOST = 8
"""Pieces near a solid from which on they are not remembered one by one."""


class Views(NamedTuple):
    """The arrays of a cell as `layout` describes them."""

    machine: Array
    boxes: Array
    pieces: Array
    solids: Array
    profiles: Array
    needs: Array
    always: Array
    nodes: Ints
    kinds: Ints
    pairs: Ints
    tip_pair: int
    open_pairs: int


class Work(NamedTuple):
    """Work space of one call.

    q (7,): configuration being placed. frames (6 SLOTS, 12), poses (2 S SLOTS, POSE): see `poses`; of every
    placed configuration ("slot") the panel's frame first, then that of link X. placed (2 S SLOTS,): 1 where
    that row of poses is written. asked (K, 2): clearances
    other than the cell's. motion, bend (K,): see `motion`. spans (LEVELS, 2), counts (LEVELS,), slots
    (LEVELS + 1,): parts of the edge that wait, with the number of their items and the slot of their end.
    waiting (LEVELS + 1, K MOST): the items, see `pairs`. swept, S, stack, found: of `swept` and `within`.
    meant (1 + H,): number of the pieces that the die tip may touch, and the pieces; input of the question
    STATION, the only thing in the work space that is read before it is written.
    """

    q: Array
    frames: Array
    poses: Array
    asked: Array
    motion: Array
    bend: Array
    spans: Array
    swept: Array
    S: Array
    meant: Ints
    waiting: Ints
    counts: Ints
    slots: Ints
    placed: Ints
    found: Ints
    stack: Ints


@compiled_on_views
def views_of(numbers: Array, indices: Ints) -> Any:
    """Unpack what `flat.pack` has packed."""
    N, H, S = indices[N_NODES], indices[N_PIECES], indices[N_SOLIDS]
    P, K = indices[N_CORNERS], indices[N_PAIRS]
    own = indices[OWN]
    boxes = 1
    pieces = boxes + 6 * N
    solids = own + MACHINE
    profiles = solids + SOLIDS * S
    needs = profiles + 2 * P
    always = needs + 2 * K
    kinds = HEADER + 2 * N
    pairs = kinds + 4 * S
    return Views(
        numbers[own:solids],
        numbers[boxes:pieces].reshape(N, 6),
        numbers[pieces : pieces + PIECES * H].reshape(H, PIECES),
        numbers[solids:profiles].reshape(S, SOLIDS),
        numbers[profiles:needs].reshape(P, 2),
        numbers[needs:always].reshape(K, 2),
        numbers[always : always + K],
        indices[HEADER:kinds].reshape(N, 2),
        indices[kinds:pairs].reshape(S, 4),
        indices[pairs : pairs + 2 * K].reshape(K, 2),
        indices[TIP_PAIR],
        indices[N_OPEN_PAIRS],
    )


def block_sizes(indices: Ints) -> tuple[int, int]:
    """Lengths of the two blocks of work space for a packed cell."""
    H, S, K, depth = indices[[N_PIECES, N_SOLIDS, N_PAIRS, DEPTH]].tolist()
    numbers = 7 + SLOTS * (6 * 12 + 2 * S * POSE) + 4 * K + 2 * LEVELS + SWEPT + 33
    whole = 1 + H + (LEVELS + 1) * (K * MOST + 2) + 2 * S * SLOTS + MOST + 1 + depth + 2
    return numbers, whole


def new_blocks(sizes: tuple[int, int]) -> tuple[Array, Ints]:
    """The two blocks of work space of these lengths; one call at a time may use them."""
    return np.empty(sizes[0]), np.empty(sizes[1], dtype=np.int64)


@compiled_on_views
def work_of(numbers: Array, whole: Ints, indices: Ints) -> Any:
    """Unpack the blocks."""
    S, K = indices[N_SOLIDS], indices[N_PAIRS]
    asked = 7
    motion = asked + 2 * K
    bend = motion + K
    spans = bend + K
    swept = spans + 2 * LEVELS
    simplex = swept + SWEPT
    frames = simplex + 33
    poses = frames + 72 * SLOTS
    counts = 1 + indices[N_PIECES]
    slots = counts + LEVELS
    found = slots + LEVELS + 1
    stack = found + MOST + 1
    placed = stack + indices[DEPTH] + 2
    waiting = placed + 2 * S * SLOTS
    return Work(
        numbers[:asked],
        numbers[frames:poses].reshape(6 * SLOTS, 12),
        numbers[poses : poses + 2 * S * SLOTS * POSE].reshape(2 * S * SLOTS, POSE),
        numbers[asked:motion].reshape(K, 2),
        numbers[motion:bend],
        numbers[bend:spans],
        numbers[spans:swept].reshape(LEVELS, 2),
        numbers[swept:simplex],
        numbers[simplex:frames].reshape(11, 3),
        whole[:counts],
        whole[waiting : waiting + (LEVELS + 1) * K * MOST].reshape(LEVELS + 1, K * MOST),
        whole[counts:slots],
        whole[slots:found],
        whole[placed:waiting],
        whole[found:stack],
        whole[stack:placed],
    )
