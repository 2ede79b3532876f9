"""The arrays of one call: the cell's numbers unpacked, and the work space.

A cell is handed over as two arrays, because every array costs a call some tenths of a microsecond; the work
space is two more, made once for many calls and never remembered from one to the next. The arrays are unpacked
without owner: numba counts references whenever an array is passed on, and for dozens of arrays and hundreds
of tree nodes that costs more than the geometry. The caller of `ask` holds the owners while it runs.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeVar

import numpy as np
from numba import types
from numba.extending import intrinsic
from numba.np.numpy_support import carray

from planners.arrays import Array
from planners.compiled import compiled
from robots.kernel.layout import (
    DEPTH,
    HEADER,
    MACHINE,
    N_CORNERS,
    N_NODES,
    N_PAIRS,
    N_PIECES,
    N_SOLIDS,
    PIECES,
    POSE,
    SOLIDS,
    TIP_PAIR,
    Ints,
)

Numbers = TypeVar("Numbers", Array, Ints)

LEVELS = 64
"""Pieces of an edge that may wait: 20 m are halved 20 times before a piece is too short to matter."""


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


class Work(NamedTuple):
    """Work space of one call.

    q (7,): configuration being asked about. frames, panel_poses, own_poses: see `poses`. motion (K,): bound
    of each pair. spans (LEVELS, 2), waiting (LEVELS, K), counts (LEVELS,): pieces of the edge that wait,
    each with its pairs. hints (K,): the piece that was too near last. placed (2, S): number of the placement
    each solid was last placed at, in both frames; now (1,): number of the present one. V, T, S, stack: of
    `within`.
    """

    q: Array
    frames: Array
    panel_poses: Array
    own_poses: Array
    motion: Array
    spans: Array
    V: Array
    T: Array
    S: Array
    waiting: Ints
    counts: Ints
    hints: Ints
    placed: Ints
    now: Ints
    stack: Ints


def _to_pointer(_: Any, address: Any, array: Any) -> Any:
    """The address as a pointer to values of the array's type; the array itself is not used."""
    pointer: Any = types.CPointer

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], context.get_value_type(signature.return_type))

    return pointer(array.dtype)(address, array), code


_pointer: Any = intrinsic(_to_pointer)


@compiled
def unowned(array: Numbers) -> Numbers:
    """The same array without reference count; the caller of the compiled code keeps the data alive."""
    view: Numbers = carray(_pointer(array.ctypes.data, array), array.shape)
    return view


@compiled
def views_of(numbers: Array, indices: Ints) -> Any:
    """Unpack what `flat.pack` has packed."""
    numbers, indices = unowned(numbers), unowned(indices)
    N, H, S = indices[N_NODES], indices[N_PIECES], indices[N_SOLIDS]
    P, K = indices[N_CORNERS], indices[N_PAIRS]
    boxes = MACHINE
    pieces = boxes + 6 * N
    solids = pieces + PIECES * H
    profiles = solids + SOLIDS * S
    needs = profiles + 2 * P
    always = needs + 2 * K
    kinds = HEADER + 2 * N
    pairs = kinds + 4 * S
    return Views(
        numbers[:MACHINE],
        numbers[boxes:pieces].reshape(N, 6),
        numbers[pieces:solids].reshape(H, PIECES),
        numbers[solids:profiles].reshape(S, SOLIDS),
        numbers[profiles:needs].reshape(P, 2),
        numbers[needs:always].reshape(K, 2),
        numbers[always : always + K],
        indices[HEADER:kinds].reshape(N, 2),
        indices[kinds:pairs].reshape(S, 4),
        indices[pairs : pairs + 2 * K].reshape(K, 2),
        indices[TIP_PAIR],
    )


def new_blocks(indices: Ints) -> tuple[Array, Ints]:
    """The two blocks of work space for a packed cell; one call at a time may use them."""
    S, K, depth = int(indices[N_SOLIDS]), int(indices[N_PAIRS]), int(indices[DEPTH])
    numbers = np.empty(7 + 72 + 2 * S * POSE + K + 2 * LEVELS + 24 + 12 + 33)
    return numbers, np.empty(LEVELS * K + LEVELS + K + 2 * S + 1 + depth + 2, dtype=np.int64)


@compiled
def work_of(numbers: Array, whole: Ints, indices: Ints) -> Any:
    """Unpack the blocks and forget what an earlier call left in them."""
    numbers, whole = unowned(numbers), unowned(whole)
    S, K = indices[N_SOLIDS], indices[N_PAIRS]
    panel_poses = 79
    own_poses = panel_poses + S * POSE
    motion = own_poses + S * POSE
    spans = motion + K
    V = spans + 2 * LEVELS
    counts = LEVELS * K
    hints = counts + LEVELS
    placed = hints + K
    now = placed + 2 * S
    for i in range(hints, now + 1):
        whole[i] = -1
    return Work(
        numbers[:7],
        numbers[7:panel_poses].reshape(6, 12),
        numbers[panel_poses:own_poses].reshape(S, POSE),
        numbers[own_poses:motion].reshape(S, POSE),
        numbers[motion:spans],
        numbers[spans:V].reshape(LEVELS, 2),
        numbers[V : V + 24].reshape(8, 3),
        numbers[V + 24 : V + 36].reshape(1, 12),
        numbers[V + 36 : V + 69].reshape(11, 3),
        whole[:counts].reshape(LEVELS, K),
        whole[counts:hints],
        whole[hints:placed],
        whole[placed:now].reshape(2, S),
        whole[now : now + 1],
        whole[now + 1 :],
    )
