"""From whole blocks to the few (stretch, piece) items that matter: the cheap half of the cover.

Blocks are cut into stretches short enough for boxes to be tight. Stretches meet clusters of pieces, then
pieces, each stage by axis-parallel boxes first and then by the solid's own face normals, which is what parts
the large solids (arms, columns, head) from a panel that is turned under them. What remains gets the pieces'
face normals.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from planners.arrays import Array
from robots.separation import IntArray, own_directions
from robots.verify_cover import Items
from robots.verify_pairs import PanelProblem, PanelView, Stretch, required

_TRAVEL = 0.2  # [m] longest stretch
_BULGE = 0.005  # [m] largest bulge of a stretch
_STRETCHES = 4_000  # per batch: about 20 MB of pairs with the clusters of a shell
_PIECES = 40_000  # items per batch


def near_items(problem: PanelProblem, blocks: IntArray, reach: Array) -> Iterator[tuple[Items, Array]]:
    """Items that may be closer than `reach` (B,) [m], with the best cheap bound, and their needed clearance.

    What is left out of the given blocks is proven to be at least `reach` apart.
    """
    stretches = cut(problem, blocks)
    for i in range(0, len(stretches), _STRETCHES):
        batch = stretches.take(slice(i, i + _STRETCHES))
        placed = problem.mover.stretch(batch)
        own = placed.start.R @ own_directions(problem.mover.solid).T
        tops = np.maximum(*placed.highest(own.transpose(0, 2, 1))) + placed.bulge[:, None]
        need = required(problem, batch, placed)
        row, cluster = _clusters_within(problem, batch, placed, own, tops, reach[batch.block])
        sizes = np.diff(problem.obstacles.first)[cluster]
        for part in _portions(sizes):
            within, piece = problem.obstacles.pieces_of(cluster[part])
            items, of = _pieces_within(problem, batch, placed, own, tops, row[part][within], piece, reach)
            yield items, need[of]


def cut(problem: PanelProblem, blocks: IntArray) -> Items:
    """Stretches that cover the whole of each block, with no obstacle yet."""
    whole = _stretches(blocks, np.zeros(len(blocks)), np.ones(len(blocks)))
    placed = problem.mover.stretch(whole)
    count = np.ceil(np.maximum(placed.travel / _TRAVEL, np.sqrt(placed.bulge / _BULGE))).astype(np.int64)
    count = np.maximum(count, 1)
    row = np.repeat(np.arange(len(blocks)), count)
    k = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    return _stretches(blocks[row], k / count[row], (k + 1) / count[row])


def _stretches(block: IntArray, s0: Array, s1: Array) -> Items:
    return Items(block, s0, s1, np.full(len(block), -1, dtype=np.int64), np.full(len(block), -np.inf))


def _clusters_within(
    problem: PanelProblem, batch: Items, placed: Stretch, own: Array, tops: Array, reach: Array
) -> tuple[IntArray, IntArray]:
    """Rows of `batch` and clusters that may be closer than reach (P,), as index pairs."""
    obstacles = problem.obstacles
    low, high = _box(placed)
    low, high = low - reach[:, None], high + reach[:, None]
    meet = np.ones((len(batch), len(obstacles.box_lower)), dtype=bool)
    for k in range(3):
        meet &= low[:, k, None] < obstacles.box_upper[None, :, k]
        meet &= high[:, k, None] > obstacles.box_lower[None, :, k]
    row, cluster = np.nonzero(meet)
    center = 0.5 * (obstacles.box_lower + obstacles.box_upper)
    half = 0.5 * (obstacles.box_upper - obstacles.box_lower)
    keep = np.ones(len(row), dtype=bool)
    for m in range(own.shape[2]):
        d = own[:, :, m]
        bottom = np.einsum("pj,pj->p", d[row], center[cluster]) - np.einsum(
            "pj,pj->p", np.abs(d)[row], half[cluster]
        )
        keep &= bottom - tops[row, m] < reach[row]
    return row[keep], cluster[keep]


def _pieces_within(
    problem: PanelProblem,
    batch: Items,
    placed: Stretch,
    own: Array,
    tops: Array,
    row: IntArray,
    piece: IntArray,
    reach: Array,
) -> tuple[Items, IntArray]:
    """The items of candidate (row, piece) pairs that may be within reach, and their rows."""
    obstacles = problem.obstacles
    limit = reach[batch.block]
    low, high = _box(placed)
    apart = np.maximum(low[row] - obstacles.upper[piece], obstacles.lower[piece] - high[row]).max(axis=1)
    keep = apart < limit[row]
    row, piece, apart = row[keep], piece[keep], apart[keep]
    along = obstacles.vertices[piece] @ own[row]
    best = np.maximum((along.min(axis=1) - tops[row]).max(axis=1), apart)
    keep = best < limit[row]
    row, piece, best = row[keep], piece[keep], best[keep]
    items = Items(batch.block[row], batch.s0[row], batch.s1[row], piece, best)
    view = PanelView(problem, items, placed.take(row))
    return items.raised(view.faces().max(axis=1)), row


def _box(placed: Stretch) -> tuple[Array, Array]:
    """Axis-parallel box of the whole stretch in the panel frame, (P, 3) each."""
    body = placed.mover.repeated(len(placed.bulge))
    (low0, high0), (low1, high1) = (body.moved(f.R, f.t).bounds() for f in (placed.start, placed.end))
    bulge = placed.bulge[:, None]
    return np.minimum(low0, low1) - bulge, np.maximum(high0, high1) + bulge


def _portions(sizes: IntArray) -> list[slice]:
    """Runs of clusters of about _PIECES pieces each."""
    total = np.cumsum(sizes)
    cuts = np.searchsorted(total, np.arange(_PIECES, total[-1] if len(total) else 0, _PIECES))
    edges = [0, *np.unique(cuts).tolist(), len(sizes)]
    return [slice(a, b) for a, b in pairwise(edges) if b > a]
