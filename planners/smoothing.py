"""Smoothing: eliminate all configurations which are not useful to the path (Graux 1992, Smoothing)."""

from collections.abc import Sequence
from itertools import pairwise

from planners.arrays import Array
from planners.detector import Detector


def smooth(detector: Detector, configurations: Sequence[Array], saddles: Sequence[int] = ()) -> list[Array]:
    """Return a sub-sequence of `configurations` joined by certified segments, never longer than the original.

    configurations: N of shape (n,), consecutive ones joined by certified segments. saddles: indices of the
    saddle points among them, tried first. The detector's budget bounds the work: what it refuses is kept as
    it was.

    One pass of dichotomy is not idempotent, so passes repeat until nothing changes.
    """
    shortcuts = _Shortcuts(detector, configurations)
    kept = _through_saddles(shortcuts, len(configurations), saddles)
    changed = True
    while changed:
        shorter = _dichotomy(shortcuts, kept)
        changed = len(shorter) < len(kept)
        kept = shorter
    return [configurations[index] for index in kept]


class _Shortcuts:
    """Asks each shortcut between two of the original configurations only once."""

    def __init__(self, detector: Detector, configurations: Sequence[Array]) -> None:
        self._detector = detector
        self._configurations = configurations
        self._answers: dict[tuple[int, int], bool] = {}

    def free(self, i: int, j: int) -> bool:
        if (i, j) not in self._answers:
            a, b = self._configurations[i], self._configurations[j]
            self._answers[i, j] = self._detector.edge_is_free(a, b)
        return self._answers[i, j]


def _through_saddles(shortcuts: _Shortcuts, count: int, saddles: Sequence[int]) -> list[int]:
    """Join start, successive saddle points and goal directly where that is free; keep the rest."""
    anchors = sorted({0, *saddles, count - 1})
    kept = [0]
    for i, j in pairwise(anchors):
        kept += [j] if j == i + 1 or shortcuts.free(i, j) else range(i + 1, j + 1)
    return kept


def _dichotomy(shortcuts: _Shortcuts, indices: list[int]) -> list[int]:
    """From each kept configuration try the end; halve the range until the shortcut is free; keep; go on."""
    kept = [indices[0]]
    here = 0
    while here < len(indices) - 1:
        there = len(indices) - 1
        while there > here + 1 and not shortcuts.free(indices[here], indices[there]):
            there = here + (there - here) // 2
        kept.append(indices[there])
        here = there
    return kept
